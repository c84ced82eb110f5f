//! What no effect explains: what it depends on, a smooth model of it, and how much it is.

pub mod adequacy;
mod discrepancy_model;
mod residual_test;
mod unexplained;

pub use residual_test::{Dependence, dependences, knots};
pub use unexplained::{Rest, corrected, correction_gain, imitated_beside, significant};
