//! The likelihood of a recording under a model that is not exactly right.
//!
//! ```text
//! filter (prediction errors) -> posterior (their density, priors) -> scoring (its maximum)
//!        -> ranking (the catalogue, by it) -> naming
//! ```
//!
//! What the model lacks is a slow deviation of the reading and a slow wander of the supply, both
//! estimated along with the pressure by a Kalman filter (M. C. Kennedy and A. O'Hagan, J. R. Stat.
//! Soc. B 63, 2001: without such a term a wrong model's parameters move to imitate what it lacks).
//! Every effect of the catalogue is fitted in earnest from several finite sizes: where much is
//! missing, what a derivative at the base model promises is no guide.

mod filter;
mod kalman;
mod naming;
mod posterior;
mod ranking;
mod scoring;
mod starts;
mod steered;
mod uncertainty;

pub use naming::{Named, NamedEffect, name};

#[cfg(test)]
mod tests;
