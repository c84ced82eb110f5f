/// How soon a board's answer is complete after its request, as a rule: the lower edge of what was
/// seen lately.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct UsualDelay {
    ns: Option<u64>,
}

impl UsualDelay {
    /// ns; `None` before the first answer.
    pub(super) fn ns(self) -> Option<u64> {
        self.ns
    }

    /// An answer was complete so long after its request, ns. Shorter ones count at once, longer
    /// ones bit by bit.
    pub(super) fn seen(&mut self, delay_ns: u64) {
        let usual_ns = self.ns.unwrap_or(delay_ns);
        self.ns = Some(delay_ns.min(usual_ns + delay_ns.saturating_sub(usual_ns) / 64));
    }
}

#[cfg(test)]
mod tests {
    use super::UsualDelay;

    #[test]
    fn it_follows_a_board_down_at_once_and_up_slowly() {
        let mut usual = UsualDelay::default();
        assert_eq!(usual.ns(), None);
        usual.seen(230_000);
        assert_eq!(usual.ns(), Some(230_000));
        usual.seen(5_000_000);
        assert!(usual.ns().is_some_and(|ns| ns < 310_000));
        usual.seen(215_000);
        assert_eq!(usual.ns(), Some(215_000));
        (0..500).for_each(|_| usual.seen(400_000));
        assert!(usual.ns().is_some_and(|ns| ns > 399_000));
    }
}
