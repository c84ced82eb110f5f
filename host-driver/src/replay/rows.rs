//! Rows of a recording, one after the other.

use crate::Calibration;
use crate::stored::Stored;
use pneudrive_protocol::{CHANNELS, Counts};
use std::io;
use std::path::Path;

#[cfg(feature = "mcap")]
mod bag;
mod table;

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

/// The rows of a recording. It is read while it is gone through, so that its length does not
/// matter.
pub struct Rows(Box<dyn Iterator<Item = io::Result<RecordedRow>>>);

impl Rows {
    /// Opens a table in the measured-data format, also a compressed one, or a bag: what it is its
    /// first bytes say.
    ///
    /// # Errors
    /// The file cannot be opened, or has no columns of a board.
    pub fn open(path: &Path) -> io::Result<Self> {
        Ok(Self(match Stored::open(path)? {
            Stored::Text(text) => Box::new(table::Table::open(text)?),
            #[cfg(feature = "mcap")]
            Stored::Bag(content) => Box::new(bag::Bag::open(content)),
            #[cfg(not(feature = "mcap"))]
            Stored::Bag(_) => return Err(io::Error::other("a bag, which needs the feature `mcap`")),
        }))
    }
}

impl Iterator for Rows {
    type Item = io::Result<RecordedRow>;

    fn next(&mut self) -> Option<Self::Item> {
        self.0.next()
    }
}

impl RecordedBoard {
    /// A board that is not in the row.
    pub(super) fn silent(board: u8) -> Self {
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

/// What a column such as `b0_p3_kpa` is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Command(usize),
    Pressure(usize),
    Supply,
}

/// Kind, with its channel, and board of a column's name; `None` for other columns.
fn column(name: &str) -> Option<(Kind, u8)> {
    let name = name.strip_prefix('b')?.strip_suffix("_kpa")?;
    let (board, rest) = name.split_once('_')?;
    let plain = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let channel = |text: &str| text.parse().ok().filter(|&one: &usize| plain(text) && one < CHANNELS);
    let kind = if rest == "supply" {
        Kind::Supply
    } else if let Some(command) = rest.strip_prefix("cmd") {
        Kind::Command(channel(command)?)
    } else {
        Kind::Pressure(channel(rest.strip_prefix('p')?)?)
    };
    Some((kind, board.parse().ok().filter(|_| plain(board))?))
}
