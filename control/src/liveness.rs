/// Whether everything that has to run does: what the watchdog hangs on.
///
/// Each part reports in as it works; [`take`](Self::take) gives the reports since it was last
/// called, and the watchdog is fed only if [`all`](Self::all) parts are among them.
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

    /// What has reported since this was last asked.
    pub fn take(&mut self) -> Self {
        core::mem::take(self)
    }

    /// Whether the control loop has made a step.
    pub const fn control_has_run(self) -> bool {
        self.control
    }

    /// Whether the bus responder has run.
    pub const fn bus_has_run(self) -> bool {
        self.bus
    }

    /// Whether every part has reported.
    pub const fn all(self) -> bool {
        self.control && self.bus
    }
}

#[cfg(test)]
mod tests {
    use super::Liveness;

    #[test]
    fn one_part_that_hangs_is_enough() {
        let mut liveness = Liveness::new();
        assert!(!liveness.take().all());
        liveness.control_ran();
        assert!(!liveness.take().all());
        // What was reported before the question does not count for the next one.
        liveness.bus_ran();
        assert!(!liveness.take().all());
        liveness.bus_ran();
        liveness.control_ran();
        assert!(liveness.take().all());
        assert!(!liveness.take().all());
    }
}
