//! Diagnosis: what the simulation gets wrong, why, and what modelling it gains.
//!
//! ```text
//! recording, rig
//!   -> preconditions  channels with inputs, blocks and noise; can the recording carry a diagnosis?
//!   -> estimation     the base model of every channel, fitted by the likelihood
//!   -> screening      a score test of the whole catalogue
//!   -> selection      candidates refitted, the best named, again until nothing passes
//!   -> greybox        the catalogue by a filter's likelihood, far from any base model
//!   -> discrepancy    what is left, what it depends on, a smooth model of it
//!   -> inference      intervals of sizes
//!   -> report, design  report.json, report.html, extended.toml; next_experiment.csv
//! ```
//!
//! Below all of them lie `channel` (what is simulated), `likelihood` (how residuals are weighed)
//! and `evidence` (how probable explanations are). Imports go one way only: a folder uses those
//! above it in this list, and these three.

mod channel;
mod design;
mod discrepancy;
mod error;
mod estimation;
mod evidence;
mod greybox;
mod holdout;
mod inference;
pub mod json;
mod likelihood;
pub mod machine;
pub mod page;
mod preconditions;
mod report;
mod resampling;
mod rollout_errors;
mod rollouts;
mod run;
mod screening;
mod second_opinion;
mod selection;
pub mod settings;
mod simulation;
pub mod tables;
mod template;
#[cfg(test)]
pub mod testing;

pub use channel::{Block, ChannelData, Correction, Extended, Role, Variable};
pub use design::{Excitation, NOTHING, Plan, TRAJECTORY_FILE};
pub use discrepancy::Dependence;
pub use error::DiagnosisError;
pub use estimation::ChannelStage;
pub use inference::band::{Band, rates_kpa_s};
pub use preconditions::{AS_REGULATORS, Purpose, prepare, prepare_for};
pub use report::{EXTENDED_SCHEMA, ExtendedChannel, ExtendedFile};
pub use rollouts::ExtendedRollouts;
pub use run::{Diagnosis, EXTENDED_FILE, Request, diagnose};
pub use selection::{Considered, Found, Outcome, Progress, Withheld, search};
pub use simulation::{SimulatedChannel, simulate_extended};
