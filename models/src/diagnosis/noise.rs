//! The noise of a measurement, quantisation included.

/// Noise of a measurement, in its unit, RMS, from what a parabola over nine samples leaves, in the quieter quarter of the recording (where the
/// lower quartile of chi-squared with six degrees of freedom, 3.455, stands for its mean).
#[must_use]
pub fn noise(measured: &[f64], usable: &[bool]) -> f64 {
    const N: usize = 9;
    const QUARTILE: f64 = 3.455 / 6.0;
    let x: Vec<f64> = (0..N).map(|k| k as f64 - 4.0).collect();
    let square: Vec<f64> = x.iter().map(|v| v * v - 60.0 / 9.0).collect();
    let (sx, sq) = (60.0, square.iter().map(|v| v * v).sum::<f64>());
    let mut variances: Vec<f64> = measured
        .chunks_exact(N)
        .zip(usable.chunks_exact(N))
        .filter(|(_, u)| u.iter().all(|u| *u))
        .map(|(y, _)| {
            let mean = y.iter().sum::<f64>() / N as f64;
            let dot = |w: &[f64]| y.iter().zip(w).map(|(y, w)| (y - mean) * w).sum::<f64>();
            let total: f64 = y.iter().map(|v| (v - mean) * (v - mean)).sum();
            (total - dot(&x).powi(2) / sx - dot(&square).powi(2) / sq).max(0.0) / 6.0
        })
        .collect();
    if variances.is_empty() {
        return 0.0;
    }
    variances.sort_by(f64::total_cmp);
    (variances[variances.len() / 4] / QUARTILE).sqrt()
}
