//! Looking for bytes without sleeping, where a wake-up would cost more than it saves.

use std::time::Duration;

/// Whether a port's thread looks for bytes without sleeping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spin {
    /// It sleeps until the kernel wakes it.
    #[default]
    Never,
    /// It looks for this long before each sleep.
    BeforeSleep(Duration),
    /// On the first 3072 answers it tries three ways in turn: to sleep, to sleep until shortly
    /// before an answer is due and look from then on, and to look all the time. It keeps the one
    /// with which answers come soonest; a dearer one has to save 1 %. After 65,536 answers it asks
    /// again, on 1536.
    Auto,
}

/// How long before an answer is due the thread has to be woken, learnt from how late it was woken
/// before.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lead {
    ns: u64,
}

impl Default for Lead {
    fn default() -> Self {
        Self { ns: 30_000 }
    }
}

impl Lead {
    /// A sleep that ends later than this was another program's doing, ns.
    const LONGEST_NS: u64 = 100_000;
    /// Reading the clock and looking once, ns.
    const SHORTEST_NS: u64 = 3_000;
    /// How long an answer is looked for after it was due, before the thread sleeps, ns.
    pub(super) const AFTER_NS: u64 = 60_000;

    pub(super) fn ns(self) -> u64 {
        self.ns
    }

    /// A sleep ended so late, ns. The lead settles where one sleep in nine ends later.
    pub(super) fn woke(&mut self, late_ns: u64) {
        let late_ns = late_ns.clamp(Self::SHORTEST_NS, Self::LONGEST_NS);
        let step_ns = self.ns / 64 + 1;
        self.ns = if late_ns > self.ns { self.ns + 8 * step_ns } else { self.ns - step_ns };
        self.ns = self.ns.clamp(Self::SHORTEST_NS, Self::LONGEST_NS);
    }
}

#[cfg(test)]
mod tests {
    use super::Lead;

    #[test]
    fn the_lead_settles_where_one_sleep_in_nine_ends_later() {
        let mut lead = Lead::default();
        // 0 to 39.6 us late, evenly.
        let late_ns = |n: u64| (n * 37 % 100) * 400;
        let mut later = 0;
        for n in 0..10_000 {
            later += u64::from(n >= 1_000 && late_ns(n) > lead.ns());
            lead.woke(late_ns(n));
        }
        assert!((800..1_200).contains(&later), "{later} of 9000 sleeps ended later than the lead");
        assert!((30_000..40_000).contains(&lead.ns()), "{}", lead.ns());
    }

    #[test]
    fn one_pause_of_the_machine_does_not_count_for_more_than_its_share() {
        let mut lead = Lead::default();
        (0..1_000).for_each(|_| lead.woke(5_000));
        lead.woke(50_000_000);
        assert!(lead.ns() < 10_000, "{}", lead.ns());
    }
}
