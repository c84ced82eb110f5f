//! `[controller]`: the pressure loop that runs on the board, in 10-bit counts.

pub use pneudrive_plant::board::Controller;
