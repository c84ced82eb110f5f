/// When a request began on the wire, judged by when the simulator saw it.
///
/// A pure function of its arguments; the module's front page says why it dates back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RequestDating {
    /// Median round trip of the pty, ns: what is taken off.
    pub round_trip_ns: u64,
}

impl RequestDating {
    /// The start of bytes seen at `seen_ns`, on a bus that has been simulated up to `simulated_ns`.
    ///
    /// Whatever was on the wire has ended by `simulated_ns`, or it is still there and the bytes fall into it: in
    /// either case nothing before that time can be changed.
    pub fn start_ns(self, seen_ns: u64, simulated_ns: u64) -> u64 {
        seen_ns.saturating_sub(self.round_trip_ns).max(simulated_ns)
    }

    /// How far a quiet bus may be simulated at `now_ns`, so that a request that is under way can still be dated back.
    pub fn quiet_horizon_ns(self, now_ns: u64) -> u64 {
        now_ns.saturating_sub(self.round_trip_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::RequestDating;

    const DATING: RequestDating = RequestDating { round_trip_ns: 50_000 };

    /// A client that answers an answer at once is on the wire at once: cycles are as long as the wire makes them.
    #[test]
    fn a_reaction_within_the_round_trip_costs_nothing() {
        let answer_ended_ns = 1_215_000;
        assert_eq!(DATING.start_ns(answer_ended_ns + 40_000, answer_ended_ns), answer_ended_ns);
        assert_eq!(DATING.start_ns(answer_ended_ns + 50_000, answer_ended_ns), answer_ended_ns);
    }

    #[test]
    fn what_goes_beyond_is_charged_once() {
        assert_eq!(DATING.start_ns(1_300_000, 1_215_000), 1_250_000);
        // A quiet bus is never simulated beyond the date of a request that may still come.
        assert_eq!(DATING.quiet_horizon_ns(1_300_000), DATING.start_ns(1_300_000, 0));
    }

    #[test]
    fn no_request_is_dated_into_what_has_been_simulated() {
        assert_eq!(DATING.start_ns(1_210_000, 1_209_000), 1_209_000);
        assert_eq!(DATING.start_ns(10, 0), 0);
    }
}
