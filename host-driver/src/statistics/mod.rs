//! What a run was like.

mod cycles;
mod durations;
mod sensors;

pub(crate) use cycles::CycleStatistics;
pub(crate) use durations::Durations;
pub use sensors::SensorFigures;

use crate::bus::{BoardFormat, Counters};
use crate::poller::{BoardRow, BoardState};
use serde::Serialize;

/// Everything about a run so far. Field names are those of the JSON that `--json` prints.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Statistics {
    /// Boards that are polled.
    pub devices: usize,
    /// Time from the start of the first cycle to the end of the last, s.
    pub seconds: f64,
    /// Line rate in effect, bit/s; `None` where it is not known.
    pub baud: Option<u32>,
    /// Cycles: every board asked once, or left out because it is missing.
    pub cycles: u64,
    /// Cycles per second.
    pub loop_hz: LoopRate,
    /// Time from the start of a cycle to the start of the next, us.
    pub cycle_us: CycleTimes,
    /// Requests sent.
    pub exchanges: u64,
    /// Requests that got no valid answer in time, for whatever reason.
    pub lost: u64,
    /// Answers that came and were not accepted: damaged, another board's, or late.
    pub rejected: u64,
    /// Cycles that could not start at their time; 0 when polling as fast as possible.
    pub missed_ticks: u64,
    /// Bytes that came while no board had been asked.
    pub unsolicited_bytes: u64,
    /// CPU time of the host's bus thread, as a share of one core.
    pub cpu_share: f64,
    /// Each board.
    pub boards: Vec<BoardStatistics>,
}

/// Loop rate, Hz.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct LoopRate {
    /// Cycles / seconds, up to the start of the last cycle if the next one was not due when the run
    /// ended. Not the mean of the cycles' rates, which few short cycles raise.
    pub mean: f64,
    /// Standard deviation of the single cycles' rates, 1/period.
    pub std: f64,
    /// Rate of the longest cycle.
    pub min: f64,
}

/// Quantiles of the cycle time, us; the resolution is 0.1 %.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct CycleTimes {
    /// Median.
    pub p50: f64,
    /// 99 % of the cycles are at most this long.
    pub p99: f64,
    /// 99.9 % of the cycles are at most this long.
    pub p999: f64,
    /// The longest cycle.
    pub max: f64,
}

/// Durations of one order of magnitude.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HistogramBin {
    #[serde(skip)]
    pub(crate) index: i32,
    /// The shortest in it, us.
    pub from_us: f64,
    /// Those from here on are in the next, us.
    pub to_us: f64,
    /// How many.
    pub count: u64,
}

impl HistogramBin {
    fn new(index: i32, a_decade: i32) -> Self {
        let edge = |index: i32| 10_f64.powf(f64::from(index) / f64::from(a_decade));
        Self { index, from_us: edge(index), to_us: edge(index + 1), count: 0 }
    }
}

/// One board's share of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BoardStatistics {
    /// The board's number.
    pub board: u8,
    /// Valid answers in time.
    pub answered: u64,
    /// Requests without one.
    pub lost: u64,
    /// Answers that came and were not accepted.
    pub rejected: u64,
    /// How it answered last.
    pub state: BoardState,
    /// Age of its last answer when these figures were made, us: since it was asked. `None` if it
    /// never answered.
    pub age_us: Option<u64>,
    /// Cycles of which it has no reading: it was not asked, or gave no valid answer in time.
    pub rows_without_reading: u64,
    /// Which packets it is spoken to in.
    pub frames: BoardFormat,
    /// Whether it confirmed 0 kPa at the end: by a checked answer, or (a board of the original
    /// kind) by its readings. `None` as long as the run lasts.
    pub zero_kpa_confirmed: Option<bool>,
    /// Its sensors' last readings; `None` where it is not asked for them.
    pub sensors: Option<SensorFigures>,
}

impl BoardStatistics {
    pub(crate) fn new(
        row: &BoardRow,
        counters: Counters,
        rows_without_reading: u64,
        frames: BoardFormat,
        now_ns: u64,
    ) -> Self {
        Self {
            board: row.board,
            answered: counters.answered,
            lost: counters.lost(),
            rejected: counters.rejected(),
            state: row.state,
            age_us: row.reading.map(|reading| reading.age(now_ns).as_micros() as u64),
            rows_without_reading,
            frames,
            zero_kpa_confirmed: None,
            sensors: None,
        }
    }
}
