//! The noise of a measurement, quantisation included.

use crate::data::Channel;

/// Values that a converter tells apart repeat: with a new one in fewer than this part of the
/// samples, they are its steps.
const REPEATED: f64 = 0.25;

/// Noise of a measurement, in its unit, RMS: what varies from sample to sample, and at least what
/// rounding to the converter's steps leaves (a uniform error, W. R. Bennett, Bell Syst. Tech. J.
/// 27, 1948). A pressure at rest may repeat one value for seconds.
#[must_use]
pub fn noise(measured: &[f64], usable: &[bool]) -> f64 {
    scatter(measured, usable).max(step(measured, usable) / 12.0_f64.sqrt())
}

/// The same of a channel's measured pressure, kPa; `None` where there is none.
#[must_use]
pub fn measured_kpa(channel: &Channel) -> Option<f64> {
    let pressure = channel.pressure_kpa.as_ref()?;
    let usable: Vec<bool> =
        channel.flags.iter().zip(pressure).map(|(f, p)| f.pressure_usable() && p.is_finite()).collect();
    let measured: Vec<f64> = pressure.iter().map(|p| f64::from(*p)).collect();
    Some(noise(&measured, &usable))
}

/// The step of the converter, as the median distance of values that were measured; 0 where they
/// hardly repeat.
fn step(measured: &[f64], usable: &[bool]) -> f64 {
    let mut values: Vec<f64> = measured.iter().zip(usable).filter(|(_, u)| **u).map(|(y, _)| *y).collect();
    let samples = values.len() as f64;
    values.sort_by(f64::total_cmp);
    values.dedup();
    let mut steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() || values.len() as f64 > REPEATED * samples {
        return 0.0;
    }
    steps.sort_by(f64::total_cmp);
    steps[steps.len() / 2]
}

/// Parts of a recording in which it is taken to be quiet: its quieter quarter, or less where even
/// that is not.
const QUIET: [f64; 2] = [0.25, 0.05];
/// The quantiles of chi-squared with six degrees of freedom at [`QUIET`], over its mean.
const QUANTILES: [f64; 2] = [3.455 / 6.0, 1.635 / 6.0];
/// Noise is as large in the quietest part as in a quiet one. What is so many times as large is a
/// movement.
const MOVEMENT: f64 = 2.0;

/// Scatter of a measurement, in its unit, RMS, from what a parabola over nine samples leaves where
/// the pressure is quiet. Behind a tube a board's loop may chatter nearly all the time.
fn scatter(measured: &[f64], usable: &[bool]) -> f64 {
    let variances = variances(measured, usable);
    if variances.is_empty() {
        return 0.0;
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a part of the length
    let at = |part: f64| variances[(part * variances.len() as f64) as usize];
    let [quiet, quietest] = [0, 1].map(|k| (at(QUIET[k]) / QUANTILES[k]).sqrt());
    let quietest = quietest.max(step(measured, usable) / 12.0_f64.sqrt());
    if quiet > MOVEMENT * quietest && quietest > 0.0 { quietest } else { quiet }
}

/// Variances of what a parabola over nine samples leaves, ascending.
fn variances(measured: &[f64], usable: &[bool]) -> Vec<f64> {
    const N: usize = 9;
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
    variances.sort_by(f64::total_cmp);
    variances
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pressure that rises and rests, every 10 ms, rounded to steps of 0.84.
    #[test]
    fn what_rests_on_one_step_is_still_rounded() {
        let measured: Vec<f64> = (0..4000)
            .map(|k| f64::from(k) * 0.01)
            .map(|t| 100.0 * (0.5 * t).sin().clamp(-0.7, 0.7))
            .map(|kpa| (kpa / 0.84).round() * 0.84)
            .collect();
        let usable = vec![true; measured.len()];
        assert!(scatter(&measured, &usable) < 0.1);
        assert!((noise(&measured, &usable) - 0.84 / 12.0_f64.sqrt()).abs() < 1e-6);
    }

    /// Noise of unit variance.
    fn noisy(count: usize) -> Vec<f64> {
        crate::diagnosis::testing::normals(3, count)
    }

    #[test]
    fn what_chatters_four_fifths_of_the_time_is_hardly_noisier_than_the_rest() {
        let mut measured = noisy(9000);
        let usable = vec![true; measured.len()];
        let all = noise(&measured, &usable);
        assert!((all - 1.0).abs() < 0.06, "{all}");
        for (k, y) in measured.iter_mut().enumerate().filter(|(k, _)| k % 1000 >= 200) {
            *y += 40.0 * (2.1 * k as f64).sin();
        }
        let chattering = noise(&measured, &usable);
        // A twentieth of all is the quieter quarter of what is quiet, which is taken for its
        // quietest twentieth.
        let expected = (QUANTILES[0] / QUANTILES[1]).sqrt();
        assert!((chattering / expected - 1.0).abs() < 0.1, "{chattering} of 1.45, and not of 28");
    }

    #[test]
    fn values_that_never_repeat_have_no_steps() {
        let measured: Vec<f64> = (0..4000).map(|k| (f64::from(k) * 0.7).sin()).collect();
        assert_eq!(step(&measured, &vec![true; measured.len()]), 0.0);
        assert_eq!(step(&[], &[]), 0.0);
    }
}
