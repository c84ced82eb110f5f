//! A recording at a glance: one page that says what was commanded, what was measured, what was lost
//! and what happened.
//!
//! ```text
//!  Loaded ──▶ channel (figures of one channel) ──▶ tables ─┐
//!  events ──▶ plots (one set per board) ───────────────────┴─▶ page
//! ```

mod channel;
mod page;
mod plots;

pub use channel::{ChannelFigures, figures};
pub use page::{first_board, recording_page};
