//! The pressure models: right-hand sides with their parameters, and nothing else.
//!
//! Pressures inside are absolute and in Pa; gauge pressures appear where a model is defined by them
//! (the linear one). All inputs are constant over one sample interval (see [`mod@column`]):
//! commands and drives because the board holds them, measured quantities by their mean over the
//! interval.

mod base;
pub mod column;
mod drive;
mod flow;
mod gas;
mod joint;
mod parameter;
mod ports;
mod valve;

pub use base::{BaseCoefficients, BaseModel};
pub use drive::Drive;
pub use flow::{FlowForm, FlowFunction};
pub use gas::{ATMOSPHERE_PA, GAMMA, Gas, psi_max};
pub use joint::Joint;
pub use linear::LinearCoefficients;
pub use nonlinear::NonlinearCoefficients;
pub use parameter::{Parameter, Scale, nominal_values};
pub use ports::{GeneralFlow, Ports};
pub use valve::{Areas, ValveDrive, ValveLaw, smooth_corner};

use crate::numeric::Scalar;

/// Declares the models, and `for_each_model`, which hands their names to another macro.
macro_rules! models {
    ($dollar:tt $($module:ident :: $name:ident,)*) => {
        $(
            mod $module;
            pub use $module::$name;
        )*

        /// Calls a macro with the names of all models.
        macro_rules! for_each_model {
            ($dollar callback:ident) => { $dollar callback!($($name),*); };
        }
        pub(crate) use for_each_model;
    };
}

// In the order of the paper that compares them (docs/models.md).
models! { $
    linear::Linear,
    nonlinear::Nonlinear,
    parametric::Parametric,
}

/// What files, reports and the command line say of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct About {
    /// Short name, the type's in lower case.
    pub id: &'static str,
    /// What it is, in a few words.
    pub title: &'static str,
    /// Does it describe a pressure loop along with the valve, driven by commands alone?
    pub is_regulator: bool,
}

/// What a rig says of a channel, for any model to take what it needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constants {
    /// The gas and its ambient pressure.
    pub gas: Gas,
    /// The ports' flow function.
    pub flow: FlowFunction,
    /// Discharge coefficient of the ports.
    pub discharge_coefficient: f64,
    /// One spool or two valves.
    pub drive: ValveDrive,
}

/// A model of the list above.
pub trait Listed: Model {
    /// What is said of it.
    const ABOUT: About;

    /// With a rig's constants.
    fn of(constants: &Constants) -> Self;
}

/// A model of one chamber: the rate of its pressure, and its parameters.
///
/// The work is split by how often it is needed: [`coefficients`](Model::coefficients) once per
/// simulation, [`hold`](Model::hold) once per sample, [`rate`](Model::rate) four times per
/// Runge-Kutta step.
pub trait Model: Send + Sync {
    /// What depends on the parameters only.
    type Coefficients<S: Scalar>: Copy + Send + Sync;

    /// What is constant over one sample interval.
    type Held<S: Scalar>: Copy;

    /// Short name used in files and reports.
    fn name(&self) -> &'static str;

    /// The parameters in the order in which [`coefficients`](Model::coefficients) takes their
    /// values.
    fn parameters(&self) -> Vec<Parameter>;

    /// Prepares the parameters, given in the units of [`parameters`](Model::parameters).
    fn coefficients<S: Scalar>(&self, parameters: &[S]) -> Self::Coefficients<S>;

    /// Prepares one interval. `row` is laid out as in [`mod@column`], but the drive is taken from
    /// `drive`: it depends on the parameters when a controller or an effect stands before the
    /// valve.
    fn hold<S: Scalar>(
        &self,
        coefficients: &Self::Coefficients<S>,
        row: &[S::Real],
        drive: Drive<S>,
    ) -> Self::Held<S>;

    /// Rate of the pressure in Pa/s at an absolute pressure in Pa.
    fn rate<S: Scalar>(&self, coefficients: &Self::Coefficients<S>, held: &Self::Held<S>, pressure: S) -> S;
}
