//! A smooth correction of what no name fits: a term in the rate of pressure that depends on one
//! variable.
//!
//! The variable (drive, pressure, time, ...) is taken from the simulation without the correction,
//! so that the corrected simulation, too, needs nothing but drives or commands.

use serde::{Deserialize, Serialize};

use super::variable::{HATS, Variable, hats};
use crate::effects::Disturbance;
use crate::numeric::Scalar;

/// A term in the rate of pressure: a sum of hat functions of one variable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Correction {
    /// The variable.
    pub variable: Variable,
    /// Positions of the hats in the variable's own unit, ascending; beyond the ends the end's
    /// height holds.
    pub knots: Vec<f64>,
    /// Heights of the hats, kPa/s.
    pub heights: Vec<f64>,
}

impl Correction {
    /// Is it well formed: as many finite heights as ascending knots as a correction has?
    #[must_use]
    pub fn is_usable(&self) -> bool {
        let finite = self.knots.iter().chain(&self.heights).all(|v| v.is_finite());
        let ascending = self.knots.windows(2).all(|w| w[0] <= w[1]) && self.knots.first() < self.knots.last();
        finite && ascending && self.knots.len() == HATS && self.heights.len() == HATS
    }

    /// Its value over the interval that starts at each row, kPa/s; `values` are those of its
    /// variable as the model without it simulates them, row by row.
    #[must_use]
    pub fn rates(&self, values: &[f64]) -> Vec<f64> {
        let at = |v: &f64| hats(&self.knots, *v).iter().zip(&self.heights).map(|(w, h)| w * h).sum();
        values.iter().map(at).collect()
    }
}

/// Adds a correction's rates to a simulation that may be disturbed otherwise.
pub struct Corrected<'a, D> {
    /// The other disturbance.
    pub inner: &'a D,
    /// Rates over the interval that starts at each row, kPa/s; empty without a correction.
    pub rates: &'a [f64],
    /// Lengths of the intervals, s.
    pub interval_s: &'a [f64],
}

impl<S: Scalar, D: Disturbance<S>> Disturbance<S> for Corrected<'_, D> {
    #[inline]
    fn supply(&self, row: usize, supply: S) -> S {
        self.inner.supply(row, supply)
    }

    #[inline]
    fn pressure(&self, row: usize, pressure: S) -> S {
        let pressure = self.inner.pressure(row, pressure);
        match row.checked_sub(1) {
            Some(before) if !self.rates.is_empty() => {
                pressure.plus(1e3 * self.rates[before] * self.interval_s[before])
            }
            _ => pressure,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel;

    fn correction(heights: [f64; HATS]) -> Correction {
        Correction {
            variable: Variable::Drive,
            knots: vec![-0.7, -0.4, -0.1, 0.1, 0.3, 0.6],
            heights: heights.to_vec(),
        }
    }

    #[test]
    fn only_as_many_finite_heights_as_ascending_knots_are_usable() {
        let good = correction([1.0; HATS]);
        assert!(good.is_usable());
        let mut descending = good.clone();
        descending.knots.swap(0, 5);
        let mut infinite = good.clone();
        infinite.heights[2] = f64::NAN;
        let mut short = good.clone();
        short.heights.pop();
        let level = Correction { knots: vec![0.0; HATS], ..good };
        for wrong in [descending, infinite, short, level] {
            assert!(!wrong.is_usable(), "{wrong:?}");
        }
    }

    #[test]
    fn its_rate_is_the_height_at_a_knot_and_between_two_their_mean() {
        let (data, model) = channel(false);
        let mut trace = data.trace(&model);
        for (row, drive) in [(0, -0.4), (1, 0.2), (2, 0.9)] {
            trace[row][1] = drive;
        }
        let drive = data.series(&trace, Variable::Drive).unwrap();
        let rates = correction([0.0, 3.0, 0.0, 2.0, 4.0, 7.0]).rates(&drive);
        assert_eq!((rates[0], rates[2]), (3.0, 7.0));
        assert!((rates[1] - 3.0).abs() < 1e-12, "{}", rates[1]);
    }

    #[test]
    fn a_rate_fills_the_chamber_over_its_interval() {
        let (data, base) = channel(false);
        let mut model = base.clone();
        model.correction = Some(correction([2.0; HATS]));
        // 2 kPa/s over the 10 ms of row 0; what flows in row 0 does not know of it yet.
        let rise = data.trace(&model)[1][0] - data.trace(&base)[1][0];
        assert!((rise - 0.02).abs() < 1e-9, "{rise}");
    }
}
