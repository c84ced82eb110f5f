//! What the page needs of a run: data to look at, and actions.

use pneudrive_protocol::CHANNELS;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// A run that is looked at and acted on. Methods are called on the page's own threads.
pub trait Run: Send + Sync + 'static {
    /// The newest cycle; `None` before the first.
    fn moment(&self) -> Option<Moment>;

    /// Figures of the run so far, as they are sent; null before there are any. The page shows
    /// `baud`, `cycle_us.p99`, `lost`, `exchanges`, `rejected`, `cpu_share` and `boards` of them.
    fn statistics(&self) -> serde_json::Value;

    /// How a watch of the rig stands; `None` where nothing is watched.
    fn watch(&self) -> Option<WatchMoment>;

    /// Lines about what has happened since the last call.
    fn lines(&self) -> Vec<String>;

    /// Commands 0 kPa to all channels until they are released. Returns whether that is new: `false`
    /// where they were vented already. Must return at once, whatever the bus does.
    fn vent(&self) -> bool;

    /// Ends venting, with set points of 0 kPa, or with those of before where
    /// [`Moment::release_returns`] says so. Returns whether those of before return.
    fn release(&self) -> bool;

    /// Commands one channel. Returns the pressure that was commanded: a whole sensor count, kPa
    /// gauge.
    ///
    /// # Errors
    /// There is no such channel, the pressure is unusable, or something else commands.
    fn set(&self, set_point: SetPoint) -> Result<f64, Refusal>;

    /// Whose commands the boards get.
    fn commanding(&self) -> Commanding;

    /// Tells the people at the host's terminal, or its log.
    fn notice(&self, line: String);
}

/// Whose commands the boards get.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Commanding {
    /// Those of a trajectory or a program.
    Trajectory,
    /// 0 kPa, until released.
    Vented,
    /// Set points given by hand.
    #[serde(rename = "set points")]
    SetPoints,
    /// Nobody: it is a recording that is looked at, and there is nothing to vent.
    Recording,
}

/// How a board has answered lately.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BoardState {
    /// It has not answered since the start.
    Unseen,
    /// Its last exchange succeeded.
    Present,
    /// Its last exchange failed.
    Doubtful,
    /// It failed too often in a row.
    Missing,
}

/// A cycle of the bus.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Cycles before this one.
    pub cycle: u64,
    /// Start of the cycle after that of the run's first cycle, ns.
    pub since_start_ns: u64,
    /// How long ago the cycle started.
    pub age: Duration,
    /// Whose commands the boards get.
    pub commanding: Commanding,
    /// Whether a release returns to the set points of before: nobody vented the boards, the port
    /// was gone.
    pub release_returns: bool,
    /// In the order of the options' board numbers.
    pub boards: Vec<BoardMoment>,
}

/// A board in a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardMoment {
    /// How it has answered lately.
    pub state: BoardState,
    /// Commands last sent, kPa gauge, 0 or more.
    pub command_kpa: [f64; CHANNELS],
    /// Set points towards which the commands go, kPa gauge. The same as `command_kpa` where nothing
    /// limits the rate of change.
    pub target_kpa: [f64; CHANNELS],
    /// Supply pressure that it has measured lately, kPa gauge; `None` where it has no such sensor,
    /// or is not asked.
    pub supply_kpa: Option<f64>,
    /// Temperature of its chip, degrees Celsius; `None` where it does not tell, or is not asked.
    pub chip_c: Option<f64>,
    /// Its last answer; `None` before the first.
    pub reading: Option<ReadingMoment>,
}

/// What a board has answered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadingMoment {
    /// How old it is.
    pub age: Duration,
    /// Pressures, kPa gauge.
    pub kpa: [f64; CHANNELS],
    /// Channels whose sensor the board calls faulty.
    pub faulty: [bool; CHANNELS],
}

/// How a watch of the rig stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct WatchMoment {
    /// In a few words.
    pub words: String,
    /// Whether somebody should look after the rig.
    pub warning: bool,
}

/// A pressure to be commanded.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct SetPoint {
    /// The board's number.
    pub board: u8,
    /// Its channel.
    pub channel: usize,
    /// Pressure, kPa gauge.
    pub kpa: f64,
}

/// Why something was not done; each with a sentence for people.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// The request makes no sense here (status 422).
    #[error("{0}")]
    Unusable(String),
    /// It does not go with what is the case now (status 409).
    #[error("{0}")]
    Conflict(String),
    /// It was tried and failed (status 500).
    #[error("{0}")]
    Failed(String),
}
