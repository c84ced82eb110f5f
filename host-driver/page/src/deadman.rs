//! Deadman mode: set points vent when the operator's page is gone.
//!
//! The page of whoever commands says ten times within the limit that it is there, as long as it is
//! visible. A page that is closed, hidden, frozen or out of reach says nothing, and after the limit
//! all boards vent. Time is an argument: any clock that starts at any time.

use std::time::Duration;

/// The limit where the operator asks for the mode on the page.
const LIMIT: Duration = Duration::from_secs(3);

/// Watches the operator's page.
#[derive(Debug)]
pub(crate) struct Deadman {
    limit: Duration,
    required: bool,
    operator: Option<Operator>,
}

#[derive(Debug)]
struct Operator {
    /// The name that the page has given itself.
    page: String,
    heard: Duration,
}

impl Deadman {
    /// With a limit, whoever gives a set point is watched. Without one, whoever asks for it.
    pub(crate) fn new(required: Option<Duration>) -> Self {
        Self { limit: required.unwrap_or(LIMIT), required: required.is_some(), operator: None }
    }

    /// How long a page may be silent.
    pub(crate) fn limit(&self) -> Duration {
        self.limit
    }

    /// Whether nobody can command without being watched.
    pub(crate) fn is_required(&self) -> bool {
        self.required
    }

    /// Whether somebody is watched.
    pub(crate) fn is_armed(&self) -> bool {
        self.operator.is_some()
    }

    /// From now on this page is the operator's.
    pub(crate) fn arm(&mut self, page: &str, now: Duration) {
        self.operator = Some(Operator { page: page.to_owned(), heard: now });
    }

    /// Ends the mode, if this page is the operator's. Returns whether the page is still watched:
    /// where the mode is required, it is.
    pub(crate) fn disarm(&mut self, page: &str) -> bool {
        if !self.required && self.is_operator(page) {
            self.operator = None;
        }
        self.is_operator(page)
    }

    /// The page is there. Returns whether it is the operator's.
    pub(crate) fn heartbeat(&mut self, page: &str, now: Duration) -> bool {
        match &mut self.operator {
            Some(operator) if operator.page == page => {
                operator.heard = now;
                true
            }
            _ => false,
        }
    }

    /// The page has given a set point; a script has no name and gives an empty one.
    pub(crate) fn commanded(&mut self, page: &str, now: Duration) {
        // Where somebody is watched, whoever commands last is the operator.
        if self.required || self.operator.is_some() {
            self.arm(page, now);
        }
    }

    /// To be asked often. `Some` if everything is to be vented, with the time for which the
    /// operator's page has been silent. `vented`: whether it is vented already, which leaves
    /// nothing to watch.
    pub(crate) fn check(&mut self, now: Duration, vented: bool) -> Option<Duration> {
        let silent = now.saturating_sub(self.operator.as_ref()?.heard);
        let gone = silent >= self.limit && !vented;
        if gone || vented {
            self.operator = None;
        }
        gone.then_some(silent)
    }

    fn is_operator(&self, page: &str) -> bool {
        self.operator.as_ref().is_some_and(|operator| operator.page == page)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn a_silent_page_vents_once_and_not_before_its_time() {
        let mut deadman = Deadman::new(None);
        assert_eq!(deadman.check(ms(1_000_000), false), None, "nobody has asked for it");
        deadman.arm("one", ms(0));
        for beat in 1..100 {
            assert!(deadman.heartbeat("one", ms(beat * 300)));
            assert_eq!(deadman.check(ms(beat * 300 + 299), false), None);
        }
        let last = 99 * 300;
        assert_eq!(deadman.check(ms(last + 2_999), false), None);
        assert_eq!(deadman.check(ms(last + 3_000), false), Some(ms(3_000)));
        assert_eq!(deadman.check(ms(last + 9_000), false), None, "once");
        assert!(!deadman.heartbeat("one", ms(last + 9_001)), "what is vented needs to be armed again");
    }

    #[test]
    fn other_pages_do_not_keep_it_alive() {
        let mut deadman = Deadman::new(Some(ms(1_000)));
        deadman.commanded("one", ms(0));
        assert!(!deadman.heartbeat("other", ms(900)));
        assert_eq!(deadman.check(ms(1_000), false), Some(ms(1_000)));
    }

    #[test]
    fn whoever_commands_last_is_the_operator() {
        let mut deadman = Deadman::new(None);
        deadman.commanded("one", ms(0));
        assert!(!deadman.is_armed(), "nobody has asked for it");
        deadman.arm("one", ms(0));
        deadman.commanded("other", ms(2_000));
        assert!(!deadman.heartbeat("one", ms(2_900)));
        assert_eq!(deadman.check(ms(4_999), false), None);
        assert_eq!(deadman.check(ms(5_000), false), Some(ms(3_000)));
    }

    #[test]
    fn a_required_deadman_cannot_be_put_off() {
        let mut deadman = Deadman::new(Some(ms(500)));
        deadman.commanded("", ms(0));
        assert!(deadman.disarm(""), "also for a script");
        assert_eq!(deadman.check(ms(500), false), Some(ms(500)));
        let mut free = Deadman::new(None);
        free.arm("one", ms(0));
        assert!(!free.disarm("other") && free.is_armed(), "that is for its own page to do");
        assert!(!free.disarm("one") && !free.is_armed());
        assert_eq!(free.check(ms(60_000), false), None);
    }

    #[test]
    fn what_is_vented_needs_no_watching() {
        let mut deadman = Deadman::new(Some(ms(500)));
        deadman.commanded("one", ms(0));
        assert_eq!(deadman.check(ms(100), true), None);
        assert_eq!(deadman.check(ms(900), false), None, "released at 0 kPa, nothing set since");
    }
}
