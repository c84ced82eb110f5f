//! What the integrator runs: parameters, spread and effects resolved to SI numbers for each
//! channel, board and the supply.

use super::background::Deviation;
use super::flow::FlowFunction;
use super::parameters::{GasModel, HEAT_REFERENCE_KPA_ABS, PlantParameters};

/// Gas constant of dry air, J/(kg K).
pub const GAS_CONSTANT: f64 = 287.05;
/// Ratio of specific heats of air.
pub const GAMMA: f64 = 1.4;

/// One channel: drive chain, valve, tubes, chamber, sensor.
#[derive(Debug, Clone)]
pub struct ChannelPhysics {
    pub drive: DrivePhysics,
    pub valve: ValvePhysics,
    pub chamber: ChamberPhysics,
    pub ageing: AgeingPhysics,
    pub sensor: SensorPhysics,
}

/// From the drive the board asks for to the position of the spool.
#[derive(Debug, Clone, Default)]
pub struct DrivePhysics {
    pub delay_s: f64,
    pub crosstalk: f64,
    /// Largest drive the driver can deliver, 0 to 1; `None` is full scale.
    pub limit: Option<f64>,
    pub lag_s: f64,
    pub play_half_width: f64,
    pub stiction_threshold: f64,
    /// Position at which the spool sticks, and the drive's distance that tears it off.
    pub sticking_spot: Option<(f64, f64)>,
    /// Steps of the driver's output; 0 is none.
    pub resolution: f64,
}

/// Conductances over the spool position.
#[derive(Debug, Clone)]
pub struct ValvePhysics {
    pub conductance: f64,
    pub fill_edge: f64,
    pub vent_edge: f64,
    pub corner: f64,
    pub leakage: f64,
    pub gain: f64,
    pub vent_gain: f64,
    /// Added to the spool position: where the spool stands at zero drive.
    pub centre: f64,
    /// Conductance of a leak past the fill edge, m^3/(s Pa).
    pub fill_leak: f64,
    /// Relative deviation of each edge's conductance over its opening, 0 to 1.
    pub fill_curve: Deviation,
    /// The same of the vent edge.
    pub vent_curve: Deviation,
}

/// The gas volumes behind one valve.
#[derive(Debug, Clone)]
pub struct ChamberPhysics {
    pub flow: FlowFunction,
    pub gas: GasPhysics,
    pub ambient_pa: f64,
    pub ambient_k: f64,
    pub area_m2: f64,
    pub length_m: f64,
    pub offset_m: f64,
    pub volume_factor: f64,
    /// Relative volume per pressure, at once, 1/Pa.
    pub compliance: f64,
    /// Relative volume per pressure in the long run beyond `compliance`, 1/Pa, and its time
    /// constant, s.
    pub creep: Option<(f64, f64)>,
    /// Tube between valve (with the sensor) and chamber.
    pub line: Option<SideVolume>,
    /// Volume and orifice between the vent edge and the air.
    pub muffler: Option<SideVolume>,
    /// Conductance of a leak from the valve's port to the air, m^3/(s Pa).
    pub exhaust_leak: f64,
}

/// A small volume with an orifice at its far end.
#[derive(Debug, Clone, Copy)]
pub struct SideVolume {
    pub conductance: f64,
    pub volume_m3: f64,
}

/// Resolved [`GasModel`].
#[derive(Debug, Clone, Copy)]
pub enum GasPhysics {
    Fixed {
        exponent: f64,
    },
    /// Conductance of the wall, W/K.
    Balance {
        wall_w_per_k: f64,
    },
}

/// What changes slowly in a channel.
#[derive(Debug, Clone, Default)]
pub struct AgeingPhysics {
    /// Logarithmic rate of the valve's gain, 1/s.
    pub wear_per_s: f64,
    /// Share of the gain a coil at full duty loses, and its thermal time constant, s.
    pub heating: Option<(f64, f64)>,
    pub water: Option<WaterPhysics>,
    pub burst: Option<BurstPhysics>,
}

/// Slugs of water in the line.
#[derive(Debug, Clone, Copy)]
pub struct WaterPhysics {
    pub depth: f64,
    pub mean_gap_s: f64,
    pub mean_slug_s: f64,
}

/// A crack that grows while the pressure is above a threshold.
#[derive(Debug, Clone, Copy)]
pub struct BurstPhysics {
    /// Growth of the leak's conductance per second and pascal above the threshold.
    pub growth: f64,
    pub threshold_pa: f64,
}

/// From the pressure at the port to the converter's counts.
#[derive(Debug, Clone)]
pub struct SensorPhysics {
    pub noise_kpa: f64,
    pub bits: u32,
    pub lag_s: f64,
    pub offset_kpa: f64,
    pub gain: f64,
    pub bow_kpa: f64,
    /// Final zero drift, kPa, and its time constant, s.
    pub drift: Option<(f64, f64)>,
    pub crosstalk: f64,
    /// Share of the time a sample is stale, and the mean length of a spell, s.
    pub stale: Option<(f64, f64)>,
    /// Half of the gap between rising and falling readings, kPa.
    pub play_kpa: f64,
}

/// The two axes of one board's joint.
#[derive(Debug, Clone, Copy)]
pub struct JointPhysics {
    pub free: bool,
    pub angle_per_pa: f64,
    pub angular_frequency: f64,
    pub damping_ratio: f64,
}

/// The shared supply; absolute pressures.
#[derive(Debug, Clone)]
pub struct SupplyPhysics {
    pub nominal_pa: f64,
    pub gauge_pa: f64,
    pub level_pa: f64,
    /// Amplitude, Pa, and period, s.
    pub ripple: Option<(f64, f64)>,
    /// Amplitude, K, and period, s.
    pub temperature_cycle: Option<(f64, f64)>,
    pub line: Option<SupplyLine>,
    pub relay: Option<RelayRegulator>,
    pub wander: f64,
    pub wander_time_s: f64,
    /// The same over 2 s.
    pub fast_wander: f64,
}

/// Line from the regulator to the valves' manifold: `drop = linear m + quadratic m^2`.
#[derive(Debug, Clone, Copy)]
pub struct SupplyLine {
    pub linear: f64,
    pub quadratic: f64,
    pub volume_m3: f64,
}

/// A tank that is refilled between two pressures.
#[derive(Debug, Clone, Copy)]
pub struct RelayRegulator {
    pub half_band_pa: f64,
    pub volume_m3: f64,
    pub refill_kg_per_s: f64,
}

impl PlantParameters {
    /// Mass flow of one open fill edge into an empty chamber, kg/s: the yardstick for effects of
    /// the supply.
    pub(super) fn reference_flow(&self) -> f64 {
        self.valve.conductance_m3_per_s_pa * super::flow::ANR_DENSITY_KG_PER_M3 * self.supply_pa_abs()
    }

    pub(super) fn ambient_pa(&self) -> f64 {
        1e3 * self.ambient.pressure_kpa_abs
    }

    pub(super) fn supply_pa_abs(&self) -> f64 {
        self.ambient_pa() + 1e3 * self.supply.pressure_kpa
    }

    /// Wall conductance, W/K, for a temperature time constant at the reference pressure.
    pub(super) fn wall_conductance(&self, time_constant_s: f64) -> f64 {
        let volume = self.chamber.resting_volume_m3();
        let mass = 1e3 * HEAT_REFERENCE_KPA_ABS * volume / (GAS_CONSTANT * self.ambient.temperature_k);
        mass * GAS_CONSTANT / (GAMMA - 1.0) / time_constant_s
    }

    pub(super) fn channel_physics(&self) -> ChannelPhysics {
        let valve = &self.valve;
        ChannelPhysics {
            drive: DrivePhysics { lag_s: valve.spool_time_constant_s, ..DrivePhysics::default() },
            valve: ValvePhysics {
                conductance: valve.conductance_m3_per_s_pa,
                fill_edge: valve.fill_edge,
                vent_edge: valve.vent_edge,
                corner: valve.corner,
                leakage: valve.leakage,
                gain: 1.0,
                vent_gain: 1.0,
                centre: 0.0,
                fill_leak: 0.0,
                fill_curve: [0.0; 3],
                vent_curve: [0.0; 3],
            },
            chamber: ChamberPhysics {
                flow: valve.flow,
                gas: match self.gas {
                    GasModel::FixedTemperature { polytropic_exponent } => {
                        GasPhysics::Fixed { exponent: polytropic_exponent }
                    }
                    GasModel::EnergyBalance { wall_time_constant_s } => {
                        GasPhysics::Balance { wall_w_per_k: self.wall_conductance(wall_time_constant_s) }
                    }
                },
                ambient_pa: self.ambient_pa(),
                ambient_k: self.ambient.temperature_k,
                area_m2: self.chamber.area_m2(),
                length_m: self.chamber.length_m,
                offset_m: self.chamber.offset_m,
                volume_factor: 1.0,
                compliance: 0.0,
                creep: None,
                line: None,
                muffler: None,
                exhaust_leak: 0.0,
            },
            ageing: AgeingPhysics::default(),
            sensor: SensorPhysics {
                noise_kpa: self.sensor.noise_kpa,
                bits: self.sensor.adc_bits,
                lag_s: 0.0,
                offset_kpa: 0.0,
                gain: 1.0,
                bow_kpa: 0.0,
                drift: None,
                crosstalk: 0.0,
                stale: None,
                play_kpa: 0.0,
            },
        }
    }

    pub(super) fn joint_physics(&self) -> JointPhysics {
        JointPhysics {
            free: self.joint.free,
            angle_per_pa: 1e-6 * self.joint.angle_rad_per_mpa,
            angular_frequency: core::f64::consts::TAU * self.joint.natural_frequency_hz,
            damping_ratio: self.joint.damping_ratio,
        }
    }

    pub(super) fn supply_physics(&self) -> SupplyPhysics {
        SupplyPhysics {
            nominal_pa: self.supply_pa_abs(),
            gauge_pa: 1e3 * self.supply.pressure_kpa,
            level_pa: 0.0,
            ripple: None,
            temperature_cycle: None,
            line: None,
            relay: None,
            wander: self.nuisances.supply_wander,
            wander_time_s: self.nuisances.supply_wander_time_s,
            fast_wander: self.nuisances.background.fast_wander,
        }
    }
}
