//! The gas behind one valve: pressure, and where an effect asks for it the gas temperature or a
//! tube.
//!
//! The pressure is advanced by the exponential Rosenbrock-Euler step (Hochbruck and Ostermann, Acta
//! Numerica 2010, section 2.4): second order, and stable where the flow's slope near equal
//! pressures is steep. It uses the slope of the flow by the pressure, which depends on the
//! parameters too: a derivative of the step that leaves that out is wrong in fast transients.

mod heat;
mod line;

use self::heat::{Gas, Heat};
use super::hook::{Memory, Stretch, Structure};
use super::outlet::{Outlet, Through, Venting};
use super::phi::phi1;
use crate::model::{Areas, BaseModel, GAMMA, Nonlinear, Ports};
use crate::numeric::Scalar;

/// Absolute pressure at which the time constant of the gas temperature is stated, Pa: the middle of
/// the working range.
pub const HEAT_REFERENCE_PA: f64 = 250_000.0;

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

/// What flows through the ports during one step.
#[derive(Debug, Clone, Copy)]
struct Flows<S> {
    /// Rate of the pressure per flow pressure of the fill port, 1/s.
    fill: S,
    /// The same of the vent port.
    vent: S,
    /// Flow pressure of the fill port, Pa.
    inflow: S,
    /// Its slope by the pressure behind the port.
    in_by: S,
    /// Flow pressure of the vent port, Pa.
    outflow: S,
    /// Its slope by the pressure in front of the port.
    out_by: S,
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
    pub fn new(model: &BaseModel, structure: Structure<S>) -> Self {
        let gas = model.gas();
        // A regulator's chamber does no more than hold its pressure.
        let valve = model.valve().copied().unwrap_or(Nonlinear { gas, ..Nonlinear::default() });
        let ambient = S::constant(gas.ambient_pa);
        Self {
            structure,
            ports: Ports { own: valve.flow, general: structure.flow_function },
            conductance: valve.conductance(),
            ambient_pa: gas.ambient_pa,
            ambient_k: gas.temperature_k,
            pressure: ambient,
            temperature: S::constant(gas.temperature_k),
            port: ambient,
            outlet: structure.outlet.map(|outlet| Outlet::new(outlet, gas.ambient_pa)),
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

    /// Shows what is remembered from step to step: the pressure in the chamber, and what its
    /// structure adds.
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

    /// Does an effect change the volume?
    #[inline(always)]
    pub fn stretches(&self) -> bool {
        self.structure.stretches
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
        let flows = self.flows(h, c);
        if let Some(line) = self.structure.line {
            self.advance_line(h, c, &flows, &line);
        } else if let Some(tau) = self.structure.heat_time_constant_s {
            self.advance_heat(h, c, &flows, tau);
        } else {
            self.advance_gas(h, c, &flows);
        }
        c.areas.fill.real() * flows.inflow.real()
    }

    /// What flows through the ports, from the pressure in front of them. Where there is a
    /// restriction behind the vent port, the space between them is advanced.
    #[inline(always)]
    fn flows(&mut self, h: f64, c: &Conditions<S>) -> Flows<S> {
        let per_area = self.conductance / c.volume_m3;
        let (port, ambient) = (self.port(), S::constant(self.ambient_pa));
        let behind = self.outlet.map_or(ambient, |outlet| outlet.pressure);
        let (inflow, _, in_by) = self.ports.flow_pressure(c.supply, port);
        let (outflow, out_by, out_by_behind) = self.ports.flow_pressure(port, behind);
        let (outflow, out_by) = match &mut self.outlet {
            None => (outflow, out_by),
            Some(outlet) => {
                let restriction = outlet.parameters.area_ratio * c.open.vent;
                let venting = Venting { h, per_area, port_area: c.areas.vent, restriction };
                let through = Through { flow: outflow, by_port: out_by, by_behind: out_by_behind };
                let (onward, onward_by, _) = self.ports.flow_pressure(behind, ambient);
                outlet.advance(&self.ports, &venting, port, &through, (onward, onward_by))
            }
        };
        let (fill, vent) = (c.areas.fill.times(per_area), c.areas.vent.times(per_area));
        Flows { fill, vent, inflow, in_by, outflow, out_by }
    }

    /// The pressure alone.
    #[inline(always)]
    fn advance_gas(&mut self, h: f64, c: &Conditions<S>, flows: &Flows<S>) {
        let &Flows { fill, vent, inflow, in_by, outflow, out_by } = flows;
        let mut swelling = c.expansion.times(GAMMA);
        if self.stretches() {
            swelling = (c.expansion * c.stretch.factor + c.stretch.rate).times(GAMMA);
        }
        let mut rate = fill * inflow - vent * outflow - swelling * self.pressure;
        let mut slope = fill * in_by - vent * out_by - swelling;
        if self.stretches() {
            let room = c.stretch.factor + (self.pressure * c.stretch.by_pressure).times(GAMMA);
            (rate, slope) = (rate / room, slope / room);
        }
        self.pressure = self.pressure + rate * phi1(slope.times(h)).times(h);
    }

    /// Gas temperature as a second state.
    #[inline(always)]
    fn advance_heat(&mut self, h: f64, c: &Conditions<S>, flows: &Flows<S>, tau: S) {
        let &Flows { fill, vent, inflow, in_by, outflow, out_by } = flows;
        let (heat, growth) = (self.heat(h, c, tau), self.growth(c));
        let energy = |root: S| fill * inflow - vent * outflow * root - growth * self.pressure;
        let root = heat.warmth.sqrt();
        let settled = heat.settled(energy(root), fill * inflow - vent * outflow / root);
        let root = heat.mean_warmth(settled).sqrt();
        let rate = heat.rate(energy(root) - heat.taken(settled));
        let slope = heat.rate(fill * in_by - vent * out_by * root - growth);
        self.pressure = self.pressure + rate * phi1(slope.times(h)).times(h);
        self.temperature = heat.end(settled);
    }

    /// One step of the temperature.
    #[inline(always)]
    fn heat(&self, h: f64, c: &Conditions<S>, time_constant: S) -> Heat<S> {
        let &Self { pressure, temperature, ambient_k, .. } = self;
        let gas = Gas { pressure, temperature, ambient_k, time_constant, stretches: self.stretches() };
        Heat::new(h, &gas, c)
    }

    /// What the volume's growth without the pressure's part takes from the pressure, 1/s.
    #[inline(always)]
    fn growth(&self, c: &Conditions<S>) -> S {
        if self.stretches() {
            return (c.expansion * c.stretch.factor + c.stretch.rate).times(GAMMA);
        }
        c.expansion.times(GAMMA)
    }
}
