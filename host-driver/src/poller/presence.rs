//! Which boards are worth asking in every cycle.

use serde::Serialize;

/// How a board has answered lately.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BoardState {
    /// It has not answered since the start.
    Unseen,
    /// Its last exchange succeeded.
    Present,
    /// Its last exchange failed, but not often enough in a row to give it up.
    Doubtful,
    /// It failed too often in a row and is only asked now and then.
    Missing,
}

/// When a board is given up, and how often it is asked then.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PresencePolicy {
    /// Failures in a row after which a board is asked at the reduced rate.
    pub failures: u32,
    /// Time between two requests to a missing board, ns. Each costs the others at most its timeout, 2.2 ms at 1 Mbaud.
    pub probe_every_ns: u64,
}

impl Default for PresencePolicy {
    /// Three failures in a row do not happen by noise that leaves a bus usable (1 % loss: once in a million exchanges); ten
    /// probes a second find a board soon and cost the others about 2 % of their rate.
    fn default() -> Self {
        Self { failures: 3, probe_every_ns: 100_000_000 }
    }
}

#[derive(Debug, Clone)]
pub(super) struct Presence {
    policy: PresencePolicy,
    state: BoardState,
    failures: u32,
    next_probe_ns: u64,
}

impl Presence {
    pub(super) fn new(policy: PresencePolicy) -> Self {
        Self { policy, state: BoardState::Unseen, failures: 0, next_probe_ns: 0 }
    }

    pub(super) fn state(&self) -> BoardState {
        self.state
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
        if self.failures >= self.policy.failures {
            self.next_probe_ns = now_ns + self.policy.probe_every_ns;
            self.state = BoardState::Missing;
        } else if self.state == BoardState::Present {
            self.state = BoardState::Doubtful;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_is_asked_at_once_when_the_line_is_back() {
        let mut presence = Presence::new(PresencePolicy { failures: 2, probe_every_ns: 100 });
        presence.line_lost();
        assert_eq!(presence.state(), BoardState::Unseen);
        presence.answered();
        presence.line_lost();
        assert_eq!((presence.state(), presence.due_ns()), (BoardState::Missing, 0));
        presence.line_back();
        presence.failed(1_000);
        assert_eq!(presence.state(), BoardState::Doubtful);
        presence.failed(1_010);
        assert_eq!(presence.state(), BoardState::Missing, "it is given up like any other");
    }

    #[test]
    fn a_board_is_given_up_after_some_failures_and_found_again() {
        let mut presence = Presence::new(PresencePolicy { failures: 2, probe_every_ns: 100 });
        assert_eq!(presence.state(), BoardState::Unseen);
        presence.answered();
        presence.failed(1_000);
        assert_eq!((presence.state(), presence.due_ns()), (BoardState::Doubtful, 0));
        presence.failed(1_010);
        assert_eq!((presence.state(), presence.due_ns()), (BoardState::Missing, 1_110));
        presence.failed(1_120);
        assert_eq!(presence.due_ns(), 1_220);
        presence.answered();
        assert_eq!((presence.state(), presence.due_ns()), (BoardState::Present, 0));
    }
}
