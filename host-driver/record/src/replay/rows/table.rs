use super::{Kind, RecordedBoard, RecordedRow, column};
use csv::StringRecord;
use pneudrive_protocol::CHANNELS;
use std::collections::BTreeMap;
use std::io::{self, Read};

/// A table being read.
pub(super) struct Table {
    reader: csv::Reader<Box<dyn Read>>,
    record: StringRecord,
    time: usize,
    boards: Vec<Columns>,
    ended: bool,
}

/// Where a board's columns are.
struct Columns {
    board: u8,
    command: [Option<usize>; CHANNELS],
    pressure: [Option<usize>; CHANNELS],
    supply: Option<usize>,
}

impl Table {
    pub(super) fn open(text: Box<dyn Read>) -> io::Result<Self> {
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text);
        let header = reader.headers().map_err(io::Error::other)?;
        let mut time = None;
        let mut boards: BTreeMap<u8, Columns> = BTreeMap::new();
        for (place, name) in header.iter().enumerate() {
            let name = name.trim_start_matches('\u{feff}');
            if name == "t_s" {
                time = Some(place);
            } else if let Some((kind, board)) = column(name) {
                let columns = boards.entry(board).or_insert(Columns {
                    board,
                    command: [None; CHANNELS],
                    pressure: [None; CHANNELS],
                    supply: None,
                });
                match kind {
                    Kind::Command(channel) => columns.command[channel] = Some(place),
                    Kind::Pressure(channel) => columns.pressure[channel] = Some(place),
                    Kind::Supply => columns.supply = Some(place),
                }
            }
        }
        let boards: Vec<_> = boards.into_values().collect();
        match time {
            Some(time) if !boards.is_empty() => {
                Ok(Self { reader, record: StringRecord::new(), time, boards, ended: false })
            }
            _ => Err(io::Error::new(
                io::ErrorKind::InvalidData,
                "no recording: expected a column t_s and columns such as b0_cmd0_kpa and b0_p0_kpa",
            )),
        }
    }

    /// What the record says; `None` if its time is no number.
    fn row(&self) -> Option<RecordedRow> {
        let value =
            |place: Option<usize>| self.record.get(place?)?.parse::<f64>().ok().filter(|v| v.is_finite());
        let board = |columns: &Columns| {
            let pressures = columns.pressure.map(value);
            RecordedBoard {
                board: columns.board,
                command_kpa: columns.command.map(|place| value(place).unwrap_or(0.0)),
                // A channel without a column is at 0 kPa where the others have something.
                kpa: pressures.iter().any(Option::is_some).then(|| pressures.map(|kpa| kpa.unwrap_or(0.0))),
                supply_kpa: value(columns.supply),
            }
        };
        Some(RecordedRow { t_s: value(Some(self.time))?, boards: self.boards.iter().map(board).collect() })
    }
}

impl Iterator for Table {
    type Item = io::Result<RecordedRow>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.ended {
            match self.reader.read_record(&mut self.record) {
                Ok(true) => {
                    if let Some(row) = self.row() {
                        return Some(Ok(row));
                    }
                }
                Ok(false) => self.ended = true,
                // A program that was killed leaves half a line, or half a compressed block.
                Err(error) => {
                    self.ended = true;
                    return Some(Err(io::Error::other(error)));
                }
            }
        }
        None
    }
}
