//! A recording: typed columns on one time axis, with what may not be used marked.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::{ChannelId, DataError, Flags, Source};

/// What the valve of a channel was told, sample by sample.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Drive {
    /// One spool valve: -1 (full vent) to 1 (full fill).
    Spool(Vec<f32>),
    /// Separate fill and vent valves, each 0 (closed) to 1 (open).
    Separate {
        /// Fill valve's drive.
        fill: Vec<f32>,
        /// Vent valve's drive.
        vent: Vec<f32>,
    },
}

/// One valve and chamber pair. All columns have one value per row of the recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Whose columns these are.
    pub id: ChannelId,
    /// Commanded pressure, kPa gauge.
    pub command_kpa: Option<Vec<f32>>,
    /// Measured pressure, kPa gauge; `NaN` where it is missing.
    pub pressure_kpa: Option<Vec<f32>>,
    /// Drive of the valve.
    pub drive: Option<Drive>,
    /// Why a row is not to be used, row by row.
    pub flags: Vec<Flags>,
}

impl Channel {
    /// Number of rows whose measured pressure may be compared with a simulation.
    #[must_use]
    pub fn usable_samples(&self) -> usize {
        if self.pressure_kpa.is_none() {
            0
        } else {
            self.flags.iter().filter(|f| f.pressure_usable()).count()
        }
    }
}

/// The bending angles of the joint that one board moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Board number.
    pub board: u8,
    /// Angle that channels 0 and 1 share, rad.
    pub qu_rad: Option<Vec<f32>>,
    /// Angle that channels 2 and 3 share, rad.
    pub qv_rad: Option<Vec<f32>>,
}

/// The supply pressure that one board measures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoardSupply {
    /// Board number.
    pub board: u8,
    /// Gauge pressure in each row, kPa: between two readings on the straight line; `NaN` where
    /// there was none for long.
    pub kpa: Vec<f32>,
}

impl BoardSupply {
    /// The same board's, in other rows.
    pub(super) fn with(&self, kpa: Vec<f32>) -> Self {
        Self { board: self.board, kpa }
    }
}

/// Measured data after checking: time strictly increases, every column has as many values as there
/// are rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// Where it came from.
    pub source: Source,
    /// Time of each row, s.
    pub time_s: Vec<f64>,
    /// Row of the file (1 is the header) that each row came from, for messages.
    pub line: Vec<u32>,
    /// Rows at which a new stretch begins because time is missing before them: no simulation runs
    /// across.
    pub breaks: Vec<usize>,
    /// Nominal sampling period (median), s.
    pub period_s: f64,
    /// The channels, by board and channel number.
    pub channels: Vec<Channel>,
    /// Joint angles, by board.
    pub joints: Vec<Joint>,
    /// Measured supply pressure of the rig, kPa gauge.
    pub supply_kpa: Option<Vec<f32>>,
    /// Supply pressures that boards measure themselves, by board.
    #[serde(default)]
    pub board_supplies: Vec<BoardSupply>,
}

impl Recording {
    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// Time from the first row to the last, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Nominal sampling rate, Hz.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        self.period_s.recip()
    }

    /// The supply pressure that was measured for `board`, kPa gauge: its own, or that of the rig.
    #[must_use]
    pub fn supply_of(&self, board: u8) -> Option<&[f32]> {
        let own = self.board_supplies.iter().find(|supply| supply.board == board);
        own.map(|supply| supply.kpa.as_slice()).or(self.supply_kpa.as_deref())
    }

    /// The channel named `id`.
    ///
    /// # Errors
    /// [`DataError::NoSuchChannel`], naming the channels that are there.
    pub fn channel(&self, id: ChannelId) -> Result<&Channel, DataError> {
        self.channels.iter().find(|c| c.id == id).ok_or_else(|| DataError::NoSuchChannel {
            file: self.source.file.clone(),
            channel: id,
            found: self.channels.iter().map(|c| c.id.to_string()).collect::<Vec<_>>().join(", "),
        })
    }

    /// The measured pressure of `channel`, kPa gauge.
    ///
    /// # Errors
    /// [`DataError::MissingColumn`] when the recording holds none; `purpose` completes "which ...
    /// needs".
    pub fn pressure<'a>(&self, channel: &'a Channel, purpose: &'static str) -> Result<&'a [f32], DataError> {
        self.require(channel.pressure_kpa.as_deref(), channel, channel.id.pressure_column(), purpose)
    }

    /// The commanded pressure of `channel`, kPa gauge.
    ///
    /// # Errors
    /// [`DataError::MissingColumn`] when the recording holds none; `purpose` completes "which ...
    /// needs".
    pub fn command<'a>(&self, channel: &'a Channel, purpose: &'static str) -> Result<&'a [f32], DataError> {
        self.require(channel.command_kpa.as_deref(), channel, channel.id.command_column(), purpose)
    }

    fn require<'a>(
        &self,
        column: Option<&'a [f32]>,
        channel: &Channel,
        name: String,
        purpose: &'static str,
    ) -> Result<&'a [f32], DataError> {
        column.ok_or_else(|| DataError::MissingColumn {
            file: self.source.file.clone(),
            channel: channel.id,
            column: name,
            purpose,
        })
    }

    /// The joint angle that changes the volume of channel `id`, rad, with the sign it has in l =
    /// h + sign r q: channels 0 and 1 lie opposite each other on `qu`, channels 2 and 3 on `qv`.
    #[must_use]
    pub fn joint_angle(&self, id: ChannelId) -> Option<(&[f32], f64)> {
        let joint = self.joints.iter().find(|j| j.board == id.board)?;
        let (angle, sign) = match id.channel {
            0 => (joint.qu_rad.as_deref(), 1.0),
            1 => (joint.qu_rad.as_deref(), -1.0),
            2 => (joint.qv_rad.as_deref(), 1.0),
            3 => (joint.qv_rad.as_deref(), -1.0),
            _ => return None,
        };
        Some((angle?, sign))
    }

    /// Stretches of rows without missing time.
    #[must_use]
    pub fn segments(&self) -> Vec<Range<usize>> {
        let starts = std::iter::once(0).chain(self.breaks.iter().copied());
        let ends = self.breaks.iter().copied().chain(std::iter::once(self.rows()));
        starts.zip(ends).map(|(start, end)| start..end).filter(|r| !r.is_empty()).collect()
    }

    /// Stretches of rows over which `channel` can be simulated: no missing time, all inputs known
    /// or held.
    #[must_use]
    pub fn channel_segments(&self, channel: &Channel) -> Vec<Range<usize>> {
        let mut stretches = Vec::new();
        for range in self.segments() {
            let mut start = None;
            for row in range.clone() {
                let missing = channel.flags[row].contains(Flags::INPUT_MISSING);
                match (missing, start) {
                    (false, None) => start = Some(row),
                    (true, Some(from)) => {
                        stretches.push(from..row);
                        start = None;
                    }
                    _ => {}
                }
            }
            stretches.extend(start.map(|from| from..range.end));
        }
        stretches
    }

    /// Whether it holds set points and nothing else: neither pressures nor drives were recorded.
    #[must_use]
    pub fn is_commands_alone(&self) -> bool {
        self.channels.iter().all(|channel| channel.pressure_kpa.is_none() && channel.drive.is_none())
    }

    /// Rows at which none of a board's channels has a measured pressure: the exchange was lost, or
    /// the board was not asked.
    #[must_use]
    pub fn lost_exchanges(&self, board: u8) -> Vec<usize> {
        let measured = |channel: &&Channel| channel.id.board == board && channel.pressure_kpa.is_some();
        let channels: Vec<&Channel> = self.channels.iter().filter(measured).collect();
        let missing = |channel: &&Channel, row: usize| channel.flags[row].contains(Flags::PRESSURE_MISSING);
        let lost =
            |row: &usize| !channels.is_empty() && channels.iter().all(|channel| missing(channel, *row));
        (0..self.rows()).filter(lost).collect()
    }

    /// The first row at or after `time_s` seconds from the start of the recording.
    #[must_use]
    pub fn row_at(&self, time_s: f64) -> usize {
        let origin = self.time_s.first().copied().unwrap_or(0.0);
        // Half a microsecond, so that 15.000 in decimal is not missed by a rounding of the
        // subtraction.
        self.time_s.partition_point(|t| t - origin < time_s - 5e-7)
    }
}
