//! Why a channel cannot be simulated.

use crate::rig::RigError;
use crate::{ChannelId, DataError, Recording};
use pneudrive_plant::rollout::SeriesError;

/// A stretch shorter than this is left out: it says nothing about a rollout, and costs a start
/// pressure.
pub(crate) const SHORTEST_STRETCH_ROWS: usize = 10;

/// Why a channel of a recording cannot be simulated on this rig.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// A column or channel is missing.
    #[error(transparent)]
    Data(#[from] DataError),
    /// A table of the rig file is missing.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The drive is not recorded and there is no controller to compute it.
    #[error(
        "{file}: channel {channel} has no drive column ({spool}, or {fill} and {vent}), and the board's loop is not simulated in its place: that needs [controller] and [sensor] in the rig file (--rig, in Python rig=), and no --controller off; or use the linear model"
    )]
    NoDrive {
        /// The recording.
        file: String,
        /// The channel.
        channel: ChannelId,
        /// Name of the spool drive's column.
        spool: String,
        /// Name of the fill drive's column.
        fill: String,
        /// Name of the vent drive's column.
        vent: String,
    },
    /// The joint's angle leaves no volume.
    #[error(
        "{file}, row {row}: a joint angle of {angle_rad:.3} rad leaves channel {channel} a volume of {volume_ml:.1} ml; check the angle's unit and sign, and length_m and offset_m of [chamber]"
    )]
    NoVolume {
        /// The recording.
        file: String,
        /// Row of the file.
        row: u32,
        /// The channel.
        channel: ChannelId,
        /// The angle, rad.
        angle_rad: f64,
        /// The volume, ml.
        volume_ml: f64,
    },
    /// All rows are masked or in stretches too short to use.
    #[error(
        "{file}: channel {channel} has no usable stretch of {SHORTEST_STRETCH_ROWS} rows between rows {first_row} and {last_row}; see the data quality remarks"
    )]
    NothingUsable {
        /// The recording.
        file: String,
        /// The channel.
        channel: ChannelId,
        /// First row looked at.
        first_row: u32,
        /// Last row looked at.
        last_row: u32,
    },
    /// The table of inputs was refused: a defect of this program, or of checks switched off.
    #[error("{file}: channel {channel}: {source}")]
    Series {
        /// The recording.
        file: String,
        /// The channel.
        channel: ChannelId,
        /// The reason.
        source: SeriesError,
    },
}

impl InputError {
    /// [`InputError::NoDrive`] for a channel of a recording.
    #[must_use]
    pub fn no_drive(recording: &Recording, id: ChannelId) -> Self {
        let (fill, vent) = id.fill_vent_columns();
        let file = recording.source.file.clone();
        Self::NoDrive { file, channel: id, spool: id.drive_column(), fill, vent }
    }
}
