//! What happens in a run, in a sentence and a word: for people, and for the events of a recording.

use crate::bus::{ExchangeError, OpenBusError};
use crate::line::{LineError, OpenError};
use crate::poller::{BoardCommand, BoardState, Event};
use pneudrive_protocol::CHANNELS;
use pneudrive_protocol::pages::{SensorPart, SensorState, SensorStatus};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Notice {
    /// What sort of thing.
    pub kind: NoticeKind,
    /// The board's number, where it is about one.
    pub board: Option<u8>,
    /// A sentence for people.
    pub text: String,
}

/// What sort of thing happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum NoticeKind {
    /// A board does not answer any more.
    BoardMissing,
    /// It answers again.
    BoardBack,
    /// The line failed.
    LineLost,
    /// The line cannot be opened yet.
    LineNotBack,
    /// The line is back.
    LineBack,
    /// The host stood still.
    Stalled,
    /// Boards were not heard for so long that they are sent 0 kPa until they answer.
    Paused,
    /// Nobody renews the commands.
    CommandsStale,
    /// The commands are renewed again.
    CommandsBack,
    /// A set point is sent one count lower than it was given.
    CommandLowered,
    /// A board does not tell its valves' drives.
    NoDrives,
    /// What is on a board's I2C connector, at first and when it has changed.
    Sensors,
    /// A board's sensors are not live any more, or it does not tell them.
    NoSensors,
    /// The line rate was raised, or stays as it is.
    LineRate,
    /// The line rate was lowered because too much was lost.
    LineRateLowered,
    /// 0 kPa is commanded to all boards until somebody releases them.
    Vented,
    /// The boards were released.
    Released,
    /// Something was done from the page.
    Page,
    /// Something was done from the keyboard.
    Key,
    /// About a recording.
    Recording,
    /// The calibrated model beside the run: what it does.
    Watch,
    /// The calibrated model says that something has changed.
    Changed,
    /// The calibrated model runs no more.
    WatchFailed,
    /// Boards did not confirm the final 0 kPa.
    NotSafe,
    /// Anything else that people are told.
    Information,
    /// The run ended; the text begins with the reason's word.
    End,
}

impl NoticeKind {
    /// Its name in recordings.
    pub fn name(self) -> &'static str {
        match self {
            Self::BoardMissing => "board_missing",
            Self::BoardBack => "board_back",
            Self::LineLost => "line_lost",
            Self::LineNotBack => "line_not_back",
            Self::LineBack => "line_back",
            Self::Stalled => "stalled",
            Self::Paused => "paused",
            Self::CommandsStale => "commands_stale",
            Self::CommandsBack => "commands_back",
            Self::CommandLowered => "command_lowered",
            Self::NoDrives => "no_drives",
            Self::Sensors => "sensors",
            Self::NoSensors => "no_sensors",
            Self::LineRate => "line_rate",
            Self::LineRateLowered => "line_rate_lowered",
            Self::Vented => "vented",
            Self::Released => "released",
            Self::Page => "page",
            Self::Key => "key",
            Self::Recording => "recording",
            Self::Watch => "watch",
            Self::Changed => "changed",
            Self::WatchFailed => "watch_failed",
            Self::NotSafe => "not_safe",
            Self::Information => "information",
            Self::End => "end",
        }
    }

    /// Whether somebody should look after it.
    pub fn is_warning(self) -> bool {
        matches!(
            self,
            Self::BoardMissing
                | Self::LineLost
                | Self::LineNotBack
                | Self::Stalled
                | Self::Paused
                | Self::CommandsStale
                | Self::NoDrives
                | Self::NoSensors
                | Self::LineRateLowered
                | Self::Changed
                | Self::WatchFailed
                | Self::NotSafe
        )
    }
}

impl Notice {
    /// About the run.
    pub fn new(kind: NoticeKind, text: impl Into<String>) -> Self {
        Self { kind, board: None, text: text.into() }
    }
}

/// Turns the events of one bus into notices. One lost answer is none: a board becomes news when it
/// stays away, and when it comes back.
#[derive(Debug, Clone, Default)]
pub struct NoticeWriter {
    /// Boards that have been reported missing.
    missing: BTreeSet<u8>,
    /// Boards that had a supply sensor, and an IMU, when they told last.
    had: BTreeMap<u8, [bool; 2]>,
}

impl NoticeWriter {
    /// What there is to say about `event`, if anything.
    pub fn notice(&mut self, event: &Event<'_>) -> Option<Notice> {
        let new = |kind, text: String| Some(Notice::new(kind, text));
        match event {
            Event::Board { board, state: BoardState::Missing, error, host_late }
                if self.missing.insert(*board) =>
            {
                let why = match (error, host_late) {
                    // Not a word of wires, where it is the host that did not listen.
                    (Some(ExchangeError::NoAnswer { .. } | ExchangeError::TooOld { .. }), Some(late)) => {
                        format!(
                            " (no answer, but the host was late by {:.2} s in the same second: close other programs, or use --realtime)",
                            late.as_secs_f64()
                        )
                    }
                    (Some(error), _) => format!(" ({error})"),
                    (None, _) => String::new(),
                };
                let text = format!("board {board} is missing{why}");
                Some(Notice { kind: NoticeKind::BoardMissing, board: Some(*board), text })
            }
            Event::Board { board, state: BoardState::Present, .. } if self.missing.remove(board) => {
                let text = format!("board {board} answers again");
                Some(Notice { kind: NoticeKind::BoardBack, board: Some(*board), text })
            }
            Event::LineLost { error, holding } => new(NoticeKind::LineLost, line_lost(error, holding)),
            Event::CommandLowered { board, wanted, sent } => {
                let text = lowered(*board, wanted, sent);
                Some(Notice { kind: NoticeKind::CommandLowered, board: Some(*board), text })
            }
            Event::NoDrives { board, error } => {
                let text = format!(
                    "board {board} does not tell its valves' drives ({error}); firmware of before pages does not"
                );
                Some(Notice { kind: NoticeKind::NoDrives, board: Some(*board), text })
            }
            Event::Sensors { board, status } => Some(self.sensors(*board, status)),
            Event::NoSensors { board, error } => {
                let text = format!(
                    "board {board} does not tell its sensors ({error}); firmware of before sensors does not"
                );
                Some(Notice { kind: NoticeKind::NoSensors, board: Some(*board), text })
            }
            Event::LineRateRaised { baud } => {
                new(NoticeKind::LineRate, format!("all boards have gone to {} baud", baud.get()))
            }
            Event::LineRateKept { baud, error, pause } => new(
                NoticeKind::LineRate,
                format!(
                    "the line rate stays at {} baud: {error}; asked again after {:.0} s",
                    baud.get(),
                    pause.as_secs_f64()
                ),
            ),
            Event::LineRateTooSlowPace { baud, period } => new(
                NoticeKind::LineRate,
                format!(
                    "the line rate stays at {} baud: a cycle every {} ms would lose a faster one, which boards keep for 100 ms",
                    baud.get(),
                    period.as_millis()
                ),
            ),
            Event::LineRateLowered { from, to, silent, lost, pause } => {
                let why = match silent {
                    Some(board) => format!("board {board} did not answer any more"),
                    None => format!("{lost} exchanges were lost within a second"),
                };
                let (from, to, pause) = (from.get(), to.get(), pause.as_secs_f64());
                let text = format!("back from {from} to {to} baud: {why}; asked again after {pause:.0} s");
                Some(Notice { kind: NoticeKind::LineRateLowered, board: *silent, text })
            }
            Event::LineNotBack { error: OpenBusError::Port(OpenError::NotFound { .. }) } => None,
            Event::LineNotBack { error } => {
                new(NoticeKind::LineNotBack, format!("the port cannot be used yet: {error}"))
            }
            Event::LineBack { gone } => new(
                NoticeKind::LineBack,
                format!("the port is back after {:.1} s, polling goes on", gone.as_secs_f64()),
            ),
            Event::Stalled { by } => new(
                NoticeKind::Stalled,
                format!(
                    "the host stood still for {:.1} s: it was stopped, or the machine is overloaded",
                    by.as_secs_f64()
                ),
            ),
            Event::Paused { boards, unheard, host_late } => {
                new(NoticeKind::Paused, paused(boards, *unheard, *host_late))
            }
            Event::CommandsStale => {
                new(NoticeKind::CommandsStale, "nobody renews the commands: 0 kPa is commanded".to_owned())
            }
            Event::CommandsBack => new(NoticeKind::CommandsBack, "the commands are renewed again".to_owned()),
            Event::Vented => {
                new(NoticeKind::Vented, "0 kPa is commanded to all boards until they are released".to_owned())
            }
            Event::Released => new(NoticeKind::Released, "the boards are released".to_owned()),
            _ => None,
        }
    }
}

impl NoticeWriter {
    /// What is on a board's I2C connector.
    fn sensors(&mut self, board: u8, status: &SensorStatus) -> Notice {
        let one = |what: &str, part: SensorPart, state: SensorState| match part {
            SensorPart::None => format!("no {what}"),
            part => format!("{what} {part} {}", state.name().replace('_', " ")),
        };
        let has = [status.supply, status.imu].map(|part| part != SensorPart::None);
        let had = self.had.insert(board, has).unwrap_or_default();
        let lost_one = had.iter().zip(has).any(|(&had, has)| had && !has);
        let text = format!(
            "board {board}: {}, {}{}",
            one("supply sensor", status.supply, status.supply_state),
            one("IMU", status.imu, status.imu_state),
            if lost_one { "; it had more before" } else { "" },
        );
        let states = [status.supply_state, status.imu_state];
        let fails = has.iter().zip(states).any(|(&has, state)| has && state != SensorState::Live);
        let kind = if fails || lost_one { NoticeKind::NoSensors } else { NoticeKind::Sensors };
        Notice { kind, board: Some(board), text }
    }
}

fn line_lost(error: &LineError, holding: &[u8]) -> String {
    if holding.is_empty() {
        return format!("{error}; waiting for it to come back, the boards vent by their own command timeout");
    }
    let boards: Vec<_> = holding.iter().map(u8::to_string).collect();
    format!(
        "{error}; waiting for it to come back. WARNING: board(s) {} may be of the original kind, which has no command timeout, and \
         may stay under pressure",
        boards.join(", ")
    )
}

fn paused(boards: &[u8], unheard: Duration, host_late: Option<Duration>) -> String {
    let why = match host_late {
        Some(late) => format!("the host was late by {:.2} s, and ", late.as_secs_f64()),
        None => String::new(),
    };
    let boards: Vec<_> = boards.iter().map(u8::to_string).collect();
    format!(
        "{why}board(s) {} had not answered for {:.2} s and may have vented: 0 kPa was sent, from the next answer on set points \
         return by a ramp",
        boards.join(", "),
        unheard.as_secs_f64()
    )
}

fn lowered(board: u8, wanted: &BoardCommand, sent: &BoardCommand) -> String {
    let [wanted, sent] = [wanted, sent].map(|command| command[CHANNELS - 1]);
    format!(
        "the set point of channel 3 of board {board} ({} counts) is sent as {} counts, one lower, because board 0 may be of the \
         original kind and would take it for its address; the same holds for 255, 511, 767 and 1023 counts on channel 3 of \
         every board",
        wanted.get(),
        sent.get(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_is_news_when_it_stays_away_and_when_it_is_back() {
        let mut narrator = NoticeWriter::default();
        let mut tell = |state| {
            let notice = narrator.notice(&Event::Board { board: 2, state, error: None, host_late: None });
            notice.map(|notice| (notice.kind.name(), notice.board, notice.text))
        };
        assert_eq!(tell(BoardState::Present), None);
        assert_eq!(tell(BoardState::Doubtful), None);
        let missing = ("board_missing", Some(2), "board 2 is missing".to_owned());
        assert_eq!(tell(BoardState::Missing), Some(missing));
        assert_eq!(tell(BoardState::Missing), None, "once");
        let back = ("board_back", Some(2), "board 2 answers again".to_owned());
        assert_eq!(tell(BoardState::Present), Some(back));
    }

    #[test]
    fn a_pause_after_which_zero_kpa_was_sent_is_news() {
        let event = Event::Paused {
            boards: &[0, 2],
            unheard: Duration::from_millis(430),
            host_late: Some(Duration::from_millis(188)),
        };
        let notice = NoticeWriter::default().notice(&event).unwrap();
        assert!(notice.kind.is_warning() && notice.kind.name() == "paused");
        assert_eq!(
            notice.text,
            "the host was late by 0.19 s, and board(s) 0, 2 had not answered for 0.43 s and may have vented: 0 kPa was sent, \
             from the next answer on set points return by a ramp"
        );
    }

    /// A starved host is no wiring fault.
    #[test]
    fn a_board_that_a_late_host_missed_is_not_said_to_be_badly_wired() {
        let asked = pneudrive_protocol::Address::of_board(2);
        let error = ExchangeError::NoAnswer { asked, waited: Duration::from_millis(2) };
        let text = |host_late| {
            let event = Event::Board { board: 2, state: BoardState::Missing, error: Some(&error), host_late };
            NoticeWriter::default().notice(&event).unwrap().text
        };
        assert!(text(None).contains("the two wires"), "{}", text(None));
        let late = text(Some(Duration::from_millis(700)));
        assert!(late.contains("the host was late by 0.70 s") && !late.contains("wires"), "{late}");
    }
}
