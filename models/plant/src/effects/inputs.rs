//! What is known about a channel from the recording, row by row.

use std::sync::Arc;

/// One value per row. Channels of a recording share what they have in common, and copies of a
/// channel everything: of an hour each series takes megabytes.
pub type Series = Arc<[f64]>;

/// How a channel is driven.
#[derive(Debug, Clone, PartialEq)]
pub enum DriveInput {
    /// Recorded drive of one spool, -1 to 1.
    Spool(Series),
    /// Recorded drives of a fill and a vent valve, 0 to 1.
    Separate {
        /// Fill valve's drive.
        fill: Series,
        /// Vent valve's drive.
        vent: Series,
    },
    /// The board's own controller, from the command.
    Controlled,
    /// A regulator with its own loop: command in, pressure out.
    Command,
}

/// Measured inputs of one channel. All vectors have one value per row; what belongs to an interval
/// belongs to the one that starts at the row. Pressures are absolute and in Pa.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelInputs {
    /// Time from the start of the recording, s.
    pub time_s: Series,
    /// Length of the interval to the next row, s.
    pub interval_s: Series,
    /// Length of the whole recording, s.
    pub duration_s: f64,
    /// Rows at which a simulation starts anew; the first is 0.
    pub starts: Arc<[usize]>,
    /// Rows at which a simulation's pressure is moved so that its reading is the measured one, once
    /// what it remembers of the time before its start has settled: where spools stood and what
    /// temperature the gas had when a recording begins is not known, and a chamber whose loop is
    /// not simulated keeps the error for seconds.
    pub anchors: Arc<[usize]>,
    /// Drive.
    pub drive: DriveInput,
    /// Commanded pressure, Pa.
    pub command_pa: Series,
    /// Supply pressure, Pa.
    pub supply_pa: Series,
    /// Geometric chamber volume, mean over the interval, m^3.
    pub volume_m3: Series,
    /// Its rate, m^3/s.
    pub volume_rate_m3_s: Series,
    /// Measured pressure, Pa; the last usable one where it is missing.
    pub measured_pa: Series,
    /// Whether the measured pressure may be compared.
    pub usable: Arc<[bool]>,
    /// Measured pressure of the chamber opposite on the same axis, smoothed, gauge Pa; empty when
    /// there is none.
    pub opposite_pa: Series,
    /// Measured pressure of the channel that the converter samples before this one, gauge Pa; empty
    /// when there is none.
    pub sampled_before_pa: Series,
    /// How hard the channel that the board handles before this one is driven, -1 to 1; empty when
    /// that is not known.
    pub neighbour_drive: Series,
    /// Mass flow that all channels but this one draw from the supply, over the interval, in mm^2 Pa
    /// (area by flow pressure).
    pub others_draw: Series,
    /// Noise of the measurement, Pa RMS.
    pub noise_pa: f64,
    /// Ambient pressure, Pa.
    pub ambient_pa: f64,
}

impl ChannelInputs {
    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// Is what moves one spool recorded?
    #[must_use]
    pub fn spool_is_recorded(&self) -> bool {
        matches!(self.drive, DriveInput::Spool(_))
    }

    /// Whether a board's loop, which follows the sensor, is part of the simulation.
    #[must_use]
    pub fn in_loop(&self) -> bool {
        self.drive == DriveInput::Controlled
    }
}
