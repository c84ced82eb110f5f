use crate::damage::DamageMonitor;
use crate::{BoardConfig, Micros};
use pneudrive_protocol::Baud;
use pneudrive_protocol::pages::{LineRate, LineRateAnswer, LineRateState, RateReturn};

/// The line rate of a board: taken from its host, and given back.
///
/// ```text
///  compiled --asked for, in a session--> on trial --a request at the new rate--> held
///     ^                                     |                                     |
///     +-- no request for 100 ms ------------+------------- or too much damage ----+
/// ```
///
/// It says at which rate the board speaks and nothing else: set points, command timeout and what
/// follows from them go on whatever becomes of it.
#[derive(Debug, Clone)]
pub(crate) struct LineRateKeeper {
    compiled: Baud,
    now: LineRate,
    fastest: LineRate,
    /// Takes effect when the answer that says so has been sent.
    next: Option<LineRate>,
    /// When the rate was changed, or the last request at it ended.
    heard: Micros,
    /// A request has come at the rate in effect.
    held: bool,
    damage: DamageMonitor,
    /// When damage was counted last.
    counted: Micros,
    returns: u16,
    last_return: Option<RateReturn>,
}

impl LineRateKeeper {
    /// Silence after which a board goes back. A polling host's longest pause, with three boards
    /// missing and a busy machine, is shorter; and four fifths of the command timeout's default are
    /// left in which the host finds the board at the compiled rate, before it holds.
    pub(crate) const SILENCE: Micros = Micros::from_millis(100);
    /// Damage counts once in this time: a burst of noise is one, and a wrong rate one after the
    /// other.
    const APART: Micros = Micros::from_millis(1);

    pub(crate) fn new(config: &BoardConfig) -> Self {
        // Earlier than so much damage makes the board vent.
        let limit = (config.damage_limit / 2).max(1);
        Self {
            compiled: config.baud,
            now: LineRate::Compiled,
            fastest: config.max_baud,
            next: None,
            heard: Micros::ZERO,
            held: false,
            damage: DamageMonitor::with(limit, config.damage_window),
            counted: Micros::ZERO,
            returns: 0,
            last_return: None,
        }
    }

    /// Obeys a request for a rate that came in a session, or not.
    pub(crate) fn change(&mut self, rate: LineRate, in_session: bool) -> LineRateAnswer {
        if !in_session {
            return LineRateAnswer::NeedsSession;
        }
        if rate > self.fastest {
            return LineRateAnswer::TooFast;
        }
        self.next = Some(rate);
        LineRateAnswer::Taken
    }

    /// The host leaves: the next one begins at the compiled rate.
    pub(crate) fn leave(&mut self) {
        self.next = Some(LineRate::Compiled);
    }

    /// A valid request to this board ended at `now`.
    pub(crate) fn heard(&mut self, now: Micros) {
        self.heard = now;
        self.held = true;
    }

    /// Something came damaged. Seldom, so that it need not be quick. On trial the rest of the bus
    /// is still at the rate before, so that everything does.
    #[inline(never)]
    pub(crate) fn damaged(&mut self, now: Micros) {
        if self.now != LineRate::Compiled && self.held && now.since(self.counted) >= Self::APART {
            self.counted = now;
            self.damage.damaged(now);
        }
    }

    /// An answer has been sent; gives the rate that follows it, if that is another.
    pub(crate) fn answer_sent(&mut self, now: Micros) -> Option<Baud> {
        let next = self.next.take().filter(|next| *next != self.now)?;
        Some(self.go_to(next, now))
    }

    /// Gives the rate to go back to, if it is time.
    pub(crate) fn due(&mut self, now: Micros) -> Option<Baud> {
        if self.now == LineRate::Compiled {
            return None;
        }
        let why = if self.damage.latched() {
            RateReturn::Damage
        } else if now.since(self.heard) >= Self::SILENCE {
            RateReturn::Silence
        } else {
            return None;
        };
        self.returns = self.returns.saturating_add(1);
        self.last_return = Some(why);
        Some(self.go_to(LineRate::Compiled, now))
    }

    #[inline(never)]
    fn go_to(&mut self, rate: LineRate, now: Micros) -> Baud {
        self.now = rate;
        self.next = None;
        self.heard = now;
        self.held = false;
        self.damage.release();
        self.baud()
    }

    pub(crate) fn baud(&self) -> Baud {
        self.now.baud(self.compiled)
    }

    pub(crate) fn state(&self) -> LineRateState {
        LineRateState {
            now: self.now,
            fastest: self.fastest,
            returns: self.returns,
            last_return: self.last_return,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(micros: u64) -> Micros {
        Micros::new(micros)
    }

    /// At 3 Mbaud since 1 s.
    fn raised() -> LineRateKeeper {
        let mut keeper = LineRateKeeper::new(&BoardConfig::ORIGINAL);
        assert_eq!(keeper.change(LineRate::ThreeMbaud, true), LineRateAnswer::Taken);
        assert_eq!(keeper.baud(), Baud::ORIGINAL, "not before the answer has been sent");
        assert_eq!(keeper.answer_sent(at(1_000_000)), Some(Baud::THREE_MBAUD));
        keeper
    }

    #[test]
    fn a_rate_needs_a_session_and_the_boards_leave() {
        let config = BoardConfig { max_baud: LineRate::TwoMbaud, ..BoardConfig::ORIGINAL };
        let mut keeper = LineRateKeeper::new(&config);
        assert_eq!(keeper.change(LineRate::TwoMbaud, false), LineRateAnswer::NeedsSession);
        assert_eq!(keeper.change(LineRate::ThreeMbaud, true), LineRateAnswer::TooFast);
        assert_eq!(keeper.answer_sent(at(5)), None);
        assert_eq!(keeper.change(LineRate::TwoMbaud, true), LineRateAnswer::Taken);
        assert_eq!(keeper.answer_sent(at(9)), Some(Baud::TWO_MBAUD));
        assert_eq!(keeper.answer_sent(at(10)), None, "once");
    }

    #[test]
    fn without_a_request_it_goes_back_after_100_ms_to_the_microsecond() {
        let mut keeper = raised();
        assert_eq!(keeper.due(at(1_099_999)), None);
        assert_eq!(keeper.due(at(1_100_000)), Some(Baud::ORIGINAL));
        assert_eq!((keeper.state().returns, keeper.state().last_return), (1, Some(RateReturn::Silence)));
        assert_eq!(keeper.due(at(9_000_000)), None, "once");
        let mut keeper = raised();
        keeper.heard(at(1_050_000));
        assert_eq!(keeper.due(at(1_149_999)), None);
        assert_eq!(keeper.due(at(1_150_000)), Some(Baud::ORIGINAL));
    }

    /// Half of the 50 that make a board vent, each of another millisecond.
    #[test]
    fn damage_in_25_milliseconds_of_a_second_sends_it_back() {
        let mut keeper = raised();
        keeper.heard(at(1_000_500));
        for ms in 1_001..1_025 {
            keeper.damaged(at(ms * 1_000));
            keeper.damaged(at(ms * 1_000 + 300));
            keeper.heard(at(ms * 1_000 + 500));
            assert_eq!(keeper.due(at(ms * 1_000 + 600)), None, "{ms}");
        }
        keeper.damaged(at(1_025_000));
        assert_eq!(keeper.due(at(1_025_000)), Some(Baud::ORIGINAL));
        assert_eq!(keeper.state().last_return, Some(RateReturn::Damage));
    }

    #[test]
    fn on_trial_nothing_but_silence_counts() {
        let mut keeper = raised();
        (1_000..1_099).for_each(|ms| keeper.damaged(at(ms * 1_000)));
        assert_eq!(keeper.due(at(1_099_000)), None);
        keeper.heard(at(1_099_500));
        assert_eq!(keeper.due(at(1_150_000)), None);
    }

    #[test]
    fn when_the_host_leaves_it_goes_back_with_the_answer() {
        let mut keeper = raised();
        keeper.heard(at(1_001_000));
        keeper.leave();
        assert_eq!(keeper.answer_sent(at(1_001_100)), Some(Baud::ORIGINAL));
        assert_eq!(keeper.state().returns, 0, "not by itself");
        keeper.leave();
        assert_eq!(keeper.answer_sent(at(1_002_000)), None, "it is there");
    }
}
