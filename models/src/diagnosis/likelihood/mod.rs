//! How likely readings are, given a simulation: noise, what wanders, and loops that hunt.

mod covariance;
mod deviance;
mod haar;
mod likelier;
pub mod limit_cycle;
mod random_effects;
mod residuals;

pub use covariance::{WANDERS, Whitening, wander};
pub use deviance::{Losses, least_gain, row_count, select_total, together, together_by, total};
pub use likelier::{deviances, likelier};
pub use limit_cycle::{Expected, at_rest, hunts, is_hunting};
pub use random_effects::{DISTURBANCES, FLOWS, SINES};
pub use residuals::{block_losses, whitened_residuals};
