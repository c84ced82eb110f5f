//! Fitting: sensitivities, weighted least squares, the base model, one effect with all the rest.

mod base;
mod effect;
mod finite_difference;
mod frozen_jacobian;
mod least_squares;
mod linearization;
mod objective;
mod sensitivity;

pub use base::{
    CORNER, EDGES, GAINS, LEAK, fit_base, fit_base_from, free_base, free_of, gain_of, is_astray, plain_cost,
    plain_costs, refit_by_own_weights, rounded, start, with_usual,
};
pub use effect::fit_from;
pub use frozen_jacobian::{refit_near, refit_with};
pub use least_squares::refit;
pub use linearization::{ChannelStage, models_of};
pub use objective::{BlockObjective, normal_equations};
