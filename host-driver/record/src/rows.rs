//! Rows on their way from the bus thread to the disk, and their text.

use super::PageColumns;
use super::codes::Codes;
use super::sensor_columns::{self, SENSOR_COLUMNS};
use pneudrive_host::Calibration;
use pneudrive_host::notices::Notice;
use pneudrive_host::poller::{BoardCommand, ElectronicsReading, Motion, Row, SupplyPressure};
use pneudrive_protocol::pages::Drives;
use pneudrive_protocol::{CHANNELS, Counts};
use serde::Serialize;
use std::io::Write;

/// One board in one row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) command: BoardCommand,
    /// `None` where the board gave no answer in this cycle.
    pub(super) answer: Option<Answer>,
    /// `None` where the board was not asked for them in this cycle, or did not answer.
    pub(super) drives: Option<Drives>,
    /// Readings of this cycle.
    pub(super) supply: Option<SupplyPressure>,
    pub(super) motion: Option<Motion>,
    pub(super) electronics: Option<ElectronicsReading>,
}

/// What a board answered.
#[derive(Debug, Clone, Copy)]
pub(super) struct Answer {
    pub(super) pressures: [Counts; CHANNELS],
    /// When the board was asked, ns on the line's clock.
    pub(super) asked_ns: u64,
}

/// Some rows, in flat buffers that are used again and again.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    /// Which of the recording's buses it is from.
    pub(super) bus: usize,
    /// Start of each row's cycle since that of the first, ns.
    times_ns: Vec<u64>,
    /// The same on the line's clock, ns.
    at_ns: Vec<u64>,
    samples: Vec<Sample>,
    /// What happened in the cycles of these rows, and the number of rows before it.
    events: Vec<(usize, RecordedEvent)>,
}

/// Something that happened, and when.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RecordedEvent {
    /// On the line's clock, ns.
    pub(super) at_ns: u64,
    /// Since the first cycle of the run, ns.
    pub(super) since_start_ns: u64,
    pub(super) notice: Notice,
}

impl Batch {
    pub(crate) fn of(bus: usize) -> Self {
        Self { bus, ..Self::default() }
    }

    pub(crate) fn push(&mut self, row: &Row<'_>) {
        self.times_ns.push(row.since_start_ns);
        self.at_ns.push(row.at_ns);
        self.samples.extend(row.boards.iter().map(|board| Sample {
            command: board.command,
            answer:
                board.fresh().map(|reading| Answer { pressures: reading.counts, asked_ns: reading.asked_ns }),
            drives: board.drives.map(|reading| reading.drives),
            supply: board.sensors.new_supply(),
            motion: board.sensors.new_motion(),
            electronics: board.sensors.new_electronics(),
        }));
    }

    /// Adds something that happened before the row that is pushed next.
    pub(super) fn happened(&mut self, event: RecordedEvent) {
        self.events.push((self.rows(), event));
    }

    pub(crate) fn rows(&self) -> usize {
        self.times_ns.len()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.times_ns.is_empty() && self.events.is_empty()
    }

    /// When the run's first cycle started, ns on the line's clock, if there is a row to tell it by.
    pub(super) fn run_start_ns(&self) -> Option<u64> {
        Some(self.at_ns.first()?.saturating_sub(*self.times_ns.first()?))
    }

    /// The time of the last row, ns on the line's clock; 0 without one.
    pub(super) fn last_ns(&self) -> u64 {
        self.at_ns.last().copied().unwrap_or(0)
    }

    /// What happened, in order.
    pub(super) fn events(&self) -> impl Iterator<Item = &RecordedEvent> {
        self.events.iter().map(|(_, event)| event)
    }

    /// Start of each cycle on the line's clock, ns, and the boards in it.
    pub(super) fn iter(&self) -> impl Iterator<Item = (u64, &[Sample])> {
        let boards = (self.samples.len() / self.rows().max(1)).max(1);
        self.at_ns.iter().copied().zip(self.samples.chunks(boards))
    }

    pub(super) fn clear(&mut self) {
        self.times_ns.clear();
        self.at_ns.clear();
        self.samples.clear();
        self.events.clear();
    }
}

/// Makes text of rows. There are only 1024 commands and 1024 pressures of a channel, so their text
/// is made once.
pub(crate) struct Formatter {
    boards: Vec<u8>,
    commands: Codes<String>,
    pressures: Codes<String>,
    pages: PageColumns,
}

impl Formatter {
    pub(crate) fn new(boards: &[u8], calibration: &Calibration, pages: PageColumns) -> Self {
        Self {
            boards: boards.to_vec(),
            commands: Codes::new(boards, calibration, |scale, code| {
                format!("{:.3}", scale.command_kpa(code))
            }),
            pressures: Codes::new(boards, calibration, |scale, code| format!("{:.3}", scale.kpa(code))),
            pages,
        }
    }

    /// The header row.
    pub(crate) fn header(&self) -> Vec<u8> {
        let names = self.boards.iter().flat_map(|n| {
            let commands = (0..CHANNELS).map(move |k| format!("b{n}_cmd{k}_kpa"));
            let pressures = (0..CHANNELS).map(move |k| format!("b{n}_p{k}_kpa"));
            let drives = (0..CHANNELS).filter(|_| self.pages.drives).map(move |k| format!("b{n}_u{k}"));
            let sensors = SENSOR_COLUMNS.iter().filter(|_| self.pages.sensors);
            commands.chain(pressures).chain(drives).chain(sensors.map(move |name| format!("b{n}_{name}")))
        });
        let mut header = "t_s".to_owned();
        for name in names {
            header.push(',');
            header.push_str(&name);
        }
        header.push('\n');
        header.into_bytes()
    }

    /// Appends the rows of `batch` to `text`, and what happened between them.
    pub(crate) fn append(&self, batch: &Batch, text: &mut Vec<u8>) {
        let boards = self.boards.len().max(1);
        let mut events = batch.events.iter().peekable();
        for (row, (time_ns, samples)) in batch.times_ns.iter().zip(batch.samples.chunks(boards)).enumerate() {
            while let Some((_, event)) = events.next_if(|(before, _)| *before <= row) {
                event_line(event, text);
            }
            // Writing to a Vec does not fail.
            let _ = write!(text, "{}.{:09}", time_ns / 1_000_000_000, time_ns % 1_000_000_000);
            for (index, sample) in samples.iter().enumerate() {
                for (channel, counts) in sample.command.into_iter().enumerate() {
                    cell(text, self.commands.get(index, channel, counts));
                }
                for channel in 0..CHANNELS {
                    let counts = sample.answer.map(|answer| answer.pressures[channel]);
                    cell(text, counts.map_or("", |counts| self.pressures.get(index, channel, counts)));
                }
                if self.pages.drives {
                    drive_cells(text, sample.drives);
                }
                if self.pages.sensors {
                    sensor_columns::append(text, sample);
                }
            }
            text.push(b'\n');
        }
        events.for_each(|(_, event)| event_line(event, text));
    }
}

/// Appends four drives, -1 to 1: a drive count is 1/400, so four digits are all there are.
fn drive_cells(text: &mut Vec<u8>, drives: Option<Drives>) {
    for channel in 0..CHANNELS {
        text.push(b',');
        if let Some(drives) = drives {
            // Writing to a Vec does not fail.
            let _ = write!(text, "{:.4}", drives.share()[channel]);
        }
    }
}

/// Appends `# key: value`. A value is JSON, so it has no line end.
pub(super) fn comment_line(key: &str, value: &str, text: &mut Vec<u8>) {
    // Writing to a Vec does not fail.
    let _ = writeln!(text, "# {key}: {value}");
}

/// Appends an event as a comment.
pub(super) fn event_line(event: &RecordedEvent, text: &mut Vec<u8>) {
    let line = EventLine {
        // To a us, and with as many digits as that takes.
        t_s: (event.since_start_ns / 1_000) as f64 / 1e6,
        kind: event.notice.kind.name(),
        board: event.notice.board,
        text: &event.notice.text,
    };
    // Numbers and strings can always be expressed.
    comment_line("event", &serde_json::to_string(&line).unwrap_or_default(), text);
}

/// An event as it stands in a table.
#[derive(Serialize)]
struct EventLine<'a> {
    t_s: f64,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    board: Option<u8>,
    text: &'a str,
}

fn cell(text: &mut Vec<u8>, content: &str) {
    text.push(b',');
    text.extend_from_slice(content.as_bytes());
}

#[cfg(test)]
mod tests;
