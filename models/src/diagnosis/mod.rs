//! Diagnosis: what the simulation gets wrong, why, and what modelling it gains.
//!
//! ```text
//! recording, rig -> prepare (channels, blocks) -> base (fitted first) -> search
//!     search: gate (scores of the whole catalogue) -> candidate (refits) -> stage, again until nothing passes
//! -> outcome (gain on test blocks, intervals, unexplained rest) -> report.json, report.html, extended.toml
//! ```

mod base;
mod blocks;
mod candidate;
mod channel;
mod check;
mod dependence;
mod error;
mod extended;
mod fit;
mod gain;
mod gate;
mod interval;
pub mod json;
pub mod page;
mod prepare;
mod random;
mod ripple;
mod run;
mod search;
mod stage;
mod verdict;
mod whiten;

pub use blocks::{Block, Role};
pub use channel::{ChannelData, Extended};
pub use dependence::{Dependence, Variable};
pub use error::DiagnosisError;
pub use extended::{ExtendedChannel, ExtendedFile};
pub use prepare::prepare;
pub use run::{Diagnosis, EXTENDED_FILE, diagnose};
pub use search::{Considered, Found, Outcome, Progress, search};
pub use stage::ChannelStage;
