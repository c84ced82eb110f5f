//! The gas behind one valve: pressure, and where an effect asks for it the gas temperature or a tube.
//!
//! The pressure is advanced by the exponential Rosenbrock-Euler step (Hochbruck and Ostermann, Acta Numerica 2010, section
//! 2.4): second order, and stable where the flow's slope near equal pressures is steep. It uses the slope of the flow by the pressure,
//! which depends on the parameters too: a derivative of the step that leaves that out is wrong in fast transients.

use super::hook::{Areas, LineParameters, Memory, Stretch, Structure};
use super::outlet::{Outflow, Outlet, Venting};
use super::phi::phi1;
use super::plant::Plant;
use super::ports::Ports;
use super::tube::{self, Ends};
use crate::model::GAMMA;
use crate::numeric::Scalar;

/// Absolute pressure at which the time constant of the gas temperature is stated, Pa: the middle of the working range.
pub const HEAT_REFERENCE_PA: f64 = 250_000.0;

/// Half of the flow pressure below which the loss in any tube is laminar, Pa: its conductance is finite without a drop.
const LEAST_LAMINAR_PA: f64 = 500.0;
/// No pressure falls below this, Pa: what would take more in a step than there is.
const LOWEST_PA: f64 = 1e3;

/// What holds during one step.
#[derive(Debug, Clone, Copy)]
pub struct Conditions<S> {
    /// Areas of the ports, mm^2.
    pub areas: Areas<S>,
    /// Supply pressure, Pa.
    pub supply: S,
    /// Areas of the ports at full drive, mm^2.
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
    ports: Ports<S>,
    conductance: f64,
    ambient_pa: f64,
    ambient_k: f64,
    pressure: S,
    temperature: S,
    port: S,
    /// Space behind the vent port, if there is a restriction.
    outlet: Option<Outlet<S>>,
}

impl<S: Scalar> Chamber<S> {
    /// A chamber that is not started yet.
    pub fn new(plant: &Plant, structure: Structure<S>) -> Self {
        let ambient = S::constant(plant.gas.ambient_pa);
        Self {
            structure,
            ports: Ports { own: plant.flow, general: structure.flow_function },
            conductance: plant.conductance(),
            ambient_pa: plant.gas.ambient_pa,
            ambient_k: plant.gas.temperature_k,
            pressure: ambient,
            temperature: S::constant(plant.gas.temperature_k),
            port: ambient,
            outlet: structure.outlet.map(|outlet| Outlet::new(outlet, plant.gas.ambient_pa)),
        }
    }

    /// Begins at rest at an absolute pressure, Pa.
    pub fn start(&mut self, pressure: S) {
        self.pressure = pressure;
        self.port = pressure;
        self.temperature = S::constant(self.ambient_k);
        self.outlet = self.structure.outlet.map(|outlet| Outlet::new(outlet, self.ambient_pa));
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

    /// Shows what is remembered from step to step: the pressure in the chamber, and what its structure adds.
    pub fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        visit(Memory::Estimated, &mut self.pressure);
        if self.structure.line.is_some() {
            visit(Memory::Estimated, &mut self.port);
        }
        if self.structure.heat_time_constant_s.is_some() {
            visit(Memory::Estimated, &mut self.temperature);
        }
        // Filled and emptied within milliseconds.
        if let Some(outlet) = &mut self.outlet {
            visit(Memory::Known, &mut outlet.pressure);
        }
    }

    /// Is there a tube between valve and chamber?
    pub fn has_tube(&self) -> bool {
        self.structure.line.is_some()
    }

    /// Pressure in the chamber, Pa.
    pub fn pressure(&self) -> S {
        self.pressure
    }

    /// Pressure at the valve's port, where the sensor sits, Pa.
    pub fn port(&self) -> S {
        if self.has_tube() { self.port } else { self.pressure }
    }

    /// Temperature of the gas, K.
    pub fn temperature(&self) -> S {
        self.temperature
    }

    /// Advances by `h` seconds. Returns the flow drawn from the supply at its start, mm^2 Pa.
    #[inline(always)]
    pub fn advance(&mut self, h: f64, c: &Conditions<S>) -> S::Real {
        if let Some(line) = self.structure.line {
            return self.advance_line(h, c, &line);
        }
        if let Some(tau) = self.structure.heat_time_constant_s {
            return self.advance_heat(h, c, tau);
        }
        let per_area = self.conductance / c.volume_m3;
        let (inflow, _, in_by) = self.ports.flow_pressure(c.supply, self.pressure);
        let Outflow { flow: outflow, by_port: out_by, after } = self.vent(h, c, self.pressure);
        self.outlet = after;
        let (fill, vent) = (c.areas.fill.times(per_area), c.areas.vent.times(per_area));
        let swelling = (c.expansion * c.stretch.factor + c.stretch.rate).times(GAMMA);
        let room = c.stretch.factor + (self.pressure * c.stretch.by_pressure).times(GAMMA);
        let rate = (fill * inflow - vent * outflow - swelling * self.pressure) / room;
        let slope = (fill * in_by - vent * out_by - swelling) / room;
        self.pressure = self.pressure + rate * phi1(slope.times(h)).times(h);
        c.areas.fill.real() * inflow.real()
    }

    /// Gas temperature as a second state: the first law with the outflow at the gas's temperature and a wall of constant
    /// conductance at ambient temperature.
    fn advance_heat(&mut self, h: f64, c: &Conditions<S>, tau: S) -> S::Real {
        let t0 = self.ambient_k;
        let per_area = self.conductance / c.volume_m3;
        let (inflow, _, in_by) = self.ports.flow_pressure(c.supply, self.pressure);
        let Outflow { flow: outflow, by_port: out_by, after } = self.vent(h, c, self.pressure);
        self.outlet = after;
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
        let slope = fill * in_by - vent * out_by * mean_root - swelling.times(GAMMA);
        self.pressure = p + rate * phi1(slope.times(h)).times(h);
        self.temperature = next;
        c.areas.fill.real() * inflow.real()
    }

    /// The port's volume and the chamber's, with a tube between them.
    fn advance_line(&mut self, h: f64, c: &Conditions<S>, line: &LineParameters<S>) -> S::Real {
        let per_area = self.conductance / c.volume_m3;
        let (fill, vent) = (c.areas.fill.times(per_area), c.areas.vent.times(per_area));
        let (inflow, _, in_by) = self.ports.flow_pressure(c.supply, self.port);
        let Outflow { flow: outflow, by_port: out_by, after } = self.vent(h, c, self.port);
        let swelling = (c.expansion * c.stretch.factor + c.stretch.rate).times(GAMMA);
        let room = c.stretch.factor + (self.pressure * c.stretch.by_pressure).times(GAMMA);
        let ends = Ends {
            driven: fill * inflow - vent * outflow,
            slope: fill * in_by - vent * out_by,
            swelling: swelling / room,
            port: line.volume_ratio.recip(),
            chamber: room.recip(),
        };
        let half = line.laminar_pa.times(0.5).plus(LEAST_LAMINAR_PA);
        let through = |port, chamber| self.ports.own.conductance(port, chamber, half) / line.time_constant_s;
        let [port, chamber] = tube::advance(h, &ends, [self.port, self.pressure], through);
        let lowest = S::constant(LOWEST_PA);
        (self.port, self.pressure, self.outlet) = (port.max(lowest), chamber.max(lowest), after);
        c.areas.fill.real() * inflow.real()
    }

    /// What flows out of the vent port over a step with the absolute pressure `port`, Pa, in front of it.
    #[inline(always)]
    fn vent(&self, h: f64, c: &Conditions<S>, port: S) -> Outflow<S> {
        let Some(outlet) = &self.outlet else {
            let (flow, by_port, _) = self.ports.flow_pressure(port, S::constant(self.ambient_pa));
            return Outflow { flow, by_port, after: None };
        };
        let per_area = self.conductance / c.volume_m3;
        let restriction = outlet.parameters.area_ratio * c.open.vent;
        let venting = Venting { h, per_area, port_area: c.areas.vent, restriction };
        outlet.outflow(&self.ports, &venting, port)
    }
}
