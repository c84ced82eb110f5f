//! How long to sleep between looks at a line that holds fewer bytes than it can wake the host for.

/// Sleeps that grow from one character time to a limit: the rest of a packet is there soon, or not
/// at all.
#[derive(Debug, Clone)]
pub(super) struct Backoff {
    next_ns: u64,
}

impl Backoff {
    /// Bounds what a late byte can wait after it came.
    const LONGEST_NS: u64 = 200_000;
    /// A sleep and a look cost about this much; shorter backoff would be a busy-wait.
    const SHORTEST_NS: u64 = 20_000;

    pub(super) fn new(character_ns: u64) -> Self {
        Self { next_ns: character_ns.clamp(Self::SHORTEST_NS, Self::LONGEST_NS) }
    }

    /// End of the next sleep, ns, at most `deadline_ns`.
    pub(super) fn next_end(&mut self, now_ns: u64, deadline_ns: u64) -> u64 {
        let end = now_ns.saturating_add(self.next_ns).min(deadline_ns);
        self.next_ns = (2 * self.next_ns).min(Self::LONGEST_NS);
        end
    }
}

#[cfg(test)]
mod tests {
    use super::Backoff;

    #[test]
    fn sleeps_grow_to_a_limit_and_end_at_the_deadline() {
        let mut backoff = Backoff::new(10_000);
        let mut now = 0;
        let ends: Vec<_> = std::iter::from_fn(|| {
            let end = backoff.next_end(now, 900_000);
            (end > now).then(|| {
                now = end;
                end
            })
        })
        .collect();
        assert_eq!(ends, [20_000, 60_000, 140_000, 300_000, 500_000, 700_000, 900_000]);
    }
}
