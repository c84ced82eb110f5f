//! Means and straight lines with their standard errors.

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// The mean of the second members; `None` for fewer than three.
pub(crate) fn mean(points: &[(f64, f64)]) -> Option<Estimate> {
    let count = points.len() as f64;
    if points.len() < 3 {
        return None;
    }
    let mean = points.iter().map(|(_, y)| y).sum::<f64>() / count;
    let squares = points.iter().map(|(_, y)| (y - mean).powi(2)).sum::<f64>();
    Some(Estimate { value: mean, error: (squares / (count - 1.0) / count).sqrt() })
}

/// The standard deviation of the second members, with its standard error for normal noise.
pub(crate) fn deviation(points: &[(f64, f64)]) -> Option<Estimate> {
    let count = points.len() as f64;
    let value = mean(points)?.error * count.sqrt();
    Some(Estimate { value, error: value / (2.0 * (count - 1.0)).sqrt() })
}

/// The line of least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    /// Mean of the points.
    centre: (f64, f64),
    /// Standard error of the line at the centre.
    centre_error: f64,
    pub(crate) slope: Estimate,
}

impl Line {
    /// Through at least five points that are not all at one place.
    pub(crate) fn through(points: &[(f64, f64)]) -> Option<Self> {
        let count = points.len() as f64;
        if points.len() < 5 {
            return None;
        }
        let sum = points.iter().fold((0.0, 0.0), |sum, (x, y)| (sum.0 + x, sum.1 + y));
        let centre = (sum.0 / count, sum.1 / count);
        let (mut xx, mut xy) = (0.0, 0.0);
        for (x, y) in points {
            xx += (x - centre.0).powi(2);
            xy += (x - centre.0) * (y - centre.1);
        }
        // Written so that NaN is refused.
        if !(xx > 0.0) {
            return None;
        }
        let slope = xy / xx;
        let residual = |(x, y): &(f64, f64)| (y - centre.1 - slope * (x - centre.0)).powi(2);
        let variance = points.iter().map(residual).sum::<f64>() / (count - 2.0);
        Some(Self {
            centre,
            centre_error: (variance / count).sqrt(),
            slope: Estimate { value: slope, error: (variance / xx).sqrt() },
        })
    }

    /// Where it crosses a height.
    pub(crate) fn crosses(&self, y: Estimate) -> Estimate {
        let slope = self.slope.value;
        let rise = self.centre.1 - y.value;
        let error = (self.centre_error.powi(2) + y.error.powi(2)).sqrt() / slope.abs();
        let by_slope = rise / slope.powi(2) * self.slope.error;
        Estimate { value: self.centre.0 - rise / slope, error: error.hypot(by_slope) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Of many noisy lines, 95 % of the values are within 1.96 standard errors of the truth.
    #[test]
    fn standard_errors_are_as_large_as_errors_are() {
        let mut random = rand_pcg::Pcg32::seed_from_u64(7);
        let (mut slopes, mut crossings, mut means) = (0, 0, 0);
        for _ in 0..2_000 {
            // The sum of twelve uniform numbers is nearly normal, with a standard deviation of 1.
            let mut noise = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
            let points: Vec<_> =
                (0..40).map(|x| (f64::from(x), 20.0 + 3.0 * f64::from(x) + noise())).collect();
            let line = Line::through(&points).unwrap();
            let within =
                |estimate: Estimate, truth: f64| (estimate.value - truth).abs() < 1.96 * estimate.error;
            slopes += usize::from(within(line.slope, 3.0));
            crossings += usize::from(within(line.crosses(Estimate { value: 2.0, error: 0.0 }), -6.0));
            let flat: Vec<_> = (0..40).map(|x| (f64::from(x), 5.0 + noise())).collect();
            means += usize::from(within(mean(&flat).unwrap(), 5.0));
        }
        for hits in [slopes, crossings, means] {
            // 95 % +- four standard errors; Student's t of 38 degrees of freedom takes away half a
            // percent.
            assert!((1_850..=1_940).contains(&hits), "{slopes} {crossings} {means} of 2000");
        }
    }
}
