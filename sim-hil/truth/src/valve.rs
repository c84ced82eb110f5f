//! The spool's metering edges: conductance over position.

use super::background::{Deviation, factor};
use super::physics::ValvePhysics;

/// Conductances of a valve's two edges, m^3/(s Pa).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Conductances {
    /// Supply to port, with the leak past the fill edge.
    pub fill: f64,
    /// Port to exhaust.
    pub vent: f64,
}

/// A valve ready to be evaluated.
#[derive(Debug, Clone)]
pub struct Valve {
    slope: f64,
    vent_slope: f64,
    fill_edge: f64,
    vent_edge: f64,
    centre: f64,
    leakage: f64,
    corner_squared: f64,
    fill_leak: f64,
    fill_curve: Deviation,
    vent_curve: Deviation,
}

impl Valve {
    pub fn new(p: &ValvePhysics) -> Self {
        // One slope for both edges: they are ground on one spool. The edges of a symmetric spool
        // are open at +-1.
        let slope = p.gain * p.conductance / (1.0 - 0.5 * (p.fill_edge - p.vent_edge));
        let corner = p.corner * p.conductance;
        Self {
            slope,
            vent_slope: p.vent_gain * slope,
            fill_edge: p.fill_edge,
            vent_edge: p.vent_edge,
            centre: p.centre,
            leakage: p.leakage * p.conductance,
            corner_squared: corner * corner,
            fill_leak: p.fill_leak,
            fill_curve: p.fill_curve,
            vent_curve: p.vent_curve,
        }
    }

    /// Conductances at a spool position, with the slope multiplied by `gain`.
    #[inline]
    pub fn conductances(&self, spool: f64, gain: f64) -> Conductances {
        let x = spool + self.centre;
        let fill = gain * self.slope * (x - self.fill_edge) - self.leakage;
        let vent = gain * self.vent_slope * (self.vent_edge - x) - self.leakage;
        Conductances {
            fill: self.leakage
                + self.corner(fill) * factor(&self.fill_curve, x.clamp(0.0, 1.0))
                + self.fill_leak,
            vent: self.leakage + self.corner(vent) * factor(&self.vent_curve, (-x).clamp(0.0, 1.0)),
        }
    }

    /// `max(y, 0)` with a hyperbola for a corner.
    #[inline]
    fn corner(&self, y: f64) -> f64 {
        0.5 * (y + (y * y + self.corner_squared).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameters::PlantParameters;
    use super::*;

    fn valve(change: impl FnOnce(&mut ValvePhysics)) -> (Valve, f64) {
        let mut physics = PlantParameters::default().channel_physics().valve;
        change(&mut physics);
        (Valve::new(&physics), physics.conductance)
    }

    /// Open edges pass the rated conductance (the hyperbola adds e^2/4 of it), closed ones the
    /// leakage.
    #[test]
    fn edges_open_to_the_rated_conductance_and_close_to_the_leak() {
        let (valve, rated) = valve(|_| {});
        let open = valve.conductances(1.0, 1.0);
        assert!((open.fill / rated - 1.0001).abs() < 1e-6, "{}", open.fill / rated);
        assert!((open.vent / rated - 0.002) < 1e-4 && open.vent / rated > 0.002);
        let back = valve.conductances(-1.0, 1.0);
        assert!((back.vent - open.fill).abs() < 1e-15 * rated.recip().recip());
        let shut = valve.conductances(0.0, 1.0);
        assert!(shut.fill < 0.004 * rated && shut.fill > 0.003 * rated, "{}", shut.fill / rated);
        assert!((shut.fill - shut.vent).abs() < 1e-6 * rated);
    }

    #[test]
    fn centre_shifts_both_edges() {
        let (plain, rated) = valve(|_| {});
        let (shifted, _) = valve(|v| v.centre = 0.1);
        let a = plain.conductances(0.3, 1.0);
        let b = shifted.conductances(0.2, 1.0);
        assert!((a.fill - b.fill).abs() < 1e-12 * rated && (a.vent - b.vent).abs() < 1e-12 * rated);
    }

    #[test]
    fn vent_gain_leaves_the_fill_edge_alone() {
        let (plain, _) = valve(|_| {});
        let (asymmetric, _) = valve(|v| v.vent_gain = 0.5);
        let (a, b) = (plain.conductances(-0.8, 1.0), asymmetric.conductances(-0.8, 1.0));
        assert!((b.vent / a.vent - 0.5).abs() < 0.01);
        let (a, b) = (plain.conductances(0.8, 1.0), asymmetric.conductances(0.8, 1.0));
        assert_eq!(a.fill.to_bits(), b.fill.to_bits());
    }
}
