//! One channel under diagnosis: its measured inputs, its model, its simulation, and channels
//! together.

mod correction;
mod coupled;
mod data;
mod lanes;
mod model;
mod neighbours;
mod resolution;
mod split;
mod variable;

pub use crate::effects::NARROW;
pub use correction::Correction;
pub use coupled::{settled, share_draws};
pub use data::{ChannelData, compared_rows, rows_of};
pub use lanes::readings_of;
pub use model::Extended;
pub use neighbours::Pressures;
pub use resolution::{LONGEST_STEP_S, Steps, halved, simulate_coarsely, simulate_finer};
pub use split::{Block, OPEN, Role, anchors, block_length_s, split};
pub use variable::hats;
pub use variable::{HATS, Variable};
