//! Recordings looked at again: what a live view and the page show, without a bus.
//!
//! ```text
//!   recording ──rows──▶ Player ──newest row──▶ Latest ──Monitor──▶ terminal view, page
//! ```
//!
//! [`pneudrive-record`](../../pneudrive_record/index.html) reads rows from files.

mod figures;
mod moment;
mod player;
mod row;

pub use player::{PlayOptions, Player};
pub use row::{RecordedBoard, RecordedRow};
