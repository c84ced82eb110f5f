//! How the end of a step follows its beginning.

/// Derivatives of the pressure at the end of a step: what a controller or a planner linearises
/// with. Central differences of two steps each, over 0.1 kPa, 0.001 of full drive, 0.1 % of volume
/// and, for the set point, which a board takes in whole counts, 4 kPa.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Partials {
    /// By the pressure at its start, kPa/kPa.
    pub by_pressure: f64,
    /// By the drive of the spool or the fill valve, kPa.
    pub by_fill: f64,
    /// By the drive of the vent valve, kPa; 0 where one spool opens both ports.
    pub by_vent: f64,
    /// By the set point, kPa/kPa.
    pub by_set_point: f64,
    /// By the supply pressure, kPa/kPa.
    pub by_supply: f64,
    /// By the volume, kPa/m^3.
    pub by_volume: f64,
    /// By the rate of the volume, kPa s/m^3.
    pub by_volume_rate: f64,
}
