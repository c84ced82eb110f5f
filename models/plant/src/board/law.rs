//! The law of a board's controller.

use crate::numeric::Scalar;

/// A low-pass filter, and proportional and derivative action on what it gives. The gains say in
/// which units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// Drive per error.
    pub gain: f64,
    /// Drive per change between two loops.
    pub damping: f64,
    /// Weight of the previous filtered sample, 0 (no filter) to below 1.
    pub weight: f64,
}

impl Law {
    /// The filtered sample after one more.
    #[inline(always)]
    pub fn filtered<S: Scalar>(&self, sample: S, previous: S) -> S {
        previous.times(self.weight) + sample.times(1.0 - self.weight)
    }

    /// The drive, not limited, when the filtered sample was `previous` a loop before.
    #[inline(always)]
    pub fn drive<S: Scalar>(&self, command: S, filtered: S, previous: S) -> S {
        (command - filtered).times(self.gain) - (filtered - previous).times(self.damping)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_drive_answers_to_the_error_and_brakes_by_the_change() {
        let law = Law { gain: 10.0, damping: 20.0, weight: 0.75 };
        let filtered = law.filtered(108.0, 100.0);
        assert!((filtered - 102.0).abs() < 1e-12);
        // 10 (110 - 102) - 20 (102 - 100)
        assert!((law.drive(110.0, filtered, 100.0) - 40.0).abs() < 1e-12);
        let plain = Law { weight: 0.0, ..law };
        assert_eq!(plain.filtered(108.0, 100.0), 108.0);
    }
}
