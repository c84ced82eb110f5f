//! How often a board is asked for pages between two polls.

use thiserror::Error;

/// After which share of the polls a board is asked for a page as well: above 0, at most 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PageShare(f64);

/// A number that is no such share.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("expected a share of the polls above 0 and at most 1, got {0}")]
pub struct PageShareError(
    /// The number.
    pub f64,
);

impl PageShare {
    /// # Errors
    /// Not above 0, or above 1.
    pub fn new(share: f64) -> Result<Self, PageShareError> {
        if share > 0.0 && share <= 1.0 { Ok(Self(share)) } else { Err(PageShareError(share)) }
    }

    /// The number.
    pub fn get(self) -> f64 {
        self.0
    }

    /// Exact for shares such as 0.1, whose sums are not exact in floating point.
    fn millionths(self) -> u32 {
        ((self.0 * 1e6).round() as u32).max(1)
    }
}

/// Decides for one board and one sort of pages.
#[derive(Debug, Clone)]
pub(super) struct PageSchedule {
    share: Option<PageShare>,
    /// Polls that have not been followed by such a request, weighted by the share, in millionths:
    /// at a million one is due.
    credit: u32,
    /// Requests beyond one that a poll was followed by: as many are left out.
    debt: u32,
    /// Requests in a row without an entry.
    failures: u32,
    /// It has answered such a request.
    known: bool,
    not_before_ns: u64,
    told: bool,
}

impl PageSchedule {
    const DUE: u32 = 1_000_000;
    /// Failures in a row after which a board that has never answered gets pauses: its firmware may
    /// be of before such pages, and each request costs a timeout.
    const FAILURES: u32 = 3;
    /// The same for one that has: on a noisy line three in a row are lost now and then.
    const FAILURES_OF_KNOWN: u32 = 100;
    /// The pause, ns: a timeout of 2.2 ms in it is 0.2 % of the bus's time.
    pub(super) const PAUSE_NS: u64 = 1_000_000_000;

    pub(super) fn new(share: Option<PageShare>) -> Self {
        // The first poll is followed by one.
        Self { share, credit: Self::DUE, debt: 0, failures: 0, known: false, not_before_ns: 0, told: false }
    }

    /// The board has answered a poll: whether it is to be asked for a page now.
    pub(super) fn due(&mut self, now_ns: u64) -> bool {
        let Some(share) = self.share else { return false };
        let due = self.credit >= Self::DUE;
        // What falls into a pause is not made up for.
        self.credit = self.credit % Self::DUE + share.millionths();
        if due && self.debt > 0 {
            self.debt -= 1;
            return false;
        }
        due && now_ns >= self.not_before_ns
    }

    /// It was asked for one page more than was due.
    pub(super) fn asked_for_more(&mut self) {
        self.debt += 1;
    }

    pub(super) fn answered(&mut self) {
        self.failures = 0;
        self.known = true;
    }

    /// It has nothing to tell, for a while.
    pub(super) fn pause(&mut self, now_ns: u64) {
        self.not_before_ns = now_ns + Self::PAUSE_NS;
    }

    /// Whether it is worth telling: once a run.
    pub(super) fn failed(&mut self, now_ns: u64) -> bool {
        self.failures = self.failures.saturating_add(1);
        if self.failures < if self.known { Self::FAILURES_OF_KNOWN } else { Self::FAILURES } {
            return false;
        }
        self.known = false;
        self.pause(now_ns);
        !std::mem::replace(&mut self.told, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn due(share: f64, polls: u64) -> Vec<u64> {
        let mut schedule = PageSchedule::new(Some(PageShare::new(share).unwrap()));
        (0..polls).filter(|&poll| schedule.due(poll)).collect()
    }

    #[test]
    fn the_share_is_kept_from_the_first_poll_on() {
        assert_eq!(due(1.0, 4), [0, 1, 2, 3]);
        assert_eq!(due(0.5, 6), [0, 2, 4]);
        assert_eq!(due(0.25, 9), [0, 4, 8]);
        assert_eq!(due(0.3, 1_000).len(), 300);
    }

    /// Two pages after one poll: the next time that one is due it is left out.
    #[test]
    fn two_pages_at_once_take_no_more_of_the_bus() {
        let mut schedule = PageSchedule::new(Some(PageShare::new(0.25).unwrap()));
        let mut pages = 0;
        for poll in 0..1_000 {
            if schedule.due(poll) {
                pages += 2;
                schedule.asked_for_more();
            }
        }
        assert_eq!(pages, 250);
    }

    #[test]
    fn without_a_share_nothing_is_asked() {
        let mut schedule = PageSchedule::new(None);
        assert!((0..10).all(|poll| !schedule.due(poll)));
    }

    #[test]
    fn shares_that_are_none_are_refused() {
        for share in [0.0, -0.1, 1.01, f64::NAN, f64::INFINITY] {
            assert!(PageShare::new(share).is_err(), "{share}");
        }
    }

    #[test]
    fn a_board_without_pages_is_asked_once_a_second_and_told_once() {
        let mut schedule = PageSchedule::new(Some(PageShare::new(1.0).unwrap()));
        let mut asked = Vec::new();
        let mut told = Vec::new();
        for now_ns in (0..3_500_000_000).step_by(1_000_000) {
            if schedule.due(now_ns) {
                asked.push(now_ns / 1_000_000);
                if schedule.failed(now_ns) {
                    told.push(now_ns / 1_000_000);
                }
            }
        }
        assert_eq!((asked, told), (vec![0, 1, 2, 1_002, 2_002, 3_002], vec![2]));
    }

    /// Another board in its place gets its pauses, too, but later.
    #[test]
    fn a_board_that_has_told_its_drives_is_asked_on_through_noise() {
        let mut schedule = PageSchedule::new(Some(PageShare::new(1.0).unwrap()));
        schedule.answered();
        for now_ns in 0..99 {
            assert!(schedule.due(now_ns) && !schedule.failed(now_ns), "after {now_ns} failures");
        }
        assert!(schedule.due(99) && schedule.failed(99));
        assert!(!schedule.due(100) && !schedule.due(1_000_000_098) && schedule.due(1_000_000_099));
    }
}
