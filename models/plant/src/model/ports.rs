//! What flows through an orifice, with the rig's flow function or any other.

use multiversion::multiversion;

use super::{FlowFunction, psi_max};
use crate::numeric::Scalar;

/// The flow function of a channel's ports.
#[derive(Debug, Clone, Copy)]
pub struct Ports<S> {
    /// The rig's.
    pub own: FlowFunction,
    /// Another, instead of the rig's.
    pub general: Option<GeneralFlow<S>>,
}

impl<S: Scalar> Ports<S> {
    /// Flow pressure (Pa) from one absolute pressure (Pa) to another, and its partial derivatives
    /// by the two; of another flow function than the rig's, those of the rig's, which are close
    /// enough for a step of the integration.
    #[inline(always)]
    pub fn flow_pressure(&self, from: S, to: S) -> (S, S, S) {
        let (value, by_from, by_to) = self.own.with_partials(from, to);
        match &self.general {
            None => (value, by_from, by_to),
            Some(general) => (general.pressure(from, to), by_from, by_to),
        }
    }
}

/// A flow function with any critical ratio and subsonic exponent (ISO 6358-3), with the laminar
/// segment of [`FlowFunction`].
#[derive(Debug, Clone, Copy)]
pub struct GeneralFlow<S> {
    ratio: S,
    exponent: S,
    /// One over the span of ratios below which it is not choked.
    by_span: S,
    /// Slope of the laminar segment.
    laminar_slope: S,
}

impl<S: Scalar> GeneralFlow<S> {
    /// With a critical ratio, 0 to below 0.999, and an exponent.
    pub fn new(ratio: S, exponent: S) -> Self {
        let by_span = (-ratio).plus(1.0).recip();
        let sharp = Self { ratio, exponent, by_span, laminar_slope: S::zero() };
        let laminar = FlowFunction::LAMINAR_RATIO;
        Self { laminar_slope: sharp.subsonic(S::constant(laminar)).times(1.0 / (1.0 - laminar)), ..sharp }
    }

    #[inline(always)]
    fn subsonic(&self, r: S) -> S {
        let z = ((r - self.ratio) * self.by_span).max(S::zero());
        (-z.square()).plus(1.0).powf(self.exponent)
    }

    /// Flow pressure (Pa) from one absolute pressure (Pa) to another.
    ///
    /// A function of its own: taken into a loop, its powers are computed in front of it, also where
    /// no port has such a flow function.
    #[inline(never)]
    fn pressure(&self, from: S, to: S) -> S {
        if S::WIDE { wide_pressure(self, from, to) } else { self.pressure_of(from, to) }
    }

    #[inline(always)]
    fn pressure_of(&self, from: S, to: S) -> S {
        let backwards = from.less(to);
        let high = S::select(backwards, to, from);
        let low = S::select(backwards, from, to);
        let laminar = S::constant(FlowFunction::LAMINAR_RATIO);
        let r = low / high;
        let straight = self.laminar_slope * (-r).plus(1.0);
        let value =
            S::select(laminar.less(r), straight, self.subsonic(r.min(laminar))) * high.times(psi_max());
        S::select(backwards, -value, value)
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn wide_pressure<S: Scalar>(flow: &GeneralFlow<S>, from: S, to: S) -> S {
    flow.pressure_of(from, to)
}
