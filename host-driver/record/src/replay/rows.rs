//! Rows of a recording, one after the other.

use crate::stored::Stored;
use pneudrive_host::replay::{RecordedBoard, RecordedRow};
use pneudrive_protocol::CHANNELS;
use std::io;
use std::path::Path;

mod bag;
mod table;

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
            Stored::Bag(content) => Box::new(bag::Bag::open(content)),
        }))
    }
}

impl Iterator for Rows {
    type Item = io::Result<RecordedRow>;

    fn next(&mut self) -> Option<Self::Item> {
        self.0.next()
    }
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
