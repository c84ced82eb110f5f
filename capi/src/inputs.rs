//! What a caller says about a step.

use crate::error::StepError;

/// In an input's `repeats`: the sample at the start of the step repeats the one before it.
pub const REPEATS_START: u32 = 1;
/// In an input's `repeats`: the sample at the end of the step repeats the one at its start.
pub const REPEATS_END: u32 = 2;
/// In an input's `repeats`: the sample one step after the end of the step repeats the one at its
/// end.
pub const REPEATS_AFTER: u32 = 4;

/// What drives a channel.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Control {
    /// What drove it when it was calibrated.
    #[default]
    AsCalibrated = 0,
    /// The valve's drive.
    Drive = 1,
    /// The set point, through the board's loop; the parameter file's rig must have the tables
    /// controller and sensor.
    SetPoint = 2,
}

impl Control {
    /// Of its number in C.
    pub(crate) fn of(number: u32) -> Option<Self> {
        [Self::AsCalibrated, Self::Drive, Self::SetPoint]
            .into_iter()
            .find(|control| *control as u32 == number)
    }
}

/// What holds over a step. `pneudrive_nominal` fills it in.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// Drive of the spool, -1 (vent) to 1 (fill), or of the fill valve, 0 to 1. Not read where a
    /// set point drives.
    pub fill: f64,
    /// Drive of the vent valve, 0 to 1, where it is one of its own.
    pub vent: f64,
    /// Set point, kPa gauge; read where it drives the channel. The board follows it from its second
    /// loop in the step on.
    pub set_point_kpa: f64,
    /// Supply pressure, kPa gauge, mean over the step.
    pub supply_kpa: f64,
    /// Volume of the chamber as its joint stands, m^3, mean over the step; positive.
    pub volume_m3: f64,
    /// Rate of that volume, m^3/s.
    pub volume_rate_m3_s: f64,
    /// Pressure of the chamber opposite at the start and at the end of the step, kPa gauge: for the
    /// effect chamber_coupling, which stands for a joint that nobody simulates. NaN: there is none,
    /// or the volume above says it all.
    pub opposite_kpa: [f64; 2],
    /// Reading of the channel that the board's converter samples before this one, at the start and
    /// at the end of the step, kPa gauge: for the effect sensor_crosstalk. NaN: unknown.
    pub sampled_before_kpa: [f64; 2],
    /// What the other channels draw from the same supply, mm^2 Pa: the sum of their `draw`. For the
    /// effect supply_sag.
    pub others_draw: f64,
    /// Which samples of the sensor were missed and repeat the one before: bits 1 (at the start of
    /// the step), 2 (at its end) and 4 (one step later). For the effect stale_samples.
    pub repeats: u32,
}

impl Inputs {
    /// Refuses what no simulation can go on from.
    pub(crate) fn check(&self) -> Result<(), StepError> {
        let numbers = [
            ("fill", self.fill),
            ("vent", self.vent),
            ("set_point_kpa", self.set_point_kpa),
            ("supply_kpa", self.supply_kpa),
            ("volume_m3", self.volume_m3),
            ("volume_rate_m3_s", self.volume_rate_m3_s),
            ("others_draw", self.others_draw),
        ];
        if let Some((name, value)) = numbers.into_iter().find(|(_, value)| !value.is_finite()) {
            return Err(StepError::Input { name, value });
        }
        if self.volume_m3 <= 0.0 {
            return Err(StepError::Input { name: "volume_m3", value: self.volume_m3 });
        }
        Ok(())
    }
}
