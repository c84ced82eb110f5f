//! What an effect remembers from one step to the next.

use crate::numeric::Scalar;

/// A number that is known from the first step on. Not an [`Option`]: its tag in front of a vector
/// of numbers puts them where no register's load meets its store, which costs more than the effect.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Remembered<S> {
    value: S,
    known: bool,
}

impl<S: Scalar> Remembered<S> {
    /// Nothing yet.
    pub fn nothing() -> Self {
        Self { value: S::zero(), known: false }
    }

    /// The number, or another before the first step.
    #[inline(always)]
    pub fn or(&self, before: S) -> S {
        if self.known { self.value } else { before }
    }

    /// Remembers a number.
    #[inline(always)]
    pub fn set(&mut self, value: S) {
        self.value = value;
        self.known = true;
    }

    /// The number, if it is known.
    pub fn known(&mut self) -> Option<&mut S> {
        self.known.then_some(&mut self.value)
    }
}

/// What a first-order lag forgets in a step. The steps between two rows have the same length, and
/// an exponential costs as much as the rest of an effect.
#[derive(Debug, Clone, Copy)]
pub struct Forgetting<S> {
    /// Length of the step that it holds for, s.
    length_s: f64,
    /// Time constant over the step's length.
    ratio: S,
    /// The part that is left at the end of the step.
    rest: S,
}

impl<S: Scalar> Forgetting<S> {
    /// Of no step yet.
    pub fn new() -> Self {
        Self { length_s: 0.0, ratio: S::zero(), rest: S::zero() }
    }

    /// Time constant over length, at least 0.001, and the part that is left, for a lag (s) over a
    /// step (s).
    #[inline(always)]
    pub fn over(&mut self, time_constant_s: S, length_s: f64) -> (S, S) {
        if self.length_s.to_bits() != length_s.to_bits() {
            self.ratio = time_constant_s.times(1.0 / length_s).max(S::constant(1e-3));
            self.rest = (-self.ratio.recip()).exp();
            self.length_s = length_s;
        }
        (self.ratio, self.rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_known_once_it_was_set() {
        let mut number = Remembered::<f64>::nothing();
        assert!(number.known().is_none());
        assert_eq!(number.or(3.0), 3.0);
        number.set(0.0);
        assert_eq!((number.or(3.0), number.known().copied()), (0.0, Some(0.0)));
    }

    #[test]
    fn what_is_left_follows_the_length_of_the_step() {
        let mut forgetting = Forgetting::<f64>::new();
        for length_s in [0.01, 0.01, 0.0025, 0.0025, 0.01] {
            let (ratio, rest) = forgetting.over(0.02, length_s);
            assert!((ratio - 0.02 / length_s).abs() < 1e-12, "{length_s}: {ratio}");
            assert!((rest - (-length_s / 0.02_f64).exp()).abs() < 1e-12, "{length_s}: {rest}");
        }
        // No lag at all leaves nothing, and divides by nothing.
        assert_eq!(Forgetting::<f64>::new().over(0.0, 0.01), (1e-3, 0.0));
    }
}
