//! A row of a recording, as it arrives.

use crate::data::ChannelId;

/// What is measured of one channel in a row. What is missing is not a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Measured pressure, kPa gauge.
    pub pressure_kpa: f64,
    /// Commanded pressure, kPa gauge.
    pub command_kpa: f64,
    /// Drive of the spool, -1 to 1, or of the fill valve, 0 to 1.
    pub drive: f64,
    /// Drive of the vent valve, 0 to 1, where there are two valves.
    pub vent: f64,
    /// Angle of the joint that changes the volume, rad.
    pub angle_rad: f64,
}

impl Default for Reading {
    fn default() -> Self {
        let nothing = f64::NAN;
        Self {
            pressure_kpa: nothing,
            command_kpa: nothing,
            drive: nothing,
            vent: nothing,
            angle_rad: nothing,
        }
    }
}

/// A row.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// Time, s.
    pub t_s: f64,
    /// Measured supply pressure, kPa gauge; not a number where there is none.
    pub supply_kpa: f64,
    /// Of each channel, in the order of the [`Columns`].
    pub channels: Vec<Reading>,
}

impl Default for Sample {
    fn default() -> Self {
        Self { t_s: 0.0, supply_kpa: f64::NAN, channels: Vec::new() }
    }
}

/// What a recording has of one channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Columns {
    /// Which channel.
    pub id: ChannelId,
    /// Is its command recorded?
    pub command: bool,
    /// Is the drive of its spool recorded?
    pub spool: bool,
    /// Are the drives of two valves recorded?
    pub separate: bool,
    /// Is the angle of its joint recorded?
    pub angle: bool,
}
