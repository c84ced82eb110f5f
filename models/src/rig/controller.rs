//! `[controller]`: the pressure loop that runs on the board, in 10-bit counts.

pub use crate::board::Controller;
