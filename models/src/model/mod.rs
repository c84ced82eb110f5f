//! The pressure models: right-hand sides with their parameters, and nothing else.
//!
//! Pressures inside are absolute and in Pa; gauge pressures appear where a model is defined by them (the linear one).
//! All inputs are constant over one sample interval (see [`mod@column`]): commands and drives because the board holds them,
//! measured quantities by their mean over the interval.

mod base;
pub mod column;
mod drive;
mod flow;
mod gas;
mod joint;
mod linear;
mod nonlinear;
mod parameter;
mod parametric;
mod ports;
mod valve;

pub use base::{BaseCoefficients, BaseModel};
pub use drive::Drive;
pub use flow::{FlowForm, FlowFunction};
pub use gas::{ATMOSPHERE_PA, GAMMA, Gas, psi_max};
pub use joint::Joint;
pub use linear::{Linear, LinearCoefficients};
pub use nonlinear::{Nonlinear, NonlinearCoefficients};
pub use parameter::{Parameter, Scale, nominal_values};
pub use parametric::Parametric;
pub use ports::Ports;
pub use valve::{Areas, ValveDrive, ValveLaw, smooth_corner};

use crate::numeric::Scalar;

/// A model of one chamber: the rate of its pressure, and its parameters.
///
/// The work is split by how often it is needed: [`coefficients`](Model::coefficients) once per simulation,
/// [`hold`](Model::hold) once per sample, [`rate`](Model::rate) four times per Runge-Kutta step.
pub trait Model: Send + Sync {
    /// What depends on the parameters only.
    type Coefficients<S: Scalar>: Copy + Send + Sync;

    /// What is constant over one sample interval.
    type Held<S: Scalar>: Copy;

    /// Short name used in files and reports.
    fn name(&self) -> &'static str;

    /// The parameters in the order in which [`coefficients`](Model::coefficients) takes their values.
    fn parameters(&self) -> Vec<Parameter>;

    /// Prepares the parameters, given in the units of [`parameters`](Model::parameters).
    fn coefficients<S: Scalar>(&self, parameters: &[S]) -> Self::Coefficients<S>;

    /// Prepares one interval. `row` is laid out as in [`mod@column`], but the drive is taken from `drive`: it depends on the
    /// parameters when a controller or an effect stands before the valve.
    fn hold<S: Scalar>(
        &self,
        coefficients: &Self::Coefficients<S>,
        row: &[S::Real],
        drive: Drive<S>,
    ) -> Self::Held<S>;

    /// Rate of the pressure in Pa/s at an absolute pressure in Pa.
    fn rate<S: Scalar>(&self, coefficients: &Self::Coefficients<S>, held: &Self::Held<S>, pressure: S) -> S;
}
