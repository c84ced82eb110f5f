//! The gas behind one valve: pressure, and where an effect asks for it the gas temperature or a tube.
//!
//! One pressure is advanced by the exponential Rosenbrock-Euler step (Hochbruck and Ostermann, Acta Numerica 2010, section
//! 2.4): second order, and stable where the flow's slope near equal pressures is steep. Two coupled pressures (a tube) take the
//! two-stage Rosenbrock step ROS2 (Verwer et al., SIAM J. Sci. Comput. 20, 1999), which is L-stable.

use super::hook::{Areas, Stretch, Structure};
use super::plant::Plant;
use crate::model::{FlowFunction, GAMMA, psi_max};
use crate::numeric::Scalar;

/// Absolute pressure at which the time constant of the gas temperature is stated, Pa: the middle of the working range.
pub const HEAT_REFERENCE_PA: f64 = 250_000.0;

/// What holds during one step.
#[derive(Debug, Clone, Copy)]
pub struct Conditions<S> {
    /// Areas of the ports, mm^2.
    pub areas: Areas<S>,
    /// Supply pressure, Pa.
    pub supply: S,
    /// Areas of the ports per unit of drive, mm^2.
    pub open: Areas<S>,
    /// Geometric volume, m^3.
    pub volume_m3: f64,
    /// Weighted relative rate of the geometric volume, 1/s.
    pub expansion: S,
    /// Relative volume.
    pub stretch: Stretch<S>,
}

/// State of the gas.
#[derive(Debug, Clone, Copy)]
pub struct Chamber<S> {
    structure: Structure<S>,
    flow: FlowFunction,
    conductance: f64,
    ambient_pa: f64,
    ambient_k: f64,
    pressure: S,
    temperature: S,
    port: S,
    /// Pressure before the vent's restriction at the last step, Pa: where the next search begins.
    before_outlet_pa: f64,
}

impl<S: Scalar<Real = f64>> Chamber<S> {
    /// A chamber that is not started yet.
    pub fn new(plant: &Plant, structure: Structure<S>) -> Self {
        let ambient = S::constant(plant.gas.ambient_pa);
        Self {
            structure,
            flow: plant.flow,
            conductance: plant.conductance(),
            ambient_pa: plant.gas.ambient_pa,
            ambient_k: plant.gas.temperature_k,
            pressure: ambient,
            temperature: S::constant(plant.gas.temperature_k),
            port: ambient,
            before_outlet_pa: plant.gas.ambient_pa,
        }
    }

    /// Begins at rest at an absolute pressure, Pa.
    pub fn start(&mut self, pressure: S) {
        self.pressure = pressure;
        self.port = pressure;
        self.temperature = S::constant(self.ambient_k);
    }

    /// Sets the pressure, Pa.
    pub fn set(&mut self, pressure: S) {
        self.pressure = pressure;
        self.port = pressure;
    }

    /// Adds to the pressures, Pa.
    pub fn shift(&mut self, change: S) {
        self.pressure = self.pressure + change;
        self.port = self.port + change;
    }

    /// Pressure in the chamber, Pa.
    pub fn pressure(&self) -> S {
        self.pressure
    }

    /// Pressure at the valve's port, where the sensor sits, Pa.
    pub fn port(&self) -> S {
        if self.structure.line.is_some() { self.port } else { self.pressure }
    }

    /// Advances by `h` seconds. Returns the flow drawn from the supply at its start, mm^2 Pa.
    #[inline(always)]
    pub fn advance(&mut self, h: f64, c: &Conditions<S>) -> f64 {
        if let Some((area, fraction)) = self.structure.line {
            return self.advance_line(h, c, area * c.open.fill, fraction);
        }
        if let Some(tau) = self.structure.heat_time_constant_s {
            return self.advance_heat(h, c, tau);
        }
        let per_area = self.conductance / c.volume_m3;
        let (inflow, _, in_by) = self.flow_pressure(c.supply, self.pressure);
        let (outflow, out_by, before_outlet) = self.vent(c, self.pressure);
        self.before_outlet_pa = before_outlet;
        let (fill, vent) = (c.areas.fill.times(per_area), c.areas.vent.times(per_area));
        let swelling = (c.expansion * c.stretch.factor + c.stretch.rate).times(GAMMA);
        let room = c.stretch.factor + (self.pressure * c.stretch.by_pressure).times(GAMMA);
        let rate = (fill * inflow - vent * outflow - swelling * self.pressure) / room;
        let slope = (fill.real() * in_by - vent.real() * out_by - swelling.real()) / room.real();
        self.pressure = self.pressure + rate.times(h * phi1(h * slope));
        c.areas.fill.real() * inflow.real()
    }

    /// Gas temperature as a second state: the first law with the outflow at the gas's temperature and a wall of constant
    /// conductance at ambient temperature.
    fn advance_heat(&mut self, h: f64, c: &Conditions<S>, tau: S) -> f64 {
        let t0 = self.ambient_k;
        let per_area = self.conductance / c.volume_m3;
        let (inflow, _, in_by) = self.flow_pressure(c.supply, self.pressure);
        let (outflow, out_by, before_outlet) = self.vent(c, self.pressure);
        self.before_outlet_pa = before_outlet;
        let (fill, vent) = (c.areas.fill.times(per_area), c.areas.vent.times(per_area));
        let (p, t) = (self.pressure, self.temperature);
        let warmth = t.times(1.0 / t0);
        let root = warmth.sqrt();
        let swelling = c.expansion * c.stretch.factor + c.stretch.rate;
        // Relative rates: of the pressure without the wall, and of the mass.
        let driven = |root: S| fill * inflow - vent * outflow * root - (swelling * p).times(GAMMA);
        let mass = (fill * inflow - vent * outflow / root).times(1.0 / GAMMA) * warmth / p;
        let heating = t * (driven(root) / p + swelling - mass);
        // T' = heating - k (T - T0), k from the wall's conductance.
        let k = (tau * p).recip().times(HEAT_REFERENCE_PA) * warmth;
        let decay = (-k.times(h)).exp();
        let level = (heating / k).plus(t0);
        let next = level + (t - level) * decay;
        let share = (-decay).plus(1.0) / k.times(h);
        let mean = level + (t - level) * share;
        let wall = (-mean).plus(t0) / tau.times(t0 / HEAT_REFERENCE_PA);
        let mean_root = mean.times(1.0 / t0).sqrt();
        let rate = driven(mean_root) + wall;
        let slope = fill.real() * in_by - vent.real() * out_by * mean_root.real() - swelling.real() * GAMMA;
        self.pressure = p + rate.times(h * phi1(h * slope));
        self.temperature = next;
        c.areas.fill.real() * inflow.real()
    }

    /// The port's volume and the chamber's, with an orifice between them.
    fn advance_line(&mut self, h: f64, c: &Conditions<S>, area: S, fraction: S) -> f64 {
        const G: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
        let per_area = self.conductance / c.volume_m3;
        let (fill, vent, tube) =
            (c.areas.fill.times(per_area), c.areas.vent.times(per_area), area.times(per_area));
        let swelling = (c.expansion * c.stretch.factor + c.stretch.rate).times(GAMMA);
        let rates = |port: S, chamber: S| {
            let (inflow, _, in_by) = self.flow_pressure(c.supply, port);
            let (outflow, out_by, before_outlet) = self.vent(c, port);
            let (through, by_port, by_chamber) = self.flow_pressure(port, chamber);
            let room = c.stretch.factor + (chamber * c.stretch.by_pressure).times(GAMMA);
            let at_port = (fill * inflow - vent * outflow - tube * through) / fraction;
            let in_chamber = (tube * through - swelling * chamber) / room;
            let (tube, fraction, room) = (tube.real(), fraction.real(), room.real());
            let jacobian = [
                [
                    (fill.real() * in_by - vent.real() * out_by - tube * by_port) / fraction,
                    -tube * by_chamber / fraction,
                ],
                [tube * by_port / room, (tube * by_chamber - swelling.real()) / room],
            ];
            ([at_port, in_chamber], jacobian, [fill.real() / per_area * inflow.real(), before_outlet])
        };
        let (f1, j, [draw, before_outlet]) = rates(self.port, self.pressure);
        let (a, b, cc, d) =
            (1.0 - G * h * j[0][0], -G * h * j[0][1], -G * h * j[1][0], 1.0 - G * h * j[1][1]);
        let inverse = 1.0 / (a * d - b * cc);
        let solve = |r: [S; 2]| {
            [(r[0].times(d) - r[1].times(b)).times(inverse), (r[1].times(a) - r[0].times(cc)).times(inverse)]
        };
        let k1 = solve(f1);
        let (f2, _, _) = rates(self.port + k1[0].times(h), self.pressure + k1[1].times(h));
        let k2 = solve([f2[0] - k1[0].times(2.0), f2[1] - k1[1].times(2.0)]);
        self.before_outlet_pa = before_outlet;
        self.port = self.port + k1[0].times(1.5 * h) + k2[0].times(0.5 * h);
        self.pressure = self.pressure + k1[1].times(1.5 * h) + k2[1].times(0.5 * h);
        draw
    }

    /// Flow pressure of the vent port, its slope by the port's pressure, and the pressure (Pa) before a restriction if there is one.
    #[inline(always)]
    fn vent(&self, c: &Conditions<S>, port: S) -> (S, f64, f64) {
        let ambient = S::constant(self.ambient_pa);
        let Some(ratio) = self.structure.outlet else {
            let (outflow, by_port, _) = self.flow_pressure(port, ambient);
            return (outflow, by_port, self.ambient_pa);
        };
        let outlet = ratio * c.open.vent;
        // Where the two flows are equal, between ambient and port: a safeguarded Newton search on the values ...
        let (mut low, mut high) = (self.ambient_pa, port.real().max(self.ambient_pa));
        let mut between = self.before_outlet_pa.clamp(low, high);
        let balance = |between: f64| {
            let (a, b) = (c.areas.vent.real(), outlet.real());
            let (inflow, [_, in_by]) = self.flow_value(port.real(), between);
            let (out, [out_by, _]) = self.flow_value(between, self.ambient_pa);
            (a * inflow - b * out, a * in_by - b * out_by)
        };
        for _ in 0..40 {
            let (excess, slope) = balance(between);
            if excess > 0.0 {
                low = between;
            } else {
                high = between;
            }
            let newton = between - excess / slope;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let moved = (next - between).abs();
            between = next;
            if moved < 1e-3 {
                break;
            }
        }
        // ... and one step of it with derivatives, which is the implicit function theorem.
        let at = S::constant(between);
        let (inflow, by_port, in_by) = self.flow_pressure(port, at);
        let (out, out_by, _) = self.flow_pressure(at, ambient);
        let slope = c.areas.vent.real() * in_by - outlet.real() * out_by;
        let between = at - (c.areas.vent * inflow - outlet * out).times(1.0 / slope);
        let (outflow, _, _) = self.flow_pressure(port, between);
        let follows = -c.areas.vent.real() * by_port / slope;
        (outflow, by_port + in_by * follows, between.real())
    }

    /// Flow pressure as a number, and its partial derivatives by the two pressures.
    #[inline(always)]
    fn flow_value(&self, from: f64, to: f64) -> (f64, [f64; 2]) {
        let (own, by_from, by_to) = self.flow.with_partials(from, to);
        let value = match self.structure.flow_function {
            None => own,
            Some((ratio, exponent)) => general_flow_pressure(from, to, ratio.real(), exponent.real()),
        };
        (value, [by_from, by_to])
    }

    /// Flow pressure and its partial derivatives by the two pressures.
    #[inline(always)]
    fn flow_pressure(&self, from: S, to: S) -> (S, f64, f64) {
        let (value, by_from, by_to) = self.flow.with_partials(from.real(), to.real());
        match self.structure.flow_function {
            None => (S::chain2(value, from, by_from, to, by_to), by_from, by_to),
            Some((ratio, exponent)) => (general_flow_pressure(from, to, ratio, exponent), by_from, by_to),
        }
    }
}

/// Flow pressure of a port with any critical ratio and subsonic exponent (ISO 6358-3), with the laminar segment of
/// [`FlowFunction`].
fn general_flow_pressure<S: Scalar<Real = f64>>(from: S, to: S, ratio: S, exponent: S) -> S {
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
    let value =
        S::select(r.real() > laminar, straight, psi(r.min(S::constant(laminar)))) * high.times(psi_max());
    S::select(backwards, -value, value)
}

/// `(exp(z) - 1) / z`.
#[inline(always)]
fn phi1(z: f64) -> f64 {
    if z.abs() < 0.1 {
        // Taylor; the next term is below 2e-10.
        let terms = [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0];
        terms.iter().fold(0.0, |sum, term| sum * z + term)
    } else {
        z.exp_m1() / z
    }
}
