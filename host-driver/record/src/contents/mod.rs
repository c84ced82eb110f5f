//! What a recording says of itself and of what happened, without its rows.

mod bag;
mod table;

use crate::stored::Stored;
use serde::Serialize;
use std::io;
use std::path::Path;

/// What is in a recording beside its rows.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Contents {
    /// What it says of itself: keys, and values as JSON.
    pub description: serde_json::Map<String, serde_json::Value>,
    /// Rows: one a cycle.
    pub rows: u64,
    /// Time of the first row, s; `None` without rows.
    pub first_s: Option<f64>,
    /// Time of the last row, s; `None` without rows.
    pub last_s: Option<f64>,
    /// What happened, in the order in which it is in the file.
    pub events: Vec<ContentsEvent>,
    /// What the reader met where the file stops in the middle: a program that was killed.
    pub unfinished: Option<String>,
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ContentsEvent {
    /// When, s. In a bag since the first message.
    pub t_s: f64,
    /// What sort of thing, as in [`NoticeKind::name`](pneudrive_host::notices::NoticeKind::name).
    pub kind: String,
    /// The board's number, where it is about one and the format has a place for it.
    pub board: Option<u8>,
    /// A sentence.
    pub text: String,
}

impl Contents {
    /// Reads a table, also a compressed one, or a bag: what it is its first bytes say. A file that
    /// stops in the middle is read as far as it goes.
    ///
    /// # Errors
    /// The file cannot be opened, or is no recording.
    pub fn read(path: &Path) -> io::Result<Self> {
        let contents = match Stored::open(path)? {
            Stored::Text(text) => table::read(text)?,
            Stored::Bag(content) => bag::read(content),
        };
        if contents.rows == 0 && contents.description.is_empty() {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                "no recording: neither a table with a column t_s nor a bag with pressure_state topics",
            ));
        }
        Ok(contents)
    }

    /// How the run ended: the first word of the text is the reason. `None` if it was killed, or is
    /// still being recorded.
    pub fn end(&self) -> Option<&ContentsEvent> {
        self.events.iter().rfind(|event| event.kind == pneudrive_host::notices::NoticeKind::End.name())
    }

    fn row_at(&mut self, t_s: f64) {
        self.rows += 1;
        self.first_s.get_or_insert(t_s);
        self.last_s = Some(t_s);
    }
}
