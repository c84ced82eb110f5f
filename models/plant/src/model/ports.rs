//! What flows through an orifice, with the rig's flow function or any other.

use super::{FlowFunction, psi_max};
use crate::numeric::Scalar;

/// The flow function of a channel's ports.
#[derive(Debug, Clone, Copy)]
pub struct Ports<S> {
    /// The rig's.
    pub own: FlowFunction,
    /// Critical ratio and subsonic exponent, instead of the rig's.
    pub general: Option<(S, S)>,
}

impl<S: Scalar> Ports<S> {
    /// Flow pressure (Pa) from one absolute pressure (Pa) to another, and its partial derivatives by the two; of another flow function than
    /// the rig's, those of the rig's, which are close enough for a step of the integration.
    #[inline(always)]
    pub fn flow_pressure(&self, from: S, to: S) -> (S, S, S) {
        let (value, by_from, by_to) = self.own.with_partials(from, to);
        match self.general {
            None => (value, by_from, by_to),
            Some((ratio, exponent)) => (general_flow_pressure(from, to, ratio, exponent), by_from, by_to),
        }
    }
}

/// Flow pressure of a port with any critical ratio and subsonic exponent (ISO 6358-3), with the laminar segment of
/// [`FlowFunction`].
///
/// A function of its own: taken into a loop, its powers are computed in front of it, also where no port has such a flow function.
#[inline(never)]
fn general_flow_pressure<S: Scalar>(from: S, to: S, ratio: S, exponent: S) -> S {
    let backwards = from.less(to);
    let high = S::select(backwards, to, from);
    let low = S::select(backwards, from, to);
    let laminar = FlowFunction::LAMINAR_RATIO;
    let r = low / high;
    let one = S::constant(1.0);
    let psi = |r: S| {
        let z = ((r - ratio) / (one - ratio)).max(S::zero());
        (one - z.square()).powf(exponent)
    };
    let straight = psi(S::constant(laminar)) * (one - r).times(1.0 / (1.0 - laminar));
    let near = S::constant(laminar).less(r);
    let value = S::select(near, straight, psi(r.min(S::constant(laminar)))) * high.times(psi_max());
    S::select(backwards, -value, value)
}
