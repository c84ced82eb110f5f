//! One bus: its port, its poller, and what hangs on both.

use crate::args::Settings;
use crate::channel_names::ChannelNames;
use crate::failure::Failure;
use crate::gate::{CommandGate, Joint};
use crate::live::Live;
use crate::publish::PublishCounters;
use crate::tap::{State, Tap};
use pneudrive_host::bus::{Bus, BusOptions};
use pneudrive_host::notices::Notice;
use pneudrive_host::poller::{Observer, Pace, Poller, PollerOptions, SetPoints, VentLatch};
use pneudrive_protocol::Baud;
use pneudrive_record::Notes;
use pneudrive_record::watch::{Watch, WatchOptions};
use pneudrive_virtual::{VirtualBoards, VirtualOptions, is_sim};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::mpsc::Receiver;
use std::time::Duration;

/// A port that is open, nothing sent but what finds out whether it echoes.
pub struct OpenBus {
    bus: Bus,
    options: PollerOptions,
    port: String,
    first_joint: u16,
    /// Of the joints, in the poller's order.
    names: Vec<ChannelNames>,
    /// How long set points are good for when nobody renews them; 0 for ever.
    watchdog_ns: u64,
    /// The calibrated model beside it.
    watch: Option<WatchOptions>,
    virtual_boards: Option<VirtualBoards>,
}

/// A bus that is polled.
pub struct RunningBus {
    /// The port's path.
    pub port: String,
    /// Joint of the first board.
    pub first_joint: u16,
    /// On a thread of its own.
    pub poller: Poller,
    /// One for each board, in the poller's order.
    pub gates: Vec<Arc<CommandGate>>,
    /// Closed while 0 kPa is commanded whatever comes: after ~/vent, and when the port came back.
    /// ~/release opens it.
    pub vent: VentLatch,
    /// What the gates set. Whoever watches over them renews it, or the bus thread commands 0 kPa.
    pub set_points: SetPoints,
    /// States that found no room on their way to the publisher.
    pub dropped: Arc<AtomicU64>,
    /// What became of the others.
    pub published: Arc<PublishCounters>,
    /// The calibrated model beside it. Ends after the poller.
    pub watch: Option<Watch>,
    /// To be kept until the poller has ended.
    pub virtual_boards: Option<VirtualBoards>,
}

impl OpenBus {
    /// Opens the port at `index` in the settings.
    pub fn open(settings: &Settings, index: usize, first_joint: u16) -> Result<Self, Failure> {
        let flags = &settings.flags;
        let devices = settings.devices(index);
        let baud = Baud::new(settings.baud().first()).map_err(Failure::input)?;
        let fastest = Baud::new(settings.baud().fastest()).map_err(Failure::input)?;
        let limit_hz = fastest.cycle_limit_hz(devices.into());
        /// What robots' control loops run at.
        const USUAL_HZ: f64 = 1_000.0;
        let pace = match flags.rate_hz {
            Some(rate_hz) if rate_hz > limit_hz => {
                return Err(Failure::input(format!(
                    "--rate-hz {rate_hz}: the wire allows {limit_hz:.1} Hz for {devices} board(s) at {} baud",
                    fastest.get()
                )));
            }
            None if limit_hz < USUAL_HZ => Pace::AsFastAsPossible,
            rate_hz => {
                let period_ns = (1e9 / rate_hz.unwrap_or(USUAL_HZ)).round() as u64;
                Pace::every(Duration::from_nanos(period_ns))
            }
        };
        let bus_options = BusOptions::default().baud(baud).answer_allowance(flags.allowance());
        let bus_options =
            bus_options.calibrated(&settings.calibration, &PollerOptions::for_devices(devices).boards);
        let port = &flags.port[index];
        let virtual_boards = is_sim(port).then(|| VirtualBoards::start(&VirtualOptions::new(devices, baud)));
        let virtual_boards = virtual_boards.transpose()?;
        let port = virtual_boards.as_ref().map_or(port.as_path(), VirtualBoards::path).to_owned();
        let bus = Bus::open(&port, bus_options).map_err(|error| match error {
            pneudrive_host::bus::OpenBusError::Port(error) => Failure::input(error),
            other => Failure::running(other),
        })?;
        let options = PollerOptions::for_devices(devices)
            .pace(pace)
            .calibration(settings.calibration.clone())
            .limits(settings.limits.clone())
            .resume(flags.resume)
            .line_rate(settings.baud().policy())
            .sensors(flags.sensors);
        let port = port.display().to_string();
        let watchdog_ns = (flags.watchdog_s * 1e9).round() as u64;
        let of =
            |&board: &u8| ChannelNames::new(first_joint + u16::from(board), settings.rig.as_ref(), board);
        let names = options.boards.iter().map(of).collect();
        let watched = |parameters| WatchOptions::new(parameters).program(flags.watch_program.clone());
        let watch = flags.watch.get(index).map(watched);
        Ok(Self { bus, options, port, first_joint, names, watchdog_ns, watch, virtual_boards })
    }

    /// Numbers of its boards.
    pub fn boards(&self) -> &[u8] {
        &self.options.boards
    }

    /// Joint of the first board.
    pub fn first_joint(&self) -> u16 {
        self.first_joint
    }

    /// What its joints and their channels are called, in the poller's order.
    pub fn names(&self) -> &[ChannelNames] {
        &self.names
    }

    /// Starts polling. States come out of the receiver; what the watch finds is logged, and added
    /// to `notes`.
    pub fn start(
        self,
        live: &Arc<Live>,
        more: impl IntoIterator<Item = Box<dyn Observer>>,
        notes: Notes,
    ) -> Result<(RunningBus, Receiver<State>), Failure> {
        let set_points = SetPoints::new(self.options.boards.len());
        let set_points = match self.watchdog_ns {
            0 => set_points,
            watchdog_ns => set_points.vent_after(Duration::from_nanos(watchdog_ns)),
        };
        let joint = |(index, &board): (usize, &u8)| Joint {
            names: self.names[index].clone(),
            board,
            index,
            limits: self.options.limits.clone(),
            scales: self.options.calibration.of(board),
        };
        let joints = self.options.boards.iter().enumerate().map(joint);
        let gates = joints.map(|joint| Arc::new(CommandGate::new(set_points.clone(), joint))).collect();
        let vent = self.options.vent.clone();
        let (tap, states, dropped) = Tap::new(Arc::clone(live), self.options.calibration.clone());
        let watch = self.watch.as_ref().map(|options| {
            let port = self.port.clone();
            let tell = move |notice: Notice| {
                match notice.kind.is_warning() {
                    true => log::warn!("{port}: {}", notice.text),
                    false => log::info!("{port}: {}", notice.text),
                }
                notes.add(notice);
            };
            Watch::start(options, &self.options.boards, &self.options.calibration, tell)
        });
        let watch = watch.transpose().map_err(|error| Failure::input(format!("--watch: {error}")))?;
        let (watch, watching) = watch.map_or((None, None), |(watch, tap)| (Some(watch), Some(tap)));
        let own = std::iter::once(Box::new(tap) as Box<dyn Observer>);
        let observers = own.chain(more).chain(watching).collect();
        let poller = Poller::start(self.bus, self.options, Box::new(set_points.clone()), observers)
            .map_err(Failure::running)?;
        let published = Arc::default();
        let running = RunningBus {
            port: self.port,
            first_joint: self.first_joint,
            poller,
            gates,
            vent,
            set_points,
            dropped,
            published,
            watch,
            virtual_boards: self.virtual_boards,
        };
        Ok((running, states))
    }
}
