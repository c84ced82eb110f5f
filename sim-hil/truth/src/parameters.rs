//! What the rig is like before any effect is switched on.
//!
//! The defaults are the nominal rig of the project (chambers of 0.36 litre, 550 kPa supply) with a
//! valve that fills a chamber from 0 to 300 kPa in 0.41 s. Pressures whose name says nothing else
//! are gauge.

use super::background::Background;
use super::flow::FlowFunction;

/// A rig: one supply, `channels` valve/chamber/sensor channels, four to a board, two joint axes to
/// a board.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantParameters {
    /// Channels in the rig, 1 to 1024; the last board may have fewer than four.
    pub channels: usize,
    /// Integration step, ns, 1000 to 200 000. Default 50 us, that is 20 kHz.
    pub step_ns: u64,
    /// The air around.
    pub ambient: AmbientParameters,
    /// The shared supply.
    pub supply: SupplyParameters,
    /// The chambers.
    pub chamber: ChamberParameters,
    /// What the gas in a chamber does with heat.
    pub gas: GasModel,
    /// The proportional valves.
    pub valve: ValveParameters,
    /// The continuum joint that four chambers move.
    pub joint: JointParameters,
    /// The pressure sensors.
    pub sensor: SensorParameters,
    /// What differs from run to run and from channel to channel without being an effect.
    pub nuisances: Nuisances,
}

/// The air around: where the valves vent to, and what the gauge pressures refer to.
#[derive(Debug, Clone, PartialEq)]
pub struct AmbientParameters {
    /// Absolute pressure, kPa, 50 to 120.
    pub pressure_kpa_abs: f64,
    /// Temperature of the air, the walls and the supply, K, 250 to 350.
    pub temperature_k: f64,
}

/// The shared supply.
#[derive(Debug, Clone, PartialEq)]
pub struct SupplyParameters {
    /// Gauge pressure at the regulator, kPa, 50 to 1500.
    pub pressure_kpa: f64,
}

/// A cylindrical chamber of a continuum joint: volume `pi radius^2 (length +- offset q)`.
#[derive(Debug, Clone, PartialEq)]
pub struct ChamberParameters {
    /// Radius, m, 0.001 to 0.2.
    pub radius_m: f64,
    /// Length of the straight joint, m, 0.005 to 2.
    pub length_m: f64,
    /// Distance of the chamber's axis from the joint's, m, 0 to 0.5.
    pub offset_m: f64,
    /// Pressure at time zero, gauge kPa, 0 to the supply pressure.
    pub initial_kpa: f64,
}

/// What the gas in a chamber does with heat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GasModel {
    /// `dp/dt = n R T / V (m_in - m_out) - n p V' / V` with `T` the fixed ambient temperature.
    ///
    /// With `n = 1.4` this is the printed nonlinear model: the adiabatic balance in which the
    /// outflow carries the enthalpy of gas at ambient temperature. It does not conserve mass
    /// (`p V / (R T)` is not the integral of the flows). With `n = 1` it is the isothermal balance,
    /// which does.
    FixedTemperature {
        /// `n`, 1 to 1.67.
        polytropic_exponent: f64,
    },
    /// Mass and energy balance with heat exchange to a wall at ambient temperature.
    EnergyBalance {
        /// Time constant of the gas temperature at 250 kPa absolute in the resting volume, s, 0.002
        /// or more; infinite is the adiabatic chamber. The wall's conductance is constant, so the
        /// time constant grows with the mass.
        wall_time_constant_s: f64,
    },
}

/// Absolute pressure at which [`GasModel::EnergyBalance`] states its time constant, kPa: the middle
/// of the working range.
pub const HEAT_REFERENCE_KPA_ABS: f64 = 250.0;

/// A proportional valve: one spool, a fill edge and a vent edge (ISO 6358 conductances).
///
/// An edge's conductance over the spool position `x` is `L + corner(G (x - U) - L)` with
/// `corner(y) = (y + sqrt(y^2 + e^2)) / 2`, the slope `G` such that the edge is open at `|x| = 1`.
#[derive(Debug, Clone, PartialEq)]
pub struct ValveParameters {
    /// Sonic conductance of an open edge, m^3/(s Pa) as in ISO 6358-1 (1e-8 is 1 dm^3/(s bar)),
    /// 1e-11 to 1e-6.
    pub conductance_m3_per_s_pa: f64,
    /// Spool position at which the fill edge would open if its corner were sharp, -0.5 to 0.5.
    pub fill_edge: f64,
    /// Spool position at which the vent edge would open, going down; -0.5 to 0.5.
    pub vent_edge: f64,
    /// Width `e` of both corners as a fraction of the open conductance, 0.0001 to 0.5.
    pub corner: f64,
    /// Leakage `L` of a closed edge as a fraction of the open conductance, 0 to 0.2.
    pub leakage: f64,
    /// ISO 6358 flow function: critical ratio, subsonic exponent, laminar segment.
    pub flow: FlowFunction,
    /// First-order lag of the spool behind the drive, s; 0 is a prompt spool.
    pub spool_time_constant_s: f64,
}

/// The joint four chambers move: two bending angles, each a damped second-order system driven by a
/// pair's pressure difference.
#[derive(Debug, Clone, PartialEq)]
pub struct JointParameters {
    /// Whether it moves. A locked joint has both angles at 0.
    pub free: bool,
    /// Bending per pressure difference at rest, rad/MPa, 0 to 5.
    pub angle_rad_per_mpa: f64,
    /// Undamped natural frequency, Hz, 0.05 to 50.
    pub natural_frequency_hz: f64,
    /// Damping ratio, 0.01 to 10.
    pub damping_ratio: f64,
}

/// A ratiometric sensor (0.5 to 4.5 V over 0 to 100 psi) and its converter.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorParameters {
    /// Noise before conversion, kPa RMS, white over samples, 0 to 20. With 12-bit conversion
    /// rounded to the bus's 10 bits (0.258 kPa RMS) the default makes 0.36 kPa.
    pub noise_kpa: f64,
    /// Converter bits, 8 to 12. [`Plant::sample`](super::Plant::sample) answers on the 12-bit
    /// scale; fewer bits make coarser steps.
    pub adc_bits: u32,
}

/// What differs from run to run and from channel to channel without being an effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Nuisances {
    /// Slow random wander of the supply, fraction of its gauge pressure, standard deviation, 0 to
    /// 0.2.
    pub supply_wander: f64,
    /// Correlation time of the wander, s, 0.5 or more.
    pub supply_wander_time_s: f64,
    /// Spread of conductance, volume, edges and leakage from channel to channel, relative standard
    /// deviation, 0 to 0.3.
    pub spread: f64,
    /// What every real rig has and no textbook describes.
    pub background: Background,
}

impl Default for PlantParameters {
    fn default() -> Self {
        Self {
            channels: 4,
            step_ns: 50_000,
            ambient: AmbientParameters { pressure_kpa_abs: 101.325, temperature_k: 293.15 },
            supply: SupplyParameters { pressure_kpa: 550.0 },
            chamber: ChamberParameters { radius_m: 0.024, length_m: 0.20, offset_m: 0.045, initial_kpa: 0.0 },
            gas: GasModel::FixedTemperature { polytropic_exponent: 1.4 },
            valve: ValveParameters {
                conductance_m3_per_s_pa: 3.0e-9,
                fill_edge: 0.05,
                vent_edge: -0.05,
                corner: 0.02,
                leakage: 0.002,
                flow: FlowFunction::default(),
                spool_time_constant_s: 0.0,
            },
            joint: JointParameters {
                free: false,
                angle_rad_per_mpa: 1.0,
                natural_frequency_hz: 1.5,
                damping_ratio: 0.5,
            },
            sensor: SensorParameters { noise_kpa: 0.25, adc_bits: 12 },
            nuisances: Nuisances::none(),
        }
    }
}

impl Nuisances {
    /// No wander, all channels alike.
    #[must_use]
    pub fn none() -> Self {
        Self { supply_wander: 0.0, supply_wander_time_s: 20.0, spread: 0.0, background: Background::none() }
    }

    /// What a laboratory rig shows: 1 % supply wander over 20 s, 5 % spread between channels.
    #[must_use]
    pub fn laboratory() -> Self {
        Self { supply_wander: 0.01, supply_wander_time_s: 20.0, spread: 0.05, background: Background::none() }
    }
}

impl ChamberParameters {
    /// Cross-section, m^2.
    pub(super) fn area_m2(&self) -> f64 {
        core::f64::consts::PI * self.radius_m * self.radius_m
    }

    /// Volume with the joint straight and the wall unstretched, m^3.
    #[must_use]
    pub fn resting_volume_m3(&self) -> f64 {
        self.area_m2() * self.length_m
    }
}
