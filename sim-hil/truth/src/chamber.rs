//! Mass and energy balance of the gas behind one valve.
//!
//! Up to three volumes: the chamber, the tube between valve and chamber, and the space between the
//! vent edge and a muffler. The sensor sits at the valve's port. First law for an ideal gas of
//! constant heats (`d(p V)/(gamma - 1) = cp sum(T m) + Q - p dV`):
//!
//! `V dp/dt = gamma R sum(T_i m_i) + (gamma - 1) Q - gamma p dV/dt`

use super::physics::{ChamberPhysics, GAMMA, GAS_CONSTANT, GasPhysics};
use super::valve::Conductances;

/// State of one channel's gas. The order is that of the integrator's vector.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GasState {
    /// Absolute pressure in the chamber, Pa.
    pub chamber_pa: f64,
    /// Mass in the chamber, kg. Follows the pressure when the temperature is fixed.
    pub mass_kg: f64,
    /// Absolute pressure in the tube, Pa.
    pub line_pa: f64,
    /// Absolute pressure before the muffler, Pa.
    pub muffler_pa: f64,
    /// Slow relative stretch of the wall.
    pub creep: f64,
}

/// Length of [`GasState`] as numbers.
pub const GAS_STATES: usize = 5;

impl GasState {
    #[inline]
    pub fn from_slice(y: &[f64; GAS_STATES]) -> Self {
        Self { chamber_pa: y[0], mass_kg: y[1], line_pa: y[2], muffler_pa: y[3], creep: y[4] }
    }

    #[inline]
    pub fn to_array(self) -> [f64; GAS_STATES] {
        [self.chamber_pa, self.mass_kg, self.line_pa, self.muffler_pa, self.creep]
    }
}

/// What the rest of the rig imposes on a chamber at one instant.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings {
    pub supply_pa: f64,
    pub supply_k: f64,
    pub valve: Conductances,
    /// Leak from the port to the air, m^3/(s Pa).
    pub leak: f64,
    /// Bending angle with the sign that lengthens this chamber, rad, and its rate, rad/s.
    pub angle: f64,
    pub angle_rate: f64,
}

/// Mass flows, kg/s, positive in the direction of the name.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Flows {
    /// Supply to port.
    pub fill: f64,
    /// Port to exhaust.
    pub vent: f64,
    /// Port to air, past the valve.
    pub leak: f64,
}

impl ChamberPhysics {
    /// Volume of the chamber, m^3.
    #[inline]
    pub fn volume(&self, chamber_pa: f64, creep: f64, angle: f64) -> f64 {
        let stretch = 1.0 + self.compliance * (chamber_pa - self.ambient_pa) + creep;
        self.cylinder(angle) * stretch
    }

    #[inline]
    fn cylinder(&self, angle: f64) -> f64 {
        self.volume_factor * self.area_m2 * (self.length_m + self.offset_m * angle)
    }

    /// Gas temperature in the chamber, K.
    #[inline]
    pub fn temperature(&self, y: &GasState, volume: f64) -> f64 {
        match self.gas {
            GasPhysics::Fixed { .. } => self.ambient_k,
            GasPhysics::Balance { .. } => y.chamber_pa * volume / (GAS_CONSTANT * y.mass_kg),
        }
    }

    /// Mass in the chamber, kg; `p V / (R T)` when the temperature is fixed.
    pub fn mass(&self, y: &GasState, volume: f64) -> f64 {
        match self.gas {
            GasPhysics::Fixed { .. } => y.chamber_pa * volume / (GAS_CONSTANT * self.ambient_k),
            GasPhysics::Balance { .. } => y.mass_kg,
        }
    }

    /// Pressure at the valve's port, where the sensor sits.
    #[inline]
    pub fn port_pa(&self, y: &GasState) -> f64 {
        if self.line.is_some() { y.line_pa } else { y.chamber_pa }
    }

    /// All volumes at one gauge pressure and ambient temperature.
    pub fn at_rest(&self, chamber_pa: f64) -> GasState {
        let mut y =
            GasState { chamber_pa, line_pa: chamber_pa, muffler_pa: self.ambient_pa, ..GasState::default() };
        if let Some((compliance, _)) = self.creep {
            y.creep = compliance * (chamber_pa - self.ambient_pa);
        }
        y.mass_kg = chamber_pa * self.volume(chamber_pa, y.creep, 0.0) / (GAS_CONSTANT * self.ambient_k);
        y
    }

    /// Whether the channel is nothing but a rigid chamber of gas at a fixed temperature.
    pub fn is_plain(&self) -> bool {
        let fixed = matches!(self.gas, GasPhysics::Fixed { .. });
        let rigid = self.compliance.abs() <= 0.0 && self.creep.is_none();
        fixed && rigid && self.line.is_none() && self.muffler.is_none()
    }

    /// [`ChamberPhysics::rates`] of a plain channel with a still joint and no leak, a quarter
    /// faster: most channels of most runs are that. The same numbers to the last bit.
    #[inline]
    pub fn plain_rates(&self, y: &GasState, s: &Surroundings) -> (GasState, Flows) {
        let exponent = match self.gas {
            GasPhysics::Fixed { exponent } => exponent,
            GasPhysics::Balance { .. } => f64::NAN,
        };
        let p = y.chamber_pa;
        let fill = self.flow.mass_flow(s.valve.fill, s.supply_pa, s.supply_k, p, self.ambient_k);
        let vent = self.flow.mass_flow(s.valve.vent, p, self.ambient_k, self.ambient_pa, self.ambient_k);
        let fill_k = if fill >= 0.0 { s.supply_k } else { self.ambient_k };
        let heat_flow = fill_k * fill - self.ambient_k * vent;
        let chamber_pa = exponent * GAS_CONSTANT * heat_flow / self.cylinder(0.0);
        (GasState { chamber_pa, ..GasState::default() }, Flows { fill, vent, leak: 0.0 })
    }

    /// Rates of change of the state, and the flows that cause them.
    #[inline]
    pub fn rates(&self, y: &GasState, s: &Surroundings) -> (GasState, Flows) {
        let port = self.port_pa(y);
        let cylinder = self.cylinder(s.angle);
        let stretch = 1.0 + self.compliance * (y.chamber_pa - self.ambient_pa) + y.creep;
        let volume = cylinder * stretch;
        let gas_k = self.temperature(y, volume);
        let port_k = if self.line.is_some() { self.ambient_k } else { gas_k };
        let exhaust = if self.muffler.is_some() { y.muffler_pa } else { self.ambient_pa };

        let flows = Flows {
            fill: self.flow.mass_flow(s.valve.fill, s.supply_pa, s.supply_k, port, port_k),
            vent: self.flow.mass_flow(s.valve.vent, port, port_k, exhaust, self.ambient_k),
            leak: if s.leak > 0.0 {
                self.flow.mass_flow(s.leak, port, port_k, self.ambient_pa, self.ambient_k)
            } else {
                0.0
            },
        };
        let mut rate = GasState::default();
        let outflow = flows.vent + flows.leak;
        // What flows in from the supply carries its temperature, what flows back carries the
        // port's.
        let fill_k = if flows.fill >= 0.0 { s.supply_k } else { port_k };
        let out_k = if outflow >= 0.0 { port_k } else { self.ambient_k };
        let (into_chamber, heat_flow) = match &self.line {
            None => (flows.fill - outflow, fill_k * flows.fill - out_k * outflow),
            Some(line) => {
                let through = self.flow.mass_flow(line.conductance, port, port_k, y.chamber_pa, gas_k);
                // A thin tube exchanges heat within milliseconds: isothermal, unless the whole
                // plant is of fixed temperature.
                let exponent = match self.gas {
                    GasPhysics::Fixed { exponent } => exponent,
                    GasPhysics::Balance { .. } => 1.0,
                };
                rate.line_pa = exponent * GAS_CONSTANT * self.ambient_k / line.volume_m3
                    * (flows.fill - outflow - through);
                (through, if through >= 0.0 { port_k * through } else { gas_k * through })
            }
        };
        if let Some(muffler) = &self.muffler {
            let through = self.flow.mass_flow(
                muffler.conductance,
                exhaust,
                self.ambient_k,
                self.ambient_pa,
                self.ambient_k,
            );
            rate.muffler_pa = GAS_CONSTANT * self.ambient_k / muffler.volume_m3 * (flows.vent - through);
        }
        if let Some((compliance, time_constant)) = self.creep {
            rate.creep = (compliance * (y.chamber_pa - self.ambient_pa) - y.creep) / time_constant;
        }
        // Part of dV/dt that does not hang on dp/dt; the wall's prompt stretch goes to the
        // left-hand side.
        let lengthening = self.volume_factor * self.area_m2 * self.offset_m * s.angle_rate;
        let swelling = lengthening * stretch + cylinder * rate.creep;
        let (exponent, heat) = match self.gas {
            GasPhysics::Fixed { exponent } => (exponent, 0.0),
            GasPhysics::Balance { wall_w_per_k } => {
                rate.mass_kg = into_chamber;
                (GAMMA, (GAMMA - 1.0) * wall_w_per_k * (self.ambient_k - gas_k))
            }
        };
        let gain = exponent * y.chamber_pa;
        rate.chamber_pa = (exponent * GAS_CONSTANT * heat_flow + heat - gain * swelling)
            / (volume + gain * cylinder * self.compliance);
        (rate, flows)
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameters::PlantParameters;
    use super::super::physics::SideVolume;
    use super::*;

    /// The shortcut is the general balance, bit for bit, filling, venting and holding.
    #[test]
    fn plain_rates_are_the_general_ones() {
        let chamber = PlantParameters::default().channel_physics().chamber;
        assert!(chamber.is_plain());
        for (fill, vent, kpa) in
            [(3e-9, 1e-11, 1.0), (1e-11, 3e-9, 500.0), (2e-11, 1e-11, 549.9), (1e-10, 1e-10, 600.0)]
        {
            let y = chamber.at_rest(chamber.ambient_pa + 1e3 * kpa);
            let surroundings = Surroundings {
                supply_pa: 651_325.0,
                supply_k: 300.0,
                valve: Conductances { fill, vent },
                leak: 0.0,
                angle: 0.0,
                angle_rate: 0.0,
            };
            assert_eq!(chamber.plain_rates(&y, &surroundings), chamber.rates(&y, &surroundings));
        }
    }

    /// What makes a channel more than plain is noticed.
    #[test]
    fn anything_more_is_not_plain() {
        let chamber = PlantParameters::default().channel_physics().chamber;
        assert!(!ChamberPhysics { compliance: 1e-7, ..chamber.clone() }.is_plain());
        assert!(!ChamberPhysics { creep: Some((1e-7, 1.0)), ..chamber.clone() }.is_plain());
        let side = Some(SideVolume { conductance: 1e-9, volume_m3: 1e-5 });
        assert!(!ChamberPhysics { line: side, ..chamber.clone() }.is_plain());
        assert!(!ChamberPhysics { muffler: side, ..chamber.clone() }.is_plain());
        assert!(!ChamberPhysics { gas: GasPhysics::Balance { wall_w_per_k: 1.0 }, ..chamber }.is_plain());
    }
}
