//! When a bus goes to a faster line rate, and when it goes back.

use super::{BoardState, Event, Pace, Polling};
use crate::bus::LineRateError;
use crate::line::{Line, LineError};
use crate::time::saturating_ns;
use pneudrive_protocol::pages::LineRate;
use std::time::Duration;

/// How fast a line rate to ask the boards for, and how often.
///
/// They are asked when all boards of the bus answer. If they agree, and answer at the new rate, it
/// is kept until a board fails [`PresencePolicy::failures`](super::PresencePolicy::failures) times
/// in a row or [`lost_in_a_second`](Self::lost_in_a_second) exchanges are lost; then all are back
/// at the compiled rate. They are asked again after `first_pause`, and after twice as long each
/// time up to `longest_pause`: for the next lower rate where one has lost too much, or has
/// failed twice otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct LineRatePolicy {
    /// The fastest to ask for.
    pub fastest: LineRate,
    /// The first pause after a refusal or a return.
    pub first_pause: Duration,
    /// The longest.
    pub longest_pause: Duration,
    /// So many lost exchanges in a second are too many.
    pub lost_in_a_second: u64,
}

impl LineRatePolicy {
    /// The fastest to ask for.
    #[must_use]
    pub fn fastest(self, fastest: LineRate) -> Self {
        Self { fastest, ..self }
    }
}

impl Default for LineRatePolicy {
    /// Asking costs the boards some ten exchanges each, and 0.1 s without answers where it fails: 1
    /// % of the time at first, next to nothing later. Twenty losses a second are half of what four
    /// boards lose at 1 kHz where one character in 2000 is damaged.
    fn default() -> Self {
        Self {
            fastest: LineRate::ThreeMbaud,
            first_pause: Duration::from_secs(10),
            longest_pause: Duration::from_secs(640),
            lost_in_a_second: 20,
        }
    }
}

/// A board goes back after 100 ms without a request: one in half that time must be planned.
const LONGEST_PERIOD: Duration = Duration::from_millis(50);
const SECOND_NS: u64 = 1_000_000_000;

#[derive(Debug)]
pub(super) struct LineRateSchedule {
    policy: Option<LineRatePolicy>,
    next_try_ns: u64,
    pause_ns: u64,
    /// What is asked for next, at most.
    ceiling: LineRate,
    /// Has that failed before? One failure may be a passing one: of a machine that was busy, of a
    /// plug.
    has_failed: bool,
    /// What was told last.
    reason: String,
    window_since_ns: u64,
    /// Exchanges that had been lost when the window began.
    lost_before: u64,
}

impl LineRateSchedule {
    pub(super) fn new(policy: Option<LineRatePolicy>) -> Self {
        let (pause_ns, ceiling) = policy
            .map_or((0, LineRate::Compiled), |policy| (saturating_ns(policy.first_pause), policy.fastest));
        Self {
            policy,
            next_try_ns: 0,
            pause_ns,
            ceiling,
            has_failed: false,
            reason: String::new(),
            window_since_ns: 0,
            lost_before: 0,
        }
    }

    /// It did not work: later, and slower if there is a slower one; the first time only where that
    /// rate `cannot_be`.
    fn give_up(&mut self, now_ns: u64, cannot_be: bool) -> Duration {
        let Some(policy) = self.policy else { return Duration::ZERO };
        self.ceiling = match (self.has_failed || cannot_be, self.ceiling) {
            (false, same) => same,
            (true, LineRate::ThreeMbaud) => LineRate::TwoMbaud,
            (true, _) => policy.fastest,
        };
        self.has_failed = !(self.has_failed || cannot_be);
        let pause_ns = self.pause_ns;
        self.next_try_ns = now_ns + pause_ns;
        self.pause_ns = (2 * pause_ns).min(saturating_ns(policy.longest_pause).max(pause_ns));
        Duration::from_nanos(pause_ns)
    }

    /// Whether more was lost within a second than may be.
    fn loses_too_much(&mut self, now_ns: u64, lost: u64) -> bool {
        if now_ns.saturating_sub(self.window_since_ns) >= SECOND_NS {
            (self.window_since_ns, self.lost_before) = (now_ns, lost);
        }
        self.policy.is_some_and(|policy| lost - self.lost_before >= policy.lost_in_a_second)
    }
}

impl<L: Line> Polling<L> {
    /// At the end of a cycle: asks for a faster line rate, or goes back.
    pub(super) fn look_after_line_rate(&mut self) -> Result<(), LineError> {
        if self.line_rate.policy.is_none() || self.outage.is_some() {
            return Ok(());
        }
        if self.bus.line_rate() == LineRate::Compiled { self.raise() } else { self.lower_if_it_fails() }
    }

    fn raise(&mut self) -> Result<(), LineError> {
        let now_ns = self.bus.line().now_ns();
        // Sessions begin with the first requests.
        let is_ready =
            |row: &super::BoardRow| row.state == BoardState::Present && !self.bus.session_is_due(row.board);
        if !self.rows.iter().all(is_ready) || now_ns < self.line_rate.next_try_ns {
            return Ok(());
        }
        if let Pace::Every { period, .. } = self.options.pace
            && period > LONGEST_PERIOD
        {
            self.line_rate.policy = None;
            self.tell(&Event::LineRateTooSlowPace { baud: self.bus.baud(), period });
            return Ok(());
        }
        let boards: Vec<u8> = self.rows.iter().map(|row| row.board).collect();
        let ceiling = self.line_rate.ceiling;
        let raised = self.bus.fastest_line_rate(&boards).and_then(|allowed| {
            let rate = allowed.min(ceiling);
            self.bus.raise_line_rate(&boards, rate)
        });
        let now_ns = self.bus.line().now_ns();
        match raised {
            Ok(()) => {
                self.line_rate.reason.clear();
                (self.line_rate.window_since_ns, self.line_rate.lost_before) = (now_ns, self.lost());
                self.tell(&Event::LineRateRaised { baud: self.bus.baud() });
            }
            Err(LineRateError::Line(error)) => return Err(error),
            Err(error) => {
                let pause = self.line_rate.give_up(now_ns, matches!(error, LineRateError::Adapter { .. }));
                let reason = error.to_string();
                if std::mem::replace(&mut self.line_rate.reason, reason.clone()) != reason {
                    let baud = self.bus.baud();
                    self.tell(&Event::LineRateKept { baud, error: &error, pause });
                }
            }
        }
        Ok(())
    }

    fn lower_if_it_fails(&mut self) -> Result<(), LineError> {
        let (now_ns, lost) = (self.bus.line().now_ns(), self.lost());
        let silent = self.presence.iter().position(super::presence::Presence::was_away);
        if !self.line_rate.loses_too_much(now_ns, lost) && silent.is_none() {
            return Ok(());
        }
        let from = self.bus.baud();
        let boards: Vec<u8> = self.rows.iter().map(|row| row.board).collect();
        self.bus.lower_line_rate(&boards)?;
        let silent = silent.and_then(|index| boards.get(index).copied());
        let pause = self.line_rate.give_up(self.bus.line().now_ns(), silent.is_none());
        // At the compiled rate it is another matter.
        for presence in &mut self.presence {
            presence.ask_again();
        }
        let lost = lost - self.line_rate.lost_before;
        self.tell(&Event::LineRateLowered { from, to: self.bus.baud(), silent, lost, pause });
        Ok(())
    }

    fn lost(&self) -> u64 {
        self.rows.iter().map(|row| self.bus.counters(row.board).lost()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_grow_and_a_rate_that_fails_twice_gives_way_to_a_slower_one() {
        let mut schedule = LineRateSchedule::new(Some(LineRatePolicy::default()));
        let mut tries = Vec::new();
        for _ in 0..9 {
            let asked = schedule.ceiling;
            tries.push((asked as u8, schedule.give_up(0, false).as_secs()));
        }
        let expected = [(3, 10), (3, 20), (2, 40), (2, 80), (3, 160), (3, 320), (2, 640), (2, 640), (3, 640)];
        assert_eq!(tries, expected);
    }

    #[test]
    fn a_rate_that_cannot_be_gives_way_at_once() {
        let mut schedule = LineRateSchedule::new(Some(LineRatePolicy::default()));
        schedule.give_up(0, true);
        assert_eq!(schedule.ceiling, LineRate::TwoMbaud);
        schedule.give_up(0, false);
        assert_eq!(schedule.ceiling, LineRate::TwoMbaud);
        schedule.give_up(0, false);
        assert_eq!(schedule.ceiling, LineRate::ThreeMbaud);
    }

    #[test]
    fn twenty_losses_within_a_second_are_too_many() {
        let mut schedule = LineRateSchedule::new(Some(LineRatePolicy::default()));
        assert!(!schedule.loses_too_much(0, 19));
        assert!(!schedule.loses_too_much(SECOND_NS, 19));
        assert!(!schedule.loses_too_much(SECOND_NS + 5, 38));
        assert!(schedule.loses_too_much(SECOND_NS + 6, 39));
    }
}
