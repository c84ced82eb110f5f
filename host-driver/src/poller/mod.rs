//! All boards in turn, on a thread of their own.
//!
//! ```text
//!   SetPoints / Trajectory ──fill──▶ ┌────────────┐ ──row, event──▶ observers:
//!                                    │ bus thread │                   Latest, Recorder, ROS ..
//!                 stop, statistics ─▶└────────────┘ ◀──bytes──▶ boards
//! ```
//!
//! Nobody holds a lock that the bus thread waits for: set points are atomics, the newest row is
//! left in whichever of two places nobody reads, and observers must not block.

mod baud_choice;
mod builder;
mod commands;
mod cycle;
mod drives;
mod ending;
mod errors;
mod filter;
mod finished;
mod latest;
mod limits;
mod line_rate;
mod outage;
mod overrides;
mod page_share;
mod presence;
mod readings;
mod row;
mod schedule;
mod sensors;
mod slew;
mod thread;
mod vent;
mod visit;

pub use baud_choice::{BaudChoice, BaudChoiceError};
pub use builder::PollerBuilder;
pub use commands::{BoardCommand, CommandSource, NoSuchBoard, SetPoints, SourceStatus, VENTED};
pub use cycle::Polling;
pub use drives::DriveReading;
pub use errors::{PollerPanicked, StartError};
pub use filter::{FilterError, PressureFilter};
pub use finished::{Conclusion, Finished};
pub use latest::{Latest, Snapshot};
pub use limits::{AboveLimit, ChannelLimit, LimitError, Limits};
pub use line_rate::LineRatePolicy;
pub use outage::ReopenPolicy;
pub use overrides::{Commanding, Override, OverrideError};
pub use page_share::{PageShare, PageShareError};
pub use presence::{BoardState, PresencePolicy};
pub use readings::{BoardSensors, ElectronicsReading, Motion, SupplyPressure};
pub use row::{BoardRow, Event, Observer, Outcome, Reading, Row};
pub use schedule::{MissedTick, Pace};
pub use slew::{Slew, SlewOptions};
pub use thread::{Monitor, Poller};
pub use vent::VentLatch;

use crate::Calibration;
use crate::real_time::RealTime;

/// Settings of a poller.
#[derive(Debug, Clone)]
pub struct PollerOptions {
    /// Numbers of the boards, in the order in which they are asked.
    pub boards: Vec<u8>,
    /// How often.
    pub pace: Pace,
    /// What counts mean.
    pub calibration: Calibration,
    /// Low-pass on the pressures in [`Reading::kpa`]; recordings hold what the boards sent.
    pub filter: Option<PressureFilter>,
    /// When a board counts as missing.
    pub presence: PresencePolicy,
    /// Whether to go on when the line has failed and comes back (an adapter that was unplugged);
    /// `None` ends the poller. While the line is gone its boards are missing, and vent by their own
    /// command timeout (those of the original kind have none).
    pub reopen: Option<ReopenPolicy>,
    /// What happens when the line is back: `false` closes [`vent`](Self::vent), so that the boards
    /// stay at 0 kPa until somebody releases them; `true` returns to the set points of that time,
    /// by a ramp.
    pub resume: bool,
    /// Closed by whoever wants all boards at 0 kPa.
    pub vent: VentLatch,
    /// Highest set points and fastest changes.
    pub limits: Limits,
    /// Fastest rise of a set point after a pause, kPa/s: see [`Slew`].
    pub return_rate_kpa_s: f64,
    /// After which share of its polls a board is asked for its valves' drives as well; `None`, the
    /// default, for none. Each such request takes the bus as long as a poll.
    pub drives: Option<PageShare>,
    /// After which share of its polls a board is asked for a page of the sensors on its I2C
    /// connector as well; `None`, the default, for none. What it has is asked for in turn: the
    /// supply pressure takes a page, an IMU two.
    pub sensors: Option<PageShare>,
    /// Whether to ask the boards for a faster line rate; `None`, the default, is not.
    pub line_rate: Option<LineRatePolicy>,
    /// What the bus thread asks of the scheduler; nothing by default.
    pub real_time: RealTime,
}

impl PollerOptions {
    /// A chamber that is to return to 300 kPa does so in 3 s: slow enough to step back from, fast
    /// enough not to be waited for.
    pub const RETURN_RATE_KPA_S: f64 = 100.0;

    /// What a board's [`Slew`] is made of. `timeout_ns` is how long an answer is waited for: where
    /// boards are missing, a cycle takes as many of them, and is no pause of the others.
    pub(crate) fn slew(&self, board: u8, timeout_ns: u64) -> Slew {
        let period_ns = match self.pace {
            Pace::AsFastAsPossible => 0,
            Pace::Every { period_ns, .. } => period_ns,
        };
        let period_ns = period_ns.max(timeout_ns.saturating_mul(self.boards.len() as u64));
        let options = SlewOptions {
            scales: self.calibration.of(board),
            vent: self.calibration.vent(&self.boards),
            return_rate_kpa_s: self.return_rate_kpa_s,
            period_ns,
        };
        Slew::new(self.limits.of(board), options)
    }

    /// Boards 0 to `devices - 1`, as fast as possible, unfiltered; goes on when a lost line comes
    /// back.
    pub fn for_devices(devices: u16) -> Self {
        Self {
            boards: (0..=u8::MAX).take(usize::from(devices)).collect(),
            pace: Pace::default(),
            calibration: Calibration::default(),
            filter: None,
            presence: PresencePolicy::default(),
            reopen: Some(ReopenPolicy::default()),
            resume: false,
            vent: VentLatch::default(),
            limits: Limits::default(),
            return_rate_kpa_s: Self::RETURN_RATE_KPA_S,
            drives: None,
            sensors: None,
            line_rate: None,
            real_time: RealTime::default(),
        }
    }
}
