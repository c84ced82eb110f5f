//! A model with nothing around it.

use super::System;
use crate::model::{Drive, Model, Parameter};
use crate::numeric::Scalar;

/// One chamber described by a [`Model`]: its only state is the pressure, and the sensor reads it as it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Chamber<Q>(pub Q);

impl<Q: Model> System<1, 1> for Chamber<Q> {
    type Coefficients<S: Scalar> = Q::Coefficients<S>;
    type Memory<S: Scalar> = ();
    type Held<S: Scalar> = Q::Held<S>;

    fn parameters(&self) -> Vec<Parameter> {
        self.0.parameters()
    }

    #[inline(always)]
    fn coefficients<S: Scalar>(&self, parameters: &[S]) -> Self::Coefficients<S> {
        self.0.coefficients(parameters)
    }

    #[inline(always)]
    fn start<S: Scalar>(&self, _: &Self::Coefficients<S>, _: &[S::Real], pressures: [S; 1]) -> ([S; 1], ()) {
        (pressures, ())
    }

    #[inline(always)]
    fn measure<S: Scalar>(
        &self,
        _: &Self::Coefficients<S>,
        _: &[S::Real],
        state: &[S; 1],
        _: &mut (),
    ) -> [S; 1] {
        *state
    }

    #[inline(always)]
    fn hold<S: Scalar>(
        &self,
        coefficients: &Self::Coefficients<S>,
        row: &[S::Real],
        _tick: usize,
        _state: &[S; 1],
        _memory: &mut (),
    ) -> Self::Held<S> {
        self.0.hold(coefficients, row, Drive::recorded(row))
    }

    #[inline(always)]
    fn derivative<S: Scalar>(
        &self,
        coefficients: &Self::Coefficients<S>,
        held: &Self::Held<S>,
        state: &[S; 1],
    ) -> [S; 1] {
        [self.0.rate(coefficients, held, state[0])]
    }
}
