//! Diagnosis: what the simulation gets wrong, why, and what modelling it gains.
//!
//! ```text
//! recording, rig -> prepare (channels, blocks) -> base (fitted first) -> search
//!     search: gate (scores of the whole catalogue) -> candidate (refits) -> stage, again until nothing passes
//! -> outcome (gain on test blocks, intervals, unexplained rest) -> experiment (what would settle a tie)
//! -> report.json, report.html, extended.toml, next_experiment.csv
//! ```

mod adequacy;
mod adopt;
mod afresh;
mod base;
mod beside;
mod blocks;
mod borrow;
mod candidate;
mod causes;
mod channel;
mod check;
mod chord;
mod common;
mod correction;
mod dependence;
mod disturbance;
mod earned;
mod effect_fit;
mod error;
mod experiment;
mod extended;
mod fit;
mod found;
mod gain;
mod gate;
mod hunting;
mod interval;
pub mod json;
mod likelihood;
mod losses;
mod neighbours;
mod noise;
mod octaves;
pub mod page;
mod prepare;
mod probe;
mod random;
mod rest;
mod ripple;
mod rollouts;
mod round;
mod run;
mod search;
mod secant;
mod simulation;
mod stage;
mod steps;
mod template;
#[cfg(test)]
mod testing;
mod validate;
mod verdict;
mod whiten;
mod worth;

pub use blocks::{Block, Role};
pub use channel::{ChannelData, Extended};
pub use correction::Correction;
pub use dependence::{Dependence, Variable};
pub use error::DiagnosisError;
pub use experiment::{Excitation, NOTHING, Plan, TRAJECTORY_FILE};
pub use extended::{ExtendedChannel, ExtendedFile, SCHEMA as EXTENDED_SCHEMA};
pub use found::{Found, Withheld};
pub use prepare::{Purpose, prepare, prepare_for};
pub use rollouts::{ExtendedGradient, ExtendedRollouts};
pub use round::Considered;
pub use run::{Diagnosis, EXTENDED_FILE, Request, diagnose};
pub use search::{Outcome, Progress, search};
pub use simulation::{SimulatedChannel, simulate_extended};
pub use stage::ChannelStage;
