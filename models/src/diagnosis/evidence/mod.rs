//! How well explanations predict what they were not fitted to, and how probable that makes them.
//!
//! `lasting` is the density of residuals as noise and a discrepancy that lasts, `predicted` what
//! the models of a recording are worth by it, `weights` the probabilities that follow,
//! `explanation` the names of what is weighed.

mod explanation;
mod lasting;
mod predicted;
mod weights;

pub use explanation::{Explanation, Missing, Weighed, evidence, weigh};
pub use predicted::{Evidence, Predicted};
pub use weights::probabilities;
