//! The model that effects are added to: one of those that describe a valve or a regulator.

use super::{Gas, Linear, LinearCoefficients, Model, Nonlinear, NonlinearCoefficients, Parameter};
use crate::numeric::Scalar;

/// Which model, with its constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BaseModel {
    /// Valve and chamber.
    Nonlinear(Nonlinear),
    /// Regulator with its own loop.
    Linear(Linear),
}

/// What the parameters of a [`BaseModel`] say.
#[derive(Debug, Clone, Copy)]
pub enum BaseCoefficients<S> {
    /// Of a valve and its chamber.
    Nonlinear(NonlinearCoefficients<S>),
    /// Of a regulator.
    Linear(LinearCoefficients<S>),
}

impl BaseModel {
    /// Short name used in files and reports.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Nonlinear(model) => model.name(),
            Self::Linear(model) => model.name(),
        }
    }

    /// The parameters, in the order in which [`coefficients`](Self::coefficients) takes their
    /// values.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        match self {
            Self::Nonlinear(model) => model.parameters(),
            Self::Linear(model) => model.parameters(),
        }
    }

    /// Prepares the parameters, given in the units of [`parameters`](Self::parameters).
    #[must_use]
    pub fn coefficients<S: Scalar>(&self, parameters: &[S]) -> BaseCoefficients<S> {
        match self {
            Self::Nonlinear(model) => BaseCoefficients::Nonlinear(model.coefficients(parameters)),
            Self::Linear(model) => BaseCoefficients::Linear(model.coefficients(parameters)),
        }
    }

    /// The gas in the chamber.
    #[must_use]
    pub fn gas(&self) -> Gas {
        match self {
            Self::Nonlinear(model) => model.gas,
            Self::Linear(model) => model.gas,
        }
    }

    /// The valve and chamber; none of a regulator.
    #[must_use]
    pub fn valve(&self) -> Option<&Nonlinear> {
        match self {
            Self::Nonlinear(model) => Some(model),
            Self::Linear(_) => None,
        }
    }

    /// Is it a regulator with its own loop?
    #[must_use]
    pub fn is_regulator(&self) -> bool {
        self.valve().is_none()
    }
}
