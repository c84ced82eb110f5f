//! How late the answers of a board really are.

/// The times from request to answer that a board keeps to: those of its last 500 to 1000 answers,
/// and of 100 at least.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Delays {
    current: Range,
    before: Option<Range>,
}

/// When an answer to a request can come, ns after the request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    /// Not before this.
    pub from_ns: u64,
    /// Not after this.
    pub to_ns: u64,
}

impl Window {
    pub(super) fn contains(self, delay_ns: u64) -> bool {
        (self.from_ns..=self.to_ns).contains(&delay_ns)
    }
}

#[derive(Debug, Clone, Copy)]
struct Range {
    answers: u32,
    shortest_ns: u64,
    longest_ns: u64,
}

impl Default for Range {
    fn default() -> Self {
        Self { answers: 0, shortest_ns: u64::MAX, longest_ns: 0 }
    }
}

impl Delays {
    /// So many answers tell enough.
    const ENOUGH: u32 = 100;
    /// After so many the ones before them are forgotten.
    const KEPT: u32 = 500;
    /// What is added to both ends, besides a quarter of the longest delay to the far one: the
    /// scheduler, and what few answers show.
    const MARGIN_NS: u64 = 200_000;

    /// An answer came so long after its request.
    pub(super) fn seen(&mut self, delay_ns: u64) {
        self.current.answers += 1;
        self.current.shortest_ns = self.current.shortest_ns.min(delay_ns);
        self.current.longest_ns = self.current.longest_ns.max(delay_ns);
        if self.current.answers == Self::KEPT {
            self.before = Some(std::mem::take(&mut self.current));
        }
    }

    /// An answer came too late to be believed, so long after its request.
    pub(super) fn seen_late(&mut self, delay_ns: u64) {
        self.current.longest_ns = self.current.longest_ns.max(delay_ns);
    }

    /// When answers come; `None` until enough have been seen.
    pub(super) fn window(&self) -> Option<Window> {
        let before = match self.before {
            Some(before) => before,
            None if self.current.answers >= Self::ENOUGH => self.current,
            None => return None,
        };
        let shortest_ns = before.shortest_ns.min(self.current.shortest_ns);
        let longest_ns = before.longest_ns.max(self.current.longest_ns);
        Some(Window {
            from_ns: shortest_ns.saturating_sub(Self::MARGIN_NS),
            to_ns: longest_ns + longest_ns / 4 + Self::MARGIN_NS,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_thousand_answers_count() {
        let mut delays = Delays::default();
        delays.seen(1_060_000);
        (1..99).for_each(|_| delays.seen(300_000));
        assert_eq!(delays.window(), None);
        delays.seen(300_000);
        assert_eq!(delays.window(), Some(Window { from_ns: 100_000, to_ns: 1_525_000 }));
        (100..500).for_each(|_| delays.seen(300_000));
        assert_eq!(delays.window(), Some(Window { from_ns: 100_000, to_ns: 1_525_000 }));
        (0..499).for_each(|_| delays.seen(400_000));
        assert_eq!(delays.window().map(|window| window.to_ns), Some(1_525_000));
        delays.seen(400_000);
        assert_eq!(delays.window(), Some(Window { from_ns: 200_000, to_ns: 700_000 }));
        delays.seen_late(3_200_000);
        assert_eq!(delays.window().map(|window| window.to_ns), Some(4_200_000));
    }
}
