//! What faults cost, and that nothing wrong is believed or obeyed: the table of
//! docs/reliability.md.
//!
//! ```text
//!  host's poller -- TappedLine -- virtual bus with faults -- SpiedBoard -- native board,
//!                       |                                        |       or emulated chip
//!                       +----------------- Truth ----------------+
//! ```
//!
//! Commands and pressures change in every cycle, so that an old or a crossed value shows. What the
//! host sent and what the boards said is noted where it leaves them, before any fault; what the
//! boards obeyed and what the host believed is compared with that.

mod air;
mod board;
mod cases;
mod host;
mod page;
mod run;
mod strangers;
mod truth;

pub use cases::{Case, cases};
pub use host::{NewEveryCycle, TappedLine};
pub use page::{HEADER, row, written_into};
pub use run::{Boards, Outcome, Setting, faulty_rig, meet, run};
pub use strangers::{Met, STRANGERS_HEADER, Speech, Stranger, strangers_row, strangers_written_into};
pub use truth::{SharedTruth, Truth};
