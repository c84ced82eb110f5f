//! What a cycle brought.

use super::{BoardCommand, BoardSensors, BoardState, DriveReading};
use crate::bus::{ExchangeError, LineRateError, OpenBusError, PageError};
use crate::line::LineError;
use pneudrive_protocol::pages::SensorStatus;
use pneudrive_protocol::{Baud, CHANNELS, Counts};
use std::time::Duration;

/// What the last answer of a board said. It does not get newer by being looked at: see
/// [`Reading::age`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Pressures as the board sent them, ADC counts.
    pub counts: [Counts; CHANNELS],
    /// The same in kPa gauge, through the poller's filter if it has one.
    pub kpa: [f64; CHANNELS],
    /// When the board was asked, ns on the line's clock: the board measured at most one of its
    /// loops before.
    pub asked_ns: u64,
}

impl Reading {
    /// How old it is at `now_ns`.
    pub fn age(&self, now_ns: u64) -> Duration {
        Duration::from_nanos(now_ns.saturating_sub(self.asked_ns))
    }
}

/// What happened to a board in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It answered: the reading is of this cycle.
    Fresh,
    /// It was asked and gave no valid answer: the reading, if any, is old.
    Lost,
    /// It was not asked: it is missing, or an earlier answer may still come. The reading, if any,
    /// is old.
    NotAsked,
}

/// One board in one cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardRow {
    /// The board's number.
    pub board: u8,
    /// The command last sent to it: in this cycle, unless it was not asked.
    pub command: BoardCommand,
    /// The set point that is wanted: where `command` goes, unless a limit is below it.
    pub wanted: BoardCommand,
    /// What happened to it in this cycle.
    pub outcome: Outcome,
    /// Its last answer, of this cycle only if `outcome` is [`Outcome::Fresh`]; `None` before the
    /// first.
    pub reading: Option<Reading>,
    /// Its valves' drives, if it was asked for them in this cycle and answered
    /// ([`PollerOptions::drives`](super::PollerOptions::drives)).
    pub drives: Option<DriveReading>,
    /// The last readings of the sensors on its I2C connector
    /// ([`PollerOptions::sensors`](super::PollerOptions::sensors)).
    pub sensors: BoardSensors,
    /// How it has answered lately.
    pub state: BoardState,
}

impl BoardRow {
    /// The reading, if it is of this cycle.
    pub fn fresh(&self) -> Option<&Reading> {
        self.reading.as_ref().filter(|_| self.outcome == Outcome::Fresh)
    }
}

/// One cycle: every board once.
#[derive(Debug, Clone, Copy)]
pub struct Row<'a> {
    /// Cycles before this one.
    pub cycle: u64,
    /// Start of the cycle, ns on the line's clock.
    pub at_ns: u64,
    /// Start of the cycle after that of the first cycle, ns.
    pub since_start_ns: u64,
    /// The boards in the order in which they are polled.
    pub boards: &'a [BoardRow],
}

/// Something worth a line to the user.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A board changed its state; `error` is what its last exchange ended with, if it failed.
    Board {
        /// The board's number.
        board: u8,
        /// Its new state.
        state: BoardState,
        /// Why.
        error: Option<&'a ExchangeError>,
        /// By how much the host itself was late at most in the second before; `None` if it was
        /// punctual within 10 ms. Answers that it was too late to read look like those of a board
        /// that is gone.
        host_late: Option<Duration>,
    },
    /// The line failed. No board is asked until it is back.
    LineLost {
        /// Why.
        error: &'a LineError,
        /// Boards that may go on regulating their last set points for ever, because they are of the
        /// original kind, or may be.
        holding: &'a [u8],
    },
    /// The line is not back yet, for this reason; told once for each reason in a row.
    LineNotBack {
        /// What opening it said.
        error: &'a OpenBusError,
    },
    /// The line is back, and polling goes on.
    LineBack {
        /// How long it was gone.
        gone: Duration,
    },
    /// The bus thread stood still: the process was stopped, or the machine was too busy.
    Stalled {
        /// For how long beyond what was planned. The boards may have held or vented meanwhile.
        by: Duration,
    },
    /// Boards that are not missing were not heard for so long that they may have vented. They are
    /// sent 0 kPa until they answer; then their set points return by a ramp.
    Paused {
        /// Their numbers.
        boards: &'a [u8],
        /// For how long they were not heard: the longest.
        unheard: Duration,
        /// By how much the host itself was late at most in the second before, as for a board.
        host_late: Option<Duration>,
    },
    /// The vent latch was closed, by whomever: 0 kPa is commanded to all boards until it is
    /// released.
    Vented,
    /// The vent latch was released.
    Released,
    /// Whoever sets the commands has stopped, so 0 kPa is commanded instead: see
    /// [`SetPoints::vent_after`](super::SetPoints::vent_after).
    CommandsStale,
    /// The commands are renewed again, and are sent.
    CommandsBack,
    /// A board answers polls but does not tell its valves' drives. It is asked once a second from
    /// now on. Told once a run.
    NoDrives {
        /// The board's number.
        board: u8,
        /// What came of the last request.
        error: &'a PageError,
    },
    /// A board has told what is on its I2C connector, and that is not what it told before.
    Sensors {
        /// The board's number.
        board: u8,
        /// What it has.
        status: &'a SensorStatus,
    },
    /// A board answers polls but does not tell its sensors. It is asked once a second from now on.
    /// Told once a run.
    NoSensors {
        /// The board's number.
        board: u8,
        /// What came of the last request.
        error: &'a PageError,
    },
    /// All boards have gone to a faster line rate.
    LineRateRaised {
        /// The rate.
        baud: Baud,
    },
    /// The boards are not, or not all, to be had for a faster line rate. Told once for each reason
    /// in a row.
    LineRateKept {
        /// The rate in effect.
        baud: Baud,
        /// Why.
        error: &'a LineRateError,
        /// They are asked again after this time.
        pause: Duration,
    },
    /// A faster line rate is not asked for, because the boards would go back from it between two
    /// cycles.
    LineRateTooSlowPace {
        /// The rate in effect.
        baud: Baud,
        /// Time from cycle to cycle.
        period: Duration,
    },
    /// Too much was lost at a faster line rate: host and boards have gone back.
    LineRateLowered {
        /// The rate before.
        from: Baud,
        /// The rate now.
        to: Baud,
        /// The board that did not answer any more, if it was one.
        silent: Option<u8>,
        /// Exchanges lost in the last second.
        lost: u64,
        /// They are asked again after this time.
        pause: Duration,
    },
    /// A set point of channel 3 is sent one count lower, because board 0 could take it for its
    /// address ([`Bus::commands_on_the_wire`](crate::bus::Bus::commands_on_the_wire)). Told once a
    /// run; rows have what was sent.
    CommandLowered {
        /// The board that is commanded.
        board: u8,
        /// What was to be sent.
        wanted: BoardCommand,
        /// What is sent.
        sent: BoardCommand,
    },
}

/// Gets every row and event. Called on the bus thread between exchanges: it must not block.
pub trait Observer: Send {
    /// A cycle has ended.
    fn row(&mut self, row: &Row<'_>);

    /// Something happened.
    fn event(&mut self, event: &Event<'_>) {
        let _ = event;
    }
}
