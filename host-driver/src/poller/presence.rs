//! Which boards are worth asking in every cycle.

use crate::time::saturating_ns;
use serde::Serialize;
use std::time::Duration;

/// How a board has answered lately.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BoardState {
    /// It has not answered since the start.
    Unseen,
    /// Its last exchange succeeded.
    Present,
    /// Its last exchange failed, but it has not been given up: it is asked again at once, then
    /// after growing pauses.
    Doubtful,
    /// It failed too often in a row and is only asked now and then.
    Missing,
}

/// When a board is given up, and how often it is asked until then and afterwards.
///
/// A board that falls silent is asked in every cycle up to `failures` times, then after pauses of
/// `first_pause` and twice as much each time, and every `probe_every` when they have grown to
/// that. So a board that chance has silenced is back after about as long as it was away, and a dead
/// one costs the others `failures` and seven more timeouts by default (22 ms of the first 0.16 s),
/// then one in each 0.1 s. A board that has not answered since the start, or has been given up,
/// gets no short pauses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct PresencePolicy {
    /// Failures in a row after which a board is not asked in every cycle any more.
    pub failures: u32,
    /// The first pause after that.
    pub first_pause: Duration,
    /// Time between two requests to a missing board. Each costs the others at most its timeout,
    /// 2.2 ms at 1 Mbaud.
    pub probe_every: Duration,
}

impl Default for PresencePolicy {
    /// On a bus that damages one character in a hundred an exchange in five fails, and three in a
    /// row are lost several times a second; ten in a row once in hours. Ten probes a second find a
    /// missing board soon and cost the others about 2 % of their rate.
    fn default() -> Self {
        Self { failures: 3, first_pause: Duration::from_millis(1), probe_every: Duration::from_millis(100) }
    }
}

#[derive(Debug, Clone)]
pub(super) struct Presence {
    /// Failures in a row after which it is not asked in every cycle any more.
    most_failures: u32,
    first_pause_ns: u64,
    probe_every_ns: u64,
    state: BoardState,
    failures: u32,
    next_probe_ns: u64,
}

impl Presence {
    pub(super) fn new(policy: PresencePolicy) -> Self {
        Self {
            most_failures: policy.failures,
            first_pause_ns: saturating_ns(policy.first_pause),
            probe_every_ns: saturating_ns(policy.probe_every),
            state: BoardState::Unseen,
            failures: 0,
            next_probe_ns: 0,
        }
    }

    pub(super) fn state(&self) -> BoardState {
        self.state
    }

    /// Whether it has been silent for so long that its last readings say nothing about the next
    /// one.
    pub(super) fn was_away(&self) -> bool {
        self.state == BoardState::Missing || self.failures >= self.most_failures
    }

    /// Earliest time at which the board should be asked, ns; 0 for every cycle.
    pub(super) fn due_ns(&self) -> u64 {
        self.next_probe_ns
    }

    pub(super) fn answered(&mut self) {
        self.failures = 0;
        self.next_probe_ns = 0;
        self.state = BoardState::Present;
    }

    /// What it failed at is no more: it is asked at once.
    pub(super) fn ask_again(&mut self) {
        self.failures = 0;
        self.next_probe_ns = 0;
    }

    /// The line is gone, and the board with it; when the line is back it is asked at once.
    pub(super) fn line_lost(&mut self) {
        self.failures = 0;
        self.next_probe_ns = 0;
        if self.state != BoardState::Unseen {
            self.state = BoardState::Missing;
        }
    }

    /// The line is back: whether the board is, its next exchanges say.
    pub(super) fn line_back(&mut self) {
        if self.state == BoardState::Missing {
            self.state = BoardState::Doubtful;
        }
    }

    /// The exchange that ended at `now_ns` failed.
    pub(super) fn failed(&mut self, now_ns: u64) {
        self.failures = self.failures.saturating_add(1);
        let was_there = matches!(self.state, BoardState::Present | BoardState::Doubtful);
        if was_there {
            self.state = BoardState::Doubtful;
        }
        let Some(pauses) = self.failures.checked_sub(self.most_failures) else { return };
        let longest_ns = self.probe_every_ns;
        let growing_ns = self.first_pause_ns.saturating_mul(1_u64.checked_shl(pauses).unwrap_or(u64::MAX));
        let given_up = !was_there || growing_ns >= longest_ns;
        self.next_probe_ns = now_ns + if given_up { longest_ns } else { growing_ns };
        if given_up {
            self.state = BoardState::Missing;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pauses of 25, 50 and 100.
    const POLICY: PresencePolicy = PresencePolicy {
        failures: 2,
        first_pause: Duration::from_nanos(25),
        probe_every: Duration::from_nanos(100),
    };

    #[test]
    fn a_board_is_asked_at_once_when_the_line_is_back() {
        let mut presence = Presence::new(POLICY);
        presence.line_lost();
        assert_eq!(presence.state(), BoardState::Unseen);
        presence.answered();
        presence.line_lost();
        assert_eq!((presence.state(), presence.due_ns()), (BoardState::Missing, 0));
        presence.line_back();
        presence.failed(1_000);
        assert_eq!((presence.state(), presence.due_ns()), (BoardState::Doubtful, 0));
        for (failed_ns, due_ns) in [(1_010, 1_035), (1_040, 1_090), (1_100, 1_200)] {
            presence.failed(failed_ns);
            assert_eq!(presence.due_ns(), due_ns);
        }
        assert_eq!(presence.state(), BoardState::Missing, "it is given up like any other");
    }

    #[test]
    fn a_board_is_given_up_after_growing_pauses_and_found_again() {
        let mut presence = Presence::new(POLICY);
        assert_eq!(presence.state(), BoardState::Unseen);
        presence.answered();
        presence.failed(1_000);
        assert_eq!((presence.state(), presence.due_ns()), (BoardState::Doubtful, 0));
        assert!(!presence.was_away());
        for (failed_ns, due_ns) in [(1_010, 1_035), (1_040, 1_090)] {
            presence.failed(failed_ns);
            assert_eq!((presence.state(), presence.due_ns()), (BoardState::Doubtful, due_ns));
            assert!(presence.was_away());
        }
        for failed_ns in [1_100, 1_210, 1_320] {
            presence.failed(failed_ns);
            assert_eq!((presence.state(), presence.due_ns()), (BoardState::Missing, failed_ns + 100));
        }
        presence.answered();
        assert_eq!((presence.state(), presence.due_ns()), (BoardState::Present, 0));
        assert!(!presence.was_away());
    }

    #[test]
    fn a_board_that_was_never_there_gets_no_short_pauses() {
        let mut presence = Presence::new(POLICY);
        presence.failed(1_000);
        assert_eq!((presence.state(), presence.due_ns()), (BoardState::Unseen, 0));
        presence.failed(1_010);
        assert_eq!((presence.state(), presence.due_ns()), (BoardState::Missing, 1_110));
    }

    #[test]
    fn pauses_do_not_overflow() {
        let endless = PresencePolicy {
            failures: 0,
            first_pause: Duration::from_nanos(1 << 40),
            probe_every: Duration::MAX,
        };
        let mut presence = Presence::new(endless);
        presence.answered();
        for _ in 0..100 {
            presence.failed(1_000);
        }
        assert_eq!(
            (presence.state(), presence.due_ns()),
            (BoardState::Missing, 1_000 + saturating_ns(Duration::MAX))
        );
    }
}
