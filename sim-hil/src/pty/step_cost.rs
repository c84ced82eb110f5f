/// How long a part of the plant's work takes on this machine: with four chambers a few us, with
/// sixteen about 20 us.
///
/// Work that is begun too late delays an answer. What the last part took is a good guess of the
/// next; when nothing is known, it is guessed long.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepCost {
    guess_ns: u64,
}

impl Default for StepCost {
    fn default() -> Self {
        Self { guess_ns: Self::LONGEST_NS }
    }
}

impl StepCost {
    /// What takes longer was interrupted, ns.
    const LONGEST_NS: u64 = 40_000;

    /// Whether another part can be done in `left_ns`, with as much to spare.
    pub fn fits(self, left_ns: u64) -> bool {
        left_ns > 2 * self.guess_ns
    }

    /// A part took so long.
    pub fn took(&mut self, ns: u64) {
        let ns = ns.min(Self::LONGEST_NS);
        // Long ones count at once, short ones bit by bit.
        self.guess_ns = if ns > self.guess_ns { ns } else { self.guess_ns - (self.guess_ns - ns) / 8 };
    }
}

#[cfg(test)]
mod tests {
    use super::StepCost;

    #[test]
    fn work_is_begun_where_it_fits() {
        let mut step_cost = StepCost::default();
        assert!(step_cost.fits(100_000) && !step_cost.fits(80_000));
        (0..100).for_each(|_| step_cost.took(5_000));
        assert!(step_cost.fits(11_000) && !step_cost.fits(10_000));
        step_cost.took(20_000);
        assert!(!step_cost.fits(40_000), "a long one counts at once");
        step_cost.took(5_000_000);
        assert!(step_cost.fits(81_000), "the scheduler's pauses are no work");
    }
}
