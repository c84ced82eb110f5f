//! A poller in a few words.

use super::{
    CommandSource, Limits, Observer, Pace, Poller, PollerOptions, Row, SetPoints, StartError, VENTED,
};
use crate::Calibration;
use crate::bus::Bus;
use crate::line::Line;
use std::time::Duration;

/// Makes a [`Poller`]: begun by [`Poller::builder`].
///
/// ```no_run
/// use pneudrive_host::bus::{Bus, BusOptions};
/// use pneudrive_host::poller::{Poller, SetPoints};
/// use pneudrive_host::pneudrive_protocol::SensorScale;
/// use std::time::Duration;
///
/// let bus = Bus::open("/dev/ttyUSB0", BusOptions::default())?;
/// let set_points = SetPoints::new(4).vent_after(Duration::from_millis(200));
/// let poller = Poller::builder(bus)
///     .boards(0..4)
///     .rate_hz(500.0)
///     .set_points(set_points.clone())
///     .observe(|row| println!("{:?}", row.boards[0].reading))
///     .start()?;
/// // At least every 200 ms, or all boards vent.
/// set_points.set(0, [SensorScale::ORIGINAL.counts(100.0)?; 4])?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PollerBuilder<L: Line> {
    bus: Bus<L>,
    options: PollerOptions,
    rate_hz: Option<f64>,
    source: Box<dyn CommandSource>,
    observers: Vec<Box<dyn Observer>>,
}

impl<L: Line + Send + 'static> Poller<L> {
    /// Begins a poller of this bus: of no boards yet, as fast as possible, with 0 kPa for all of
    /// them.
    pub fn builder(bus: Bus<L>) -> PollerBuilder<L> {
        PollerBuilder {
            bus,
            options: PollerOptions::for_devices(0),
            rate_hz: None,
            source: Box::new(Vented),
            observers: Vec::new(),
        }
    }
}

impl<L: Line + Send + 'static> PollerBuilder<L> {
    /// The boards that are polled, in this order.
    #[must_use]
    pub fn boards(mut self, numbers: impl IntoIterator<Item = u8>) -> Self {
        self.options.boards = numbers.into_iter().collect();
        self
    }

    /// Polls all boards so many times a second, Hz, 0.1 to 10,000; starts that were missed are left
    /// out. Without it: as fast as possible.
    #[must_use]
    pub fn rate_hz(mut self, rate_hz: f64) -> Self {
        self.rate_hz = Some(rate_hz);
        self
    }

    /// Commands these set points, which any thread may change.
    #[must_use]
    pub fn set_points(self, set_points: SetPoints) -> Self {
        self.commands(set_points)
    }

    /// Commands what this source gives: a trajectory, or one's own.
    #[must_use]
    pub fn commands(mut self, source: impl CommandSource + 'static) -> Self {
        self.source = Box::new(source);
        self
    }

    /// Highest set points and fastest changes.
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Self {
        self.options.limits = limits;
        self
    }

    /// What counts mean.
    #[must_use]
    pub fn calibration(mut self, calibration: impl Into<Calibration>) -> Self {
        self.options.calibration = calibration.into();
        self
    }

    /// Shows every row to this, on the bus thread: it must not block.
    #[must_use]
    pub fn observe(self, see: impl FnMut(&Row<'_>) + Send + 'static) -> Self {
        self.observer(Box::new(Seen(see)))
    }

    /// Shows rows and events to this: a recorder's tap, say.
    #[must_use]
    pub fn observer(mut self, observer: Box<dyn Observer>) -> Self {
        self.observers.push(observer);
        self
    }

    /// Changes any other option.
    #[must_use]
    pub fn options(mut self, change: impl FnOnce(&mut PollerOptions)) -> Self {
        change(&mut self.options);
        self
    }

    /// Starts polling on a thread of its own.
    ///
    /// # Errors
    /// No boards, an unusable rate, no thread, real time refused: see [`StartError`].
    pub fn start(mut self) -> Result<Poller<L>, StartError> {
        if self.options.boards.is_empty() {
            return Err(StartError::NoBoards);
        }
        if let Some(rate_hz) = self.rate_hz {
            if !(0.1..=10_000.0).contains(&rate_hz) {
                return Err(StartError::Rate(rate_hz));
            }
            self.options.pace = Pace::every(Duration::from_secs_f64(1.0 / rate_hz));
        }
        Poller::start(self.bus, self.options, self.source, self.observers)
    }
}

/// What is commanded where nobody says otherwise.
struct Vented;

impl CommandSource for Vented {
    fn fill(&mut self, _: u64, commands: &mut [super::BoardCommand]) -> super::SourceStatus {
        commands.fill(VENTED);
        super::SourceStatus::Continues
    }
}

/// A closure that sees rows.
struct Seen<F>(F);

impl<F: FnMut(&Row<'_>) + Send> Observer for Seen<F> {
    fn row(&mut self, row: &Row<'_>) {
        (self.0)(row);
    }
}
