use super::{Kind, RecordedBoard, RecordedRow, column};
use crate::messages::JointState;
use crate::trajectory::joint_state;
use mcap::io::MessageReader;
use mcap::sans_io::LinearReaderOptions;
use std::io::{self, Read};

/// Longest record, bytes: what a damaged length can make the reader allocate.
const LONGEST_RECORD: usize = 1 << 30;

/// A bag being read. Boards have a message each; those of one time are a row.
pub(super) struct Bag {
    messages: MessageReader<Box<dyn Read>>,
    first_ns: Option<u64>,
    /// The row that is not complete yet, and its time.
    open: Option<(u64, RecordedRow)>,
    ended: bool,
}

impl Bag {
    pub(super) fn open(content: Box<dyn Read>) -> Self {
        let options = LinearReaderOptions::default().with_record_length_limit(LONGEST_RECORD);
        Self {
            messages: MessageReader::new_with_options(content, options),
            first_ns: None,
            open: None,
            ended: false,
        }
    }

    /// Takes a board's state; returns the row before, if that is complete now.
    fn take(&mut self, at_ns: u64, board: RecordedBoard) -> Option<RecordedRow> {
        if let Some((time_ns, row)) = &mut self.open
            && *time_ns == at_ns
        {
            row.boards.push(board);
            return None;
        }
        let first_ns = self.first_ns.unwrap_or(at_ns);
        let t_s = at_ns.saturating_sub(first_ns) as f64 * 1e-9;
        self.open.replace((at_ns, RecordedRow { t_s, boards: vec![board] })).map(|(_, row)| row)
    }
}

/// The board of a `pressure_state`; `None` for other messages.
fn board(state: &JointState) -> Option<RecordedBoard> {
    let mut found: Option<RecordedBoard> = None;
    let mut pressures = 0;
    for (name, &kpa) in state.name.iter().zip(&state.effort) {
        let Some((kind, board)) = column(name) else { continue };
        let found = found.get_or_insert(RecordedBoard::silent(board));
        match kind {
            Kind::Command(channel) => found.command_kpa[channel] = kpa,
            Kind::Supply => found.supply_kpa = Some(kpa).filter(|kpa| kpa.is_finite()),
            Kind::Pressure(channel) => {
                pressures += 1;
                if kpa.is_finite() {
                    found.kpa.get_or_insert_default()[channel] = kpa;
                }
            }
        }
    }
    found.filter(|_| pressures > 0)
}

impl Iterator for Bag {
    type Item = io::Result<RecordedRow>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.ended {
            match self.messages.next() {
                Some(Ok(message)) => {
                    let at_ns = message.log_time;
                    self.first_ns.get_or_insert(at_ns);
                    let complete = joint_state(&message)
                        .and_then(|state| board(&state))
                        .and_then(|board| self.take(at_ns, board));
                    if let Some(row) = complete {
                        return Some(Ok(row));
                    }
                }
                Some(Err(error)) => {
                    self.ended = true;
                    return Some(Err(io::Error::other(error)));
                }
                None => self.ended = true,
            }
        }
        self.open.take().map(|(_, row)| Ok(row))
    }
}
