//! All boards in turn, on a thread of their own.
//!
//! ```text
//!   SetPoints / Trajectory ──fill──▶ ┌────────────┐ ──row, event──▶ observers: Latest, Recorder, ROS, ...
//!                                    │ bus thread │
//!                 stop, statistics ─▶└────────────┘ ◀──bytes──▶ boards
//! ```
//!
//! Nobody holds a lock that the bus thread waits for: set points are atomics, the newest row is left in whichever of two places
//! nobody reads, and observers must not block.

mod commands;
mod cycle;
mod ending;
mod filter;
mod latest;
mod outage;
mod overrides;
mod presence;
mod row;
mod schedule;
mod thread;

pub use commands::{BoardCommand, CommandSource, NoSuchBoard, SetPoints, Supply, VENTED};
pub use cycle::Polling;
pub use filter::{FilterError, PressureFilter};
pub use latest::{Latest, Snapshot};
pub use outage::ReopenPolicy;
pub use overrides::{Commanding, Override, OverrideError};
pub use presence::{BoardState, PresencePolicy};
pub use row::{BoardRow, Event, Observer, Outcome, Reading, Row};
pub use schedule::{MissedTick, Pace};
pub use thread::{Finished, Monitor, Poller};

use crate::real_time::RealTime;
use pneudrive_protocol::SensorScale;

/// Settings of a poller.
#[derive(Debug, Clone)]
pub struct PollerOptions {
    /// Numbers of the boards, in the order in which they are asked.
    pub boards: Vec<u8>,
    /// How often.
    pub pace: Pace,
    /// What pressures mean.
    pub scale: SensorScale,
    /// Low-pass on the pressures in [`Reading::kpa`]; recordings hold what the boards sent.
    pub filter: Option<PressureFilter>,
    /// When a board counts as missing.
    pub presence: PresencePolicy,
    /// Whether to go on when the line has failed and comes back (an adapter that was unplugged); `None` ends the poller. While the
    /// line is gone its boards are missing, and vent by their own command timeout. When it is back they get the commands
    /// of that time.
    pub reopen: Option<ReopenPolicy>,
    /// What the bus thread asks of the scheduler; nothing by default.
    pub real_time: RealTime,
}

impl PollerOptions {
    /// Boards 0 to `devices - 1`, as fast as possible, unfiltered; goes on when a lost line comes back.
    pub fn for_devices(devices: u16) -> Self {
        Self {
            boards: (0..=u8::MAX).take(usize::from(devices)).collect(),
            pace: Pace::default(),
            scale: SensorScale::ORIGINAL,
            filter: None,
            presence: PresencePolicy::default(),
            reopen: Some(ReopenPolicy::default()),
            real_time: RealTime::default(),
        }
    }
}
