//! What the plant knows and no sensor tells.

/// The true state of one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelTruth {
    /// Absolute pressure in the chamber, Pa.
    pub pressure_pa: f64,
    /// Absolute pressure at the valve's port, where the sensor sits, Pa; the chamber's unless a
    /// tube lies between.
    pub port_pa: f64,
    /// Gas temperature in the chamber, K.
    pub temperature_k: f64,
    /// Gas in the chamber, kg (`p V / (R T)` in the fixed-temperature limit).
    pub mass_kg: f64,
    /// Volume of the chamber, m^3.
    pub volume_m3: f64,
    /// Drive set by the board, -1 to 1.
    pub drive: f64,
    /// Spool position, -1 to 1.
    pub spool: f64,
    /// Mass flow from the supply, kg/s.
    pub fill_kg_per_s: f64,
    /// Mass flow past the vent edge, kg/s.
    pub vent_kg_per_s: f64,
    /// Mass flow through leaks and cracks to the air, kg/s.
    pub leak_kg_per_s: f64,
}
