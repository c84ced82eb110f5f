//! From a recording and a rig to channels that can be simulated, and whether the recording can
//! carry a diagnosis.

mod check;
mod prepare;
mod shared_inputs;

pub use check::{AS_REGULATORS, check, much_missing};
pub use prepare::{Purpose, prepare, prepare_for};
