//! What clients are sent. The names are short: thirty of these a second go to every client.

use super::WebOptions;
use crate::line::Clock;
use crate::poller::{BoardRow, BoardState, Commanding, Snapshot};
use pneudrive_protocol::{CHANNELS, Counts, SensorScale};
use serde::Serialize;
use std::path::Path;

const SCALE: SensorScale = SensorScale::ORIGINAL;

/// What does not change: the first thing a client gets.
#[derive(Debug, Serialize)]
pub(super) struct Hello<'a> {
    version: &'static str,
    port: &'a str,
    boards: &'a [u8],
    channels: usize,
    pictures_hz: u32,
    full_scale_kpa: f64,
    /// Whether set points can be given, and up to what, kPa.
    control_limit_kpa: Option<f64>,
    record_folder: Option<&'a Path>,
    whole_run: Option<&'a Path>,
}

impl<'a> Hello<'a> {
    pub(super) fn new(options: &'a WebOptions, pictures_hz: u32) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            port: &options.port,
            boards: &options.boards,
            channels: CHANNELS,
            pictures_hz,
            full_scale_kpa: round(SCALE.full_scale_kpa()),
            control_limit_kpa: options.control.as_ref().map(|control| control.limit_kpa),
            record_folder: options.recording.as_ref().map(|recording| &*recording.folder),
            whole_run: options.whole_run.as_deref(),
        }
    }
}

/// A moment of the run.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Picture {
    /// Time since the run's first cycle, s.
    pub(super) t: f64,
    /// Age of the newest cycle, s.
    late: f64,
    /// Cycles per second, over the last second.
    hz: Option<f64>,
    commanding: &'static str,
    pub(super) boards: Vec<BoardPicture>,
}

#[derive(Debug, Clone, Serialize)]
pub(super) struct BoardPicture {
    state: BoardState,
    /// Age of the reading, s; `None` before the first.
    age: Option<f64>,
    /// Commands last sent, kPa.
    pub(super) c: [f64; CHANNELS],
    /// Pressures, kPa: `None` where the reading is old or the sensor is faulty.
    pub(super) p: [Option<f64>; CHANNELS],
    /// Channels whose sensor the board calls faulty.
    fault: [bool; CHANNELS],
}

impl Picture {
    pub(super) fn new(snapshot: &Snapshot, clock: Clock, hz: Option<f64>, commanding: Commanding) -> Self {
        let now_ns = clock.now_ns();
        let late_ns = now_ns.saturating_sub(snapshot.at_ns);
        let old_ns = old_after_ns(hz);
        Self {
            t: (seconds(snapshot.since_start_ns + late_ns) * 1e3).round() * 1e-3,
            late: (seconds(late_ns) * 1e3).round() * 1e-3,
            hz: hz.map(round),
            commanding: match commanding {
                Commanding::Following => "trajectory",
                Commanding::Vented => "vented",
                Commanding::Manual => "set points",
            },
            boards: snapshot.boards.iter().map(|board| BoardPicture::new(board, now_ns, old_ns)).collect(),
        }
    }
}

impl BoardPicture {
    fn new(board: &BoardRow, now_ns: u64, old_ns: u64) -> Self {
        let age_ns = board.reading.map(|reading| reading.age_ns(now_ns));
        let fresh = board.reading.filter(|_| age_ns.is_some_and(|age_ns| age_ns <= old_ns));
        // Boards answer the first or the last code for a sensor that cannot be right.
        let faulty = |channel: usize| {
            fresh.is_some_and(|reading| [Counts::MIN, Counts::MAX].contains(&reading.counts[channel]))
        };
        let pressure =
            |channel: usize| fresh.filter(|_| !faulty(channel)).map(|reading| round(reading.kpa[channel]));
        let channels: [usize; CHANNELS] = std::array::from_fn(|channel| channel);
        Self {
            state: board.state,
            age: age_ns.map(|ns| (seconds(ns) * 1e2).round() * 1e-2),
            // The count of 0 kPa lies a little below it; a command below 0 does not exist.
            c: board.command.map(|counts| round(SCALE.kpa(counts).max(0.0))),
            p: channels.map(pressure),
            fault: channels.map(faulty),
        }
    }
}

/// A reading older than this is none, ns: 0.1 s, or three cycles where those are longer.
fn old_after_ns(hz: Option<f64>) -> u64 {
    const SHORTEST_NS: f64 = 1e8;
    hz.filter(|hz| *hz > 0.0).map_or(SHORTEST_NS, |hz| (3e9 / hz).max(SHORTEST_NS)) as u64
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}

/// To a tenth.
pub(super) fn round(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::poller::{Outcome, Reading, VENTED};

    fn picture(age_ns: u64, counts: [u16; CHANNELS], hz: Option<f64>) -> String {
        let counts = counts.map(|value| Counts::new(value).unwrap());
        let kpa = counts.map(|counts| SCALE.kpa(counts));
        let board = BoardRow {
            board: 0,
            command: [Counts::ATMOSPHERE, Counts::saturating(221), VENTED[0], Counts::MAX],
            outcome: Outcome::Fresh,
            reading: Some(Reading { counts, kpa, asked_ns: 1_000_000_000 }),
            state: BoardState::Present,
        };
        let now_ns = 1_000_000_000 + age_ns;
        serde_json::to_string(&BoardPicture::new(&board, now_ns, old_after_ns(hz))).unwrap()
    }

    #[test]
    fn commands_and_pressures_in_kpa() {
        assert_eq!(
            picture(4_000_000, [102, 221, 340, 922], Some(1000.0)),
            r#"{"state":"present","age":0.0,"c":[0.0,99.8,0.0,774.8],"p":[-0.3,99.8,200.0,689.8],"fault":[false,false,false,false]}"#
        );
    }

    #[test]
    fn old_readings_and_faulty_sensors_are_no_pressures() {
        let old = picture(200_000_000, [102; 4], Some(1000.0));
        assert!(old.contains(r#""age":0.2,"#) && old.contains(r#""p":[null,null,null,null]"#), "{old}");
        let slow = picture(200_000_000, [102; 4], Some(10.0));
        assert!(slow.contains(r#""p":[-0.3,"#), "{slow}");
        let faulty = picture(0, [0, 102, 1023, 102], Some(1000.0));
        assert!(faulty.contains(r#""p":[null,-0.3,null,-0.3],"fault":[true,false,true,false]"#), "{faulty}");
    }
}
