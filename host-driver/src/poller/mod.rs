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
mod options;
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
pub use options::PollerOptions;
pub use outage::ReopenPolicy;
pub use overrides::{Commanding, Override, OverrideError};
pub use page_share::{PageShare, PageShareError};
pub use presence::{BoardState, PresencePolicy};
pub use readings::{BoardSensors, ElectronicsReading, Motion, SupplyPressure};
pub use row::{BoardRow, Event, Observer, Outcome, Reading, Row};
pub use schedule::{MissedTick, Pace};
pub use thread::{Monitor, Poller};
pub use vent::VentLatch;
