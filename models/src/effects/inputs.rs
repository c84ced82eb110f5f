//! What is known about a channel from the recording, row by row.

/// How a channel is driven.
#[derive(Debug, Clone, PartialEq)]
pub enum DriveInput {
    /// Recorded drive of one spool, -1 to 1.
    Spool(Vec<f64>),
    /// Recorded drives of a fill and a vent valve, 0 to 1.
    Separate {
        /// Fill valve's drive.
        fill: Vec<f64>,
        /// Vent valve's drive.
        vent: Vec<f64>,
    },
    /// The board's own controller, from the command.
    Controlled,
    /// A regulator with its own loop: command in, pressure out.
    Command,
}

/// Measured inputs of one channel. All vectors have one value per row; what belongs to an interval belongs to the one that
/// starts at the row. Pressures are absolute and in Pa.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelInputs {
    /// Time from the start of the recording, s.
    pub time_s: Vec<f64>,
    /// Length of the interval to the next row, s.
    pub interval_s: Vec<f64>,
    /// Length of the whole recording, s.
    pub duration_s: f64,
    /// Rows at which a simulation starts anew; the first is 0.
    pub starts: Vec<usize>,
    /// Drive.
    pub drive: DriveInput,
    /// Commanded pressure, Pa.
    pub command_pa: Vec<f64>,
    /// Supply pressure, Pa.
    pub supply_pa: Vec<f64>,
    /// Geometric chamber volume, mean over the interval, m^3.
    pub volume_m3: Vec<f64>,
    /// Its rate, m^3/s.
    pub volume_rate_m3_s: Vec<f64>,
    /// Measured pressure, Pa; the last usable one where it is missing.
    pub measured_pa: Vec<f64>,
    /// Whether the measured pressure may be compared.
    pub usable: Vec<bool>,
    /// Measured pressure of the chamber opposite on the same axis, smoothed, gauge Pa; empty when there is none.
    pub opposite_pa: Vec<f64>,
    /// Measured pressure of the channel that the converter samples before this one, gauge Pa; empty when there is none.
    pub sampled_before_pa: Vec<f64>,
    /// Mass flow that all channels but this one draw from the supply, over the interval, in mm^2 Pa (area by flow pressure).
    pub others_draw: Vec<f64>,
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

    /// Whether a board's loop, which follows the sensor, is part of the simulation.
    #[must_use]
    pub fn in_loop(&self) -> bool {
        self.drive == DriveInput::Controlled
    }
}
