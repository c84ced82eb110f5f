//! The measured pressure's derivative.

use std::ops::Range;

use crate::model::column;
use crate::rollout::Series;

/// Smoothed pressure and its derivative in the middle of one sample interval, where the inputs are
/// constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// The row whose inputs hold in the interval.
    pub row: usize,
    /// Index of the segment.
    pub segment: usize,
    /// Absolute pressure, Pa.
    pub pressure_pa: f64,
    /// Its rate, Pa/s.
    pub rate_pa_s: f64,
}

/// Smoothing derivative after Savitzky and Golay (1964) in the middle of each sample interval: a
/// parabola through the `half_width` samples before and after it, by least squares. With
/// `half_width` 1 it is the difference quotient. Windows that leave a segment or touch a masked
/// sample are left out.
///
/// An odd window, centred on a sample, would straddle two values of a drive that changes at the
/// sample.
#[must_use]
pub fn slopes(series: &Series, half_width: usize) -> Vec<Slope> {
    let half_width = half_width.max(1);
    let window = Window::new(half_width);
    let mut slopes = Vec::with_capacity(series.len());
    for (segment, range) in series.segments().iter().enumerate() {
        let Range { start, end } = *range;
        for row in (start + half_width - 1)..(end - 1).saturating_sub(half_width - 1) {
            let samples = row + 1 - half_width..row + 1 + half_width;
            if series.weights()[samples.clone()].iter().any(|&weight| weight <= 0.0) {
                continue;
            }
            let (first, last) = (series.row(samples.start), series.row(samples.end - 1));
            #[allow(clippy::cast_precision_loss)] // a window is short
            let spacing = (last[column::TIME_S] - first[column::TIME_S]) / (2 * half_width - 1) as f64;
            let (pressure_pa, rise_pa) = window.fit(&series.measured()[samples]);
            slopes.push(Slope { row, segment, pressure_pa, rate_pa_s: rise_pa / spacing });
        }
    }
    slopes
}

/// Least-squares parabola through samples at -m + 1/2, ..., -1/2, 1/2, ..., m - 1/2.
struct Window {
    positions: Vec<f64>,
    /// Weights of the value at 0.
    value: Vec<f64>,
    /// Weights of the slope at 0, per sample.
    slope: Vec<f64>,
}

impl Window {
    fn new(half_width: usize) -> Self {
        #[allow(clippy::cast_precision_loss)] // a window is short
        let positions: Vec<f64> = (0..2 * half_width).map(|i| i as f64 + 0.5 - half_width as f64).collect();
        let moment = |power: i32| positions.iter().map(|x| x.powi(power)).sum::<f64>();
        let (count, second, fourth) = (moment(0), moment(2), moment(4));
        // Normal equations of a + b x + c x^2 with the odd moments zero; two samples determine no
        // curvature.
        let determinant = count * fourth - second * second;
        let value = |x: &f64| {
            if half_width == 1 { 1.0 / count } else { (fourth - second * x * x) / determinant }
        };
        Self {
            value: positions.iter().map(value).collect(),
            slope: positions.iter().map(|x| x / second).collect(),
            positions,
        }
    }

    /// Value and slope per sample in the middle of the window.
    fn fit(&self, samples: &[f64]) -> (f64, f64) {
        debug_assert_eq!(samples.len(), self.positions.len());
        let sum = |weights: &[f64]| weights.iter().zip(samples).map(|(w, p)| w * p).sum::<f64>();
        (sum(&self.value), sum(&self.slope))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_reproduced_exactly() {
        for half_width in [2, 3, 5] {
            let window = Window::new(half_width);
            let parabola = |x: &f64| 7.0 + 3.0 * x - 0.5 * x * x;
            let samples: Vec<f64> = window.positions.iter().map(parabola).collect();
            let (value, slope) = window.fit(&samples);
            assert!(
                (value - 7.0).abs() < 1e-12 && (slope - 3.0).abs() < 1e-12,
                "{half_width}: {value} {slope}"
            );
        }
    }

    #[test]
    fn two_samples_give_their_mean_and_difference() {
        assert_eq!(Window::new(1).fit(&[2.0, 5.0]), (3.5, 3.0));
    }
}
