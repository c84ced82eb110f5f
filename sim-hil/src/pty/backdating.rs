/// When a request began on the wire, judged by when the simulator saw it.
///
/// Pure functions of their arguments; the module's front page says why requests are dated back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RequestBackdating {
    /// Median round trip of the pty, ns: what is taken off every request.
    pub round_trip_ns: u64,
    /// Most that is taken off, ns: the answer must still be under way then.
    pub limit_ns: u64,
}

/// The last bytes that were handed to the client.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Delivery {
    /// When, ns.
    pub at_ns: u64,
    /// How long after their last stop bit, ns: the simulator's own delay, which no UART has.
    pub late_ns: u64,
}

impl RequestBackdating {
    /// A request seen so soon after an answer was handed over, ns, is a reaction to it, and was as
    /// late as the answer. A later one has another reason.
    const REACTION_NS: u64 = 100_000;

    /// The start of bytes seen at `seen_ns`, on a bus that has been simulated up to `simulated_ns`.
    ///
    /// Whatever was on the wire has ended by `simulated_ns`, or it is still there and the bytes
    /// fall into it: in either case nothing before that time can be changed.
    pub fn start_ns(self, seen_ns: u64, before: Delivery, simulated_ns: u64) -> u64 {
        self.quiet_horizon_ns(seen_ns, before).max(simulated_ns)
    }

    /// How far a quiet bus may be simulated at `now_ns`, so that a request that is under way can
    /// still be dated back.
    pub fn quiet_horizon_ns(self, now_ns: u64, before: Delivery) -> u64 {
        let reacts = now_ns.saturating_sub(before.at_ns) <= Self::REACTION_NS;
        let late_ns = if reacts { before.late_ns } else { 0 };
        now_ns.saturating_sub((self.round_trip_ns + late_ns).min(self.limit_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::{Delivery, RequestBackdating};

    const DATING: RequestBackdating = RequestBackdating { round_trip_ns: 50_000, limit_ns: 80_000 };
    const ANSWER_ENDED_NS: u64 = 1_215_000;
    const PUNCTUAL: Delivery = Delivery { at_ns: ANSWER_ENDED_NS, late_ns: 0 };

    /// A client that answers an answer at once is on the wire at once: cycles are as long as the
    /// wire makes them.
    #[test]
    fn a_reaction_within_the_round_trip_costs_nothing() {
        for after_ns in [40_000, 50_000] {
            let seen_ns = ANSWER_ENDED_NS + after_ns;
            assert_eq!(DATING.start_ns(seen_ns, PUNCTUAL, ANSWER_ENDED_NS), ANSWER_ENDED_NS);
        }
    }

    #[test]
    fn what_goes_beyond_is_charged_once() {
        assert_eq!(DATING.start_ns(1_300_000, PUNCTUAL, ANSWER_ENDED_NS), 1_250_000);
        // A quiet bus is never simulated beyond the date of a request that may still come.
        assert_eq!(DATING.quiet_horizon_ns(1_300_000, PUNCTUAL), DATING.start_ns(1_300_000, PUNCTUAL, 0));
    }

    /// The simulator handed the answer over 20 us late. The client's reaction is as late, and none
    /// of it is its own.
    #[test]
    fn the_simulators_own_delay_is_not_the_clients() {
        let late = Delivery { at_ns: ANSWER_ENDED_NS + 20_000, late_ns: 20_000 };
        assert_eq!(DATING.start_ns(ANSWER_ENDED_NS + 75_000, late, ANSWER_ENDED_NS), ANSWER_ENDED_NS + 5_000);
        // An hour later it explains nothing.
        let later_ns = 3_600_000_000_000;
        assert_eq!(DATING.start_ns(later_ns, late, ANSWER_ENDED_NS), later_ns - 50_000);
    }

    #[test]
    fn no_more_is_taken_off_than_the_limit() {
        let late = Delivery { at_ns: ANSWER_ENDED_NS + 60_000, late_ns: 60_000 };
        assert_eq!(DATING.quiet_horizon_ns(ANSWER_ENDED_NS + 120_000, late), ANSWER_ENDED_NS + 40_000);
    }

    #[test]
    fn no_request_is_dated_into_what_has_been_simulated() {
        assert_eq!(DATING.start_ns(1_210_000, PUNCTUAL, 1_209_000), 1_209_000);
        assert_eq!(DATING.start_ns(10, PUNCTUAL, 0), 0);
    }
}
