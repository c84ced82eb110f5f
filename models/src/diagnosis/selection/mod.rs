//! Which effects are named: candidates refitted, raced, accepted, eliminated.

mod acceptance;
mod adopt;
mod candidate;
mod chance;
mod elimination;
mod entrants;
mod racing;
mod restart;
mod search;
mod selected;
mod settling;
mod warm_start;

pub use acceptance::{is_shown, roughly_timed};
pub use adopt::adopt;
pub use candidate::Candidate;
pub use racing::Considered;
pub use search::{Outcome, Progress, harms, search};
pub use selected::{Found, Withheld};
pub use settling::staged;
