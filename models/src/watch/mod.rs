//! A calibrated model beside the rig, row by row: says when something has changed, what, and since
//! when.
//!
//! ```text
//! rows -> bin       steps of 10 ms
//!      -> bank      one observer a channel, one more for each effect of the catalogue
//!      -> block     scores of 5 s
//!      -> baseline  what is usual, learnt first and ever on
//!      -> glr       has it changed?
//!      -> naming    what is it?
//! ```
//!
//! An observer is the simulation of a channel, led by the measured pressure so that it does not
//! drift. Beside the calibrated one runs one for every effect, with a probe of that effect: what
//! the two predict differently is the direction that the innovations would take. The memory of a
//! [`Watcher`] does not grow with time.

mod bank;
mod baseline;
mod bin;
mod block;
mod channel;
mod direction;
mod event;
mod explain;
mod glr;
mod history;
mod naming;
mod observer;
mod rows;
mod sample;
mod setup;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod usual;
mod watcher;
mod window;

pub use event::{Change, Explanation, Learnt, WatchEvent, Where};
pub use glr::THRESHOLD;
pub use rows::{Rows, columns_of, samples_of};
pub use sample::{Columns, Reading, Sample};
pub use setup::WatchError;
pub use watcher::{WatchSettings, Watcher};
