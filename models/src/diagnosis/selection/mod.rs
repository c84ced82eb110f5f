//! Which effects are named: candidates refitted, raced, accepted, eliminated.

mod acceptance;
mod adopt;
mod candidate;
mod racing;
mod restart;
mod search;
mod selected;
mod warm_start;

pub use adopt::adopt;
pub use racing::Considered;
pub use search::{Outcome, Progress, search, staged};
pub use selected::{Found, Withheld};
