//! Residuals in standard deviations of the noise, and what blocks leave of them.

use super::covariance::Whitening;
use crate::diagnosis::channel::ChannelData;

/// Whitened residuals of some readings, in standard deviations of the noise.
#[must_use]
pub fn whitened_residuals(data: &ChannelData, whitening: &Whitening, readings: &[f64]) -> Vec<f64> {
    let mut r: Vec<f64> =
        data.measured_kpa.iter().zip(readings).map(|(m, y)| (m - y) / data.noise_kpa).collect();
    whitening.apply(&mut r);
    r
}

/// Sum of squares in every block.
#[must_use]
pub fn block_losses(data: &ChannelData, residuals: &[f64]) -> Vec<f64> {
    data.spans.iter().map(|span| residuals[span.clone()].iter().map(|v| v * v).sum()).collect()
}
