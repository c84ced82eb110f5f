//! What clients are sent. The names are short: thirty of these a second go to every client.

use crate::labels::Labels;
use crate::run::{BoardMoment, BoardState, Commanding, Moment};
use crate::sampler::PICTURES_HZ;
use crate::server::Shared;
use pneudrive_protocol::CHANNELS;
use serde::Serialize;
use std::path::Path;
use std::time::Duration;

/// What does not change: the first thing a client gets.
#[derive(Debug, Serialize)]
pub(crate) struct Hello<'a> {
    version: &'static str,
    port: &'a str,
    boards: &'a [u8],
    channels: usize,
    pictures_hz: u32,
    full_scale_kpa: f64,
    labels: &'a Labels,
    /// Whether set points can be given, and up to what, kPa.
    control_limit_kpa: Option<f64>,
    /// How long the operator's page may be silent in deadman mode.
    deadman_s: f64,
    /// Whether nobody can command without it.
    deadman_required: bool,
    record_folder: Option<&'a Path>,
    whole_run: Option<&'a Path>,
}

impl<'a> Hello<'a> {
    pub(crate) fn new(server: &'a Shared) -> Self {
        let options = &server.options;
        let (deadman, _) = server.deadman();
        Self {
            version: env!("CARGO_PKG_VERSION"),
            port: &options.port,
            boards: &options.boards,
            channels: CHANNELS,
            pictures_hz: PICTURES_HZ,
            full_scale_kpa: round(options.full_scale_kpa),
            labels: &options.labels,
            control_limit_kpa: options.control.as_ref().map(|control| control.limit_kpa),
            deadman_s: deadman.limit().as_secs_f64(),
            deadman_required: deadman.is_required(),
            record_folder: options.recordings.as_ref().map(|recordings| recordings.folder()),
            whole_run: options.whole_run.as_deref(),
        }
    }
}

/// A moment of the run.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Picture {
    /// Time since the run's first cycle, s.
    pub(crate) t: f64,
    /// Age of the newest cycle, s.
    late: f64,
    /// Cycles per second, over the last second.
    hz: Option<f64>,
    commanding: Commanding,
    /// Whether a release returns to the set points of before.
    returns: bool,
    /// Whether an operator's page is watched.
    deadman: bool,
    pub(crate) boards: Vec<BoardPicture>,
}

#[derive(Debug, Clone, Serialize)]
pub(crate) struct BoardPicture {
    state: BoardState,
    /// Age of the reading, s; `None` before the first.
    age: Option<f64>,
    /// Commands last sent, kPa.
    pub(crate) c: [f64; CHANNELS],
    /// Set points towards which the commands go, kPa.
    s: [f64; CHANNELS],
    /// Pressures, kPa: `None` where the reading is old or the sensor is faulty.
    pub(crate) p: [Option<f64>; CHANNELS],
    /// Channels whose sensor the board calls faulty.
    fault: [bool; CHANNELS],
    /// Supply pressure, kPa, where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    supply: Option<f64>,
    /// Temperature of the chip, degrees Celsius, where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    chip_c: Option<f64>,
}

impl Picture {
    pub(crate) fn new(moment: &Moment, hz: Option<f64>, deadman: bool) -> Self {
        let old = old_after(hz);
        Self {
            t: ((Duration::from_nanos(moment.since_start_ns) + moment.age).as_secs_f64() * 1e3).round() / 1e3,
            late: (moment.age.as_secs_f64() * 1e3).round() / 1e3,
            hz: hz.map(round),
            commanding: moment.commanding,
            returns: moment.release_returns,
            deadman,
            boards: moment.boards.iter().map(|board| BoardPicture::new(board, old)).collect(),
        }
    }
}

impl BoardPicture {
    fn new(board: &BoardMoment, old: Duration) -> Self {
        let fresh = board.reading.filter(|reading| reading.age <= old);
        let faulty = fresh.map_or([false; CHANNELS], |reading| reading.faulty);
        let pressure =
            |channel: usize| fresh.filter(|_| !faulty[channel]).map(|reading| round(reading.kpa[channel]));
        Self {
            state: board.state,
            age: board.reading.map(|reading| (reading.age.as_secs_f64() * 1e2).round() / 1e2),
            c: board.command_kpa.map(round),
            s: board.target_kpa.map(round),
            p: std::array::from_fn(pressure),
            fault: faulty,
            supply: board.supply_kpa.map(round),
            chip_c: board.chip_c.map(round),
        }
    }
}

/// A reading older than this is none: 0.1 s, or three cycles where those are longer.
fn old_after(hz: Option<f64>) -> Duration {
    const SHORTEST: Duration = Duration::from_millis(100);
    let cycles = hz.and_then(|hz| Duration::try_from_secs_f64(3.0 / hz).ok());
    cycles.map_or(SHORTEST, |cycles| cycles.max(SHORTEST))
}

/// To a tenth.
pub(crate) fn round(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::ReadingMoment;

    fn picture(age: Duration, faulty: [bool; CHANNELS], hz: Option<f64>) -> String {
        let board = BoardMoment {
            state: BoardState::Present,
            command_kpa: [0.0, 99.816, 0.0, 774.8],
            target_kpa: [0.0, 150.0, 0.0, 774.8],
            supply_kpa: None,
            chip_c: None,
            reading: Some(ReadingMoment { age, kpa: [-0.34, 99.82, 199.97, 689.8], faulty }),
        };
        serde_json::to_string(&BoardPicture::new(&board, old_after(hz))).unwrap()
    }

    #[test]
    fn commands_set_points_and_pressures_in_kpa() {
        assert_eq!(
            picture(Duration::from_millis(4), [false; 4], Some(1000.0)),
            r#"{"state":"present","age":0.0,"c":[0.0,99.8,0.0,774.8],"s":[0.0,150.0,0.0,774.8],"p":[-0.3,99.8,200.0,689.8],"fault":[false,false,false,false]}"#
        );
    }

    #[test]
    fn what_else_a_board_measures_is_with_it() {
        let board = BoardMoment {
            state: BoardState::Present,
            command_kpa: [0.0; CHANNELS],
            target_kpa: [0.0; CHANNELS],
            supply_kpa: Some(549.66),
            chip_c: Some(41.28),
            reading: None,
        };
        let text = serde_json::to_string(&BoardPicture::new(&board, Duration::ZERO)).unwrap();
        assert!(text.ends_with(r#","supply":549.7,"chip_c":41.3}"#), "{text}");
    }

    #[test]
    fn old_readings_and_faulty_sensors_are_no_pressures() {
        let old = picture(Duration::from_millis(200), [false; 4], Some(1000.0));
        assert!(old.contains(r#""age":0.2,"#) && old.contains(r#""p":[null,null,null,null]"#), "{old}");
        let slow = picture(Duration::from_millis(200), [false; 4], Some(10.0));
        assert!(slow.contains(r#""p":[-0.3,"#), "{slow}");
        let faulty = picture(Duration::ZERO, [true, false, true, false], Some(1000.0));
        assert!(faulty.contains(r#""p":[null,99.8,null,689.8],"fault":[true,false,true,false]"#), "{faulty}");
    }
}
