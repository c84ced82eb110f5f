//! The linear model: a first-order lag.

use super::{About, Constants, Drive, Gas, Listed, Model, Parameter};
use crate::numeric::Scalar;

/// `dp/dt = -alpha p + beta p_cmd`, in gauge pressures: the only form in which a command of zero
/// leaves the chamber at ambient pressure when `alpha` and `beta` differ.
///
/// Driven by the command alone. It is the model for anything with a pressure loop of its own.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Linear {
    /// Ambient pressure is taken from here.
    pub gas: Gas,
}

/// The two rates, 1/s.
#[derive(Debug, Clone, Copy)]
pub struct LinearCoefficients<S> {
    /// Rate at which the pressure decays.
    pub alpha: S,
    /// Rate at which the command drives the pressure.
    pub beta: S,
}

impl Listed for Linear {
    const ABOUT: About =
        About { id: "linear", title: "First-order lag of the command", is_regulator: true };

    fn of(constants: &Constants) -> Self {
        Self { gas: constants.gas }
    }
}

impl Model for Linear {
    type Coefficients<S: Scalar> = LinearCoefficients<S>;
    /// `beta p_cmd`, Pa/s.
    type Held<S: Scalar> = S;

    fn name(&self) -> &'static str {
        Self::ABOUT.id
    }

    fn parameters(&self) -> Vec<Parameter> {
        let range = (1e-3, 5.0, 1e3);
        vec![
            Parameter::logarithmic("alpha", "1/s", range, "rate at which the pressure decays"),
            Parameter::logarithmic("beta", "1/s", range, "rate at which the command drives the pressure"),
        ]
    }

    #[inline(always)]
    fn coefficients<S: Scalar>(&self, parameters: &[S]) -> LinearCoefficients<S> {
        LinearCoefficients { alpha: parameters[0], beta: parameters[1] }
    }

    #[inline(always)]
    fn hold<S: Scalar>(&self, rates: &LinearCoefficients<S>, _: &[S::Real], drive: Drive<S>) -> S {
        rates.beta * drive.command.plus(-self.gas.ambient_pa)
    }

    #[inline(always)]
    fn rate<S: Scalar>(&self, rates: &LinearCoefficients<S>, driven: &S, pressure: S) -> S {
        *driven - rates.alpha * pressure.plus(-self.gas.ambient_pa)
    }
}
