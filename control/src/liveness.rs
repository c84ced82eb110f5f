/// Whether everything that has to run does: what the watchdog hangs on.
///
/// Each part reports in as it works; [`all_since_last_asked`](Self::all_since_last_asked) is true only if every one of
/// them has done so since the question was last asked. One part that hangs, and the watchdog goes hungry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Liveness {
    control: bool,
    bus: bool,
}

impl Liveness {
    /// Nothing has reported yet.
    pub const fn new() -> Self {
        Self { control: false, bus: false }
    }

    /// The control loop has made a step.
    pub fn control_ran(&mut self) {
        self.control = true;
    }

    /// The bus responder has taken all bytes there were (maybe none) and waits for more.
    pub fn bus_ran(&mut self) {
        self.bus = true;
    }

    /// Whether every part has reported since this was last asked.
    pub fn all_since_last_asked(&mut self) -> bool {
        let all = self.control && self.bus;
        *self = Self::new();
        all
    }
}

#[cfg(test)]
mod tests {
    use super::Liveness;

    #[test]
    fn one_part_that_hangs_is_enough() {
        let mut liveness = Liveness::new();
        assert!(!liveness.all_since_last_asked());
        liveness.control_ran();
        assert!(!liveness.all_since_last_asked());
        // What was reported before the question does not count for the next one.
        liveness.bus_ran();
        assert!(!liveness.all_since_last_asked());
        liveness.bus_ran();
        liveness.control_ran();
        assert!(liveness.all_since_last_asked());
        assert!(!liveness.all_since_last_asked());
    }
}
