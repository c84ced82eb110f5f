//! The calibrated model beside a run: `pneudrive-model watch` as a program of its own, which gets
//! every row and says what has changed.
//!
//! ```text
//!  bus thread ──batches──▶ a thread ──CSV──▶ pneudrive-model watch - --json
//!                    notices, state ◀── a thread ◀──lines──┘
//! ```
//!
//! A program of its own, because the bus and the models know nothing of each other, and a model
//! that fails is to cost no row of the bus. The bus thread never waits for it: rows that it is too
//! slow for are left out, and it is told so.

mod error;
mod line;
mod process;
mod program;
mod state;
mod tap;

pub use error::WatchError;
pub use process::{Watch, WatchOptions};
pub use state::{LatestChange, WatchState, WatchStatus};
