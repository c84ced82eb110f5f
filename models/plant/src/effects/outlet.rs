//! The space between the vent port and a restriction behind it (a muffler, a fitting).
//!
//! It fills through the port and empties through the restriction, within milliseconds, so its
//! pressure takes an exponential step of its own (Hochbruck and Ostermann, Acta Numerica 2010,
//! section 2.4) with the pressure in front of the port held. The chamber sees the mean over that
//! step, and how the mean follows the chamber. For a space of almost no volume that is one Newton
//! step towards equal flows.

use super::phi::{far_or, next, phi1, taylor};
use crate::model::{GAMMA, Ports};
use crate::numeric::Scalar;

/// What is behind the vent port.
#[derive(Debug, Clone, Copy)]
pub struct OutletParameters<S> {
    /// Area of the restriction over the vent port's at full drive.
    pub area_ratio: S,
    /// Volume of the space over the chamber's.
    pub volume_ratio: S,
}

/// State of the space.
#[derive(Debug, Clone, Copy)]
pub struct Outlet<S> {
    /// What is there.
    pub parameters: OutletParameters<S>,
    ambient_pa: f64,
    /// Absolute pressure, Pa.
    pub pressure: S,
}

/// What holds during a step.
#[derive(Debug, Clone, Copy)]
pub struct Venting<S> {
    /// Length of the step, s.
    pub h: f64,
    /// Factor from an area in mm^2 over the chamber's volume to a rate, 1/(mm^2 s).
    pub per_area: f64,
    /// Area of the vent port, mm^2.
    pub port_area: S,
    /// Area of the restriction, mm^2.
    pub restriction: S,
}

/// What flows through the vent port at the start of a step.
#[derive(Debug, Clone, Copy)]
pub struct Through<S> {
    /// Flow pressure, Pa.
    pub flow: S,
    /// Its slope by the pressure in front of the port.
    pub by_port: S,
    /// Its slope by the pressure behind it.
    pub by_behind: S,
}

impl<S: Scalar> Outlet<S> {
    /// A space at ambient pressure, Pa.
    pub fn new(parameters: OutletParameters<S>, ambient_pa: f64) -> Self {
        Self { parameters, ambient_pa, pressure: S::constant(ambient_pa) }
    }

    /// Advances the space over a step with the absolute pressure `port` (Pa) in front of the vent
    /// port. `onward` is the flow pressure (Pa) of the restriction at its start and its slope by
    /// the space's pressure. Returns the port's flow pressure, mean over the step, and its slope by
    /// the pressure in front of the port.
    #[inline(always)]
    pub fn advance(
        &mut self,
        ports: &Ports<S>,
        venting: &Venting<S>,
        port: S,
        through: &Through<S>,
        (onward, onward_by): (S, S),
    ) -> (S, S) {
        let before = self.pressure;
        let ambient = S::constant(self.ambient_pa);
        // The gas in a muffler is at the wall's temperature: isothermal, so without the chamber's
        // exponent.
        let per_area = self.parameters.volume_ratio.recip().times(venting.h * venting.per_area / GAMMA);
        let (port_area, restriction) = (venting.port_area * per_area, venting.restriction * per_area);
        let change = port_area * through.flow - restriction * onward;
        let slope = port_area * through.by_behind - restriction * onward_by;
        let (whole, mean) = (phi1(slope), phi2(slope));
        let highest = port.max(before).max(ambient);
        let within = |pressure: S| pressure.max(ambient).min(highest);
        let (flow, by_port_alone, by_mean) = ports.flow_pressure(port, within(before + change * mean));
        self.pressure = within(before + change * whole);
        (flow, by_port_alone + by_mean * mean * port_area * through.by_port)
    }
}

/// `(phi1(z) - 1) / z`: the mean of the exponential step over its length, as `phi1` is its end.
#[inline(always)]
fn phi2<S: Scalar>(z: S) -> S {
    let x = z.real();
    // The next term is below 3e-11.
    let near = taylor(x, [1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5]);
    let value = far_or(near, x, |x| phi1(x) - 1.0);
    // phi2' = phi2 - 2 phi3, phi3 = (phi2 - 1/2) / z.
    let phi3 = [1.0 / 40320.0, 1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0];
    z.chain(value, value - next(value, 0.5, x, phi3).times(2.0))
}
