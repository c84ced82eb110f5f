use crate::sample::FineCounts;

/// First-order low-pass: new = (previous weight * old + (256 - previous weight) * sample) / 256.
///
/// It differs from the original's in two ways. It keeps the remainder of the division, so it
/// settles on exactly its input and not up to 5 counts below; and it starts at its first sample,
/// not at 0.
#[derive(Debug, Clone)]
pub(crate) struct LowPass {
    /// Weight of a new sample in 1/256.
    sample_weight: i32,
    /// 256 times the output, remainder included: below 2^26.
    accumulator: Option<i32>,
}

impl LowPass {
    const WEIGHT_BITS: u32 = 8;

    /// With the weight of the previous output in 1/256, 0 to 255.
    pub(crate) fn new(previous_weight: u8) -> Self {
        Self { sample_weight: (1 << Self::WEIGHT_BITS) - i32::from(previous_weight), accumulator: None }
    }

    /// Takes a sample, gives the new output.
    pub(crate) fn step(&mut self, sample: FineCounts) -> FineCounts {
        let accumulator = match self.accumulator {
            None => sample.raw() << Self::WEIGHT_BITS,
            // Stands still only where the output equals the sample: whatever else, the weight is at
            // least 1.
            Some(old) => old + self.sample_weight * (sample.raw() - (old >> Self::WEIGHT_BITS)),
        };
        self.accumulator = Some(accumulator);
        FineCounts::from_raw(accumulator >> Self::WEIGHT_BITS)
    }

    /// Forgets everything: the next sample starts it anew.
    pub(crate) fn reset(&mut self) {
        self.accumulator = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_protocol::Counts;

    fn fine(counts: u16) -> FineCounts {
        FineCounts::from_counts(Counts::new(counts).unwrap())
    }

    /// What the original computes, for comparison.
    fn original(old: u16, sample: u16) -> u16 {
        ((210 * u32::from(old) + 46 * u32::from(sample)) / 256) as u16
    }

    #[test]
    fn the_original_ends_five_counts_low_and_ours_does_not() {
        let (mut theirs, mut ours) = (102, LowPass::new(210));
        ours.step(fine(102));
        let mut output = fine(0);
        for _ in 0..200 {
            theirs = original(theirs, 500);
            output = ours.step(fine(500));
        }
        assert_eq!(theirs, 495);
        assert_eq!(output, fine(500));
    }

    /// Every step between two whole counts (in steps of 11 on one side to keep the test short),
    /// both ways.
    #[test]
    fn settles_exactly_after_every_step() {
        for from in (0..=1023).step_by(11) {
            for to in 0..=1023 {
                let mut filter = LowPass::new(210);
                filter.step(fine(from));
                let mut output = fine(from);
                for _ in 0..90 {
                    let next = filter.step(fine(to));
                    let (low, high) = (output.min(fine(to)), output.max(fine(to)));
                    assert!((low..=high).contains(&next), "overshoot from {from} to {to}");
                    output = next;
                }
                assert_eq!(output, fine(to), "from {from} to {to}");
            }
        }
    }

    #[test]
    fn starts_at_the_first_sample_also_after_a_reset() {
        let mut filter = LowPass::new(210);
        assert_eq!(filter.step(fine(511)), fine(511));
        filter.reset();
        assert_eq!(filter.step(fine(200)), fine(200));
    }

    #[test]
    fn has_the_originals_time_constant_of_five_steps() {
        let mut filter = LowPass::new(210);
        filter.step(fine(0));
        let mut output = fine(0);
        for _ in 0..5 {
            output = filter.step(fine(1000));
        }
        // 1000 (1 - (210/256)^5) = 628.55
        assert!((output.raw() - 160_908).abs() <= 2, "{output:?}");
    }

    #[test]
    fn weight_zero_passes_everything_and_255_settles_too() {
        let mut open = LowPass::new(0);
        open.step(fine(0));
        assert_eq!(open.step(fine(1023)), fine(1023));
        let mut slow = LowPass::new(255);
        slow.step(fine(1023));
        let last = (0..10_000).map(|_| slow.step(fine(3))).last();
        assert_eq!(last, Some(fine(3)));
    }
}
