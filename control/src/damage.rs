use crate::{BoardConfig, Micros};

/// Counts damaged requests; too many in a window latch.
///
/// A window begins with the first damaged request after the window before it. What comes damaged
/// says nothing of what goes through unnoticed, but bounds it: of 65,536 requests that random
/// damage hits, one at the most is obeyed.
#[derive(Debug, Clone)]
pub(crate) struct DamageMonitor {
    limit: u16,
    window: Micros,
    began: Micros,
    count: u16,
    latched: bool,
}

impl DamageMonitor {
    pub(crate) fn new(config: &BoardConfig) -> Self {
        Self::with(config.damage_limit, config.damage_window)
    }

    /// So many in this time are too many.
    pub(crate) fn with(limit: u16, window: Micros) -> Self {
        Self { limit, window, began: Micros::ZERO, count: 0, latched: false }
    }

    /// A damaged request was heard at `now`.
    pub(crate) fn damaged(&mut self, now: Micros) {
        if self.count == 0 || now.since(self.began) >= self.window {
            self.began = now;
            self.count = 0;
        }
        self.count = self.count.saturating_add(1);
        self.latched |= self.count >= self.limit;
    }

    /// The host leaves: whoever comes next knows what has happened.
    pub(crate) fn release(&mut self) {
        self.count = 0;
        self.latched = false;
    }

    pub(crate) fn latched(&self) -> bool {
        self.latched
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monitor() -> DamageMonitor {
        let config =
            BoardConfig { damage_limit: 3, damage_window: Micros::from_millis(10), ..BoardConfig::default() };
        DamageMonitor::new(&config)
    }

    #[test]
    fn too_many_in_a_window_latch() {
        let mut monitor = monitor();
        for (at_ms, latched) in [(5, false), (14, false), (15, false), (16, false), (24, true), (500, true)] {
            monitor.damaged(Micros::from_millis(at_ms));
            assert_eq!(monitor.latched(), latched, "at {at_ms} ms");
        }
        monitor.release();
        assert!(!monitor.latched());
        monitor.damaged(Micros::from_millis(501));
        assert!(!monitor.latched());
    }

    #[test]
    fn a_few_now_and_then_do_not() {
        let mut monitor = monitor();
        for at_ms in (0..1_000).step_by(6) {
            monitor.damaged(Micros::from_millis(at_ms));
        }
        assert!(!monitor.latched());
    }
}
