//! A row of a recording.

use crate::Calibration;
use pneudrive_protocol::{CHANNELS, Counts};

/// A cycle as it was recorded.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordedRow {
    /// When, s: of a table its `t_s`, of a bag since its first message.
    pub t_s: f64,
    /// Boards in ascending order.
    pub boards: Vec<RecordedBoard>,
}

/// A board in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordedBoard {
    /// The board's number.
    pub board: u8,
    /// What was commanded to channels 0 to 3, kPa gauge; 0 where the recording has none.
    pub command_kpa: [f64; CHANNELS],
    /// What it answered, kPa gauge; `None` where it gave no answer in this cycle.
    pub kpa: Option<[f64; CHANNELS]>,
    /// The supply pressure that it measured, kPa gauge; `None` where none came in this cycle.
    pub supply_kpa: Option<f64>,
}

impl RecordedBoard {
    /// A board that is not in the row.
    pub fn silent(board: u8) -> Self {
        Self { board, command_kpa: [0.0; CHANNELS], kpa: None, supply_kpa: None }
    }

    /// What was commanded, in the counts that `calibration` makes of it.
    pub(super) fn command(&self, calibration: &Calibration) -> [Counts; CHANNELS] {
        counts(self.board, self.command_kpa, calibration)
    }

    /// What was answered, in counts.
    pub(super) fn answer(&self, calibration: &Calibration) -> Option<[Counts; CHANNELS]> {
        self.kpa.map(|kpa| counts(self.board, kpa, calibration))
    }
}

/// The nearest counts: recordings round to 1 Pa, counts are 840 Pa.
fn counts(board: u8, kpa: [f64; CHANNELS], calibration: &Calibration) -> [Counts; CHANNELS] {
    let scales = calibration.of(board);
    std::array::from_fn(|channel| {
        let scale = scales[channel];
        // A saturating cast: what is out of range is the first or the last count.
        Counts::saturating((scale.zero_counts() + kpa[channel] / scale.kpa_per_count()).round() as u16)
    })
}
