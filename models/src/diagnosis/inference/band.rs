//! A band around a simulation that holds the measured pressure.
//!
//! What a simulation gets wrong is partly the same everywhere and partly grows with how fast the
//! pressure moves, as everything does that comes too early or too late. Both parts are estimated
//! where the model was fitted; where causes were chosen the band is widened or narrowed until it
//! holds 95 % of the readings (split conformal prediction with a scale: Lei, G'Sell, Rinaldo,
//! Tibshirani and Wasserman, J. Am. Stat. Assoc. 113, 2018). The test blocks then say what it
//! holds. It takes no distribution of errors for granted, but that later recordings are like this
//! one.

use serde::{Deserialize, Serialize};

use crate::diagnosis::channel::{ChannelData, Extended, Role};

/// Share of the readings that the band holds.
const HOLDS: f64 = 0.95;
/// Half of the time over which the rate of pressure is taken, s.
const RATE_HALF_S: f64 = 0.025;
/// Times that differ by less are the same, s.
const SAME_S: f64 = 1e-9;
/// Rounds of weighted least squares in which the two parts are estimated.
const ROUNDS: usize = 12;
/// Smallest part that is the same everywhere, over the noise.
const LEAST: f64 = 0.01;

/// A 95 % band: so many kilopascals below and above the simulated pressure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Half of its width where the pressure rests, kPa.
    pub rest_kpa: f64,
    /// What is added in squares for every kPa/s at which the simulated pressure moves, s.
    pub timing_s: f64,
}

impl Band {
    /// Half of the width at a rate of pressure, kPa.
    #[must_use]
    pub fn half_width_kpa(&self, rate_kpa_s: f64) -> f64 {
        self.rest_kpa.hypot(self.timing_s * rate_kpa_s)
    }

    /// Of a model. `None` where there is nothing to estimate it from.
    #[must_use]
    pub fn of(data: &ChannelData, model: &Extended) -> Option<Self> {
        let errors = errors(data, model);
        let fit: Vec<(f64, f64)> = of_role(data, &errors, Role::Fit);
        let least = (LEAST * data.noise_kpa).powi(2);
        let [rest, timing] = parts(&fit, least)?;
        let scale = Self { rest_kpa: rest.sqrt(), timing_s: timing.sqrt() };
        let select = of_role(data, &errors, Role::Select);
        let mut ratios: Vec<f64> =
            select.iter().map(|(e, rate)| e.abs() / scale.half_width_kpa(*rate)).collect();
        ratios.sort_by(f64::total_cmp);
        let n = ratios.len();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a share of a length
        let at = ((n + 1) as f64 * HOLDS).ceil() as usize;
        let factor = ratios.get(at.min(n).checked_sub(1)?)?;
        Some(Self { rest_kpa: factor * scale.rest_kpa, timing_s: factor * scale.timing_s })
    }

    /// How many readings of the test blocks it holds, and of how many.
    #[must_use]
    pub fn held(&self, data: &ChannelData, model: &Extended) -> (usize, usize) {
        let test = of_role(data, &errors(data, model), Role::Test);
        let inside = test.iter().filter(|(error, rate)| error.abs() <= self.half_width_kpa(*rate)).count();
        (inside, test.len())
    }
}

/// Rates of simulated pressures, row by row, kPa/s: slopes over 25 ms on both sides, and at least
/// from neighbour to neighbour. No slope reaches beyond a start: `starts` are the rows at which a
/// stretch without a gap begins, ascending.
#[must_use]
pub fn rates_kpa_s(time_s: &[f64], kpa: &[f64], starts: &[usize]) -> Vec<f64> {
    let mut rates = vec![0.0; kpa.len()];
    let ends = starts.iter().skip(1).copied().chain([kpa.len()]);
    for (&start, end) in starts.iter().zip(ends) {
        let (mut from, mut to) = (start, start);
        for row in start..end {
            while time_s[from] < time_s[row] - RATE_HALF_S - SAME_S {
                from += 1;
            }
            while to + 1 < end && time_s[to + 1] <= time_s[row] + RATE_HALF_S + SAME_S {
                to += 1;
            }
            let first = from.min(row.saturating_sub(1)).max(start);
            let last = to.max(row + 1).min(end - 1);
            let between_s = time_s[last] - time_s[first];
            if between_s > 0.0 {
                rates[row] = (kpa[last] - kpa[first]) / between_s;
            }
        }
    }
    rates
}

/// Error (measured - simulated, kPa) and rate of the simulated pressure (kPa/s) at every compared
/// row.
fn errors(data: &ChannelData, model: &Extended) -> Vec<(f64, f64)> {
    let kpa: Vec<f64> = data.trace(model).iter().map(|row| row[0]).collect();
    let rates = rates_kpa_s(&data.inputs.time_s, &kpa, &data.inputs.starts);
    let rows = data.rows.iter().map(|&row| row as usize);
    rows.zip(data.measured_kpa.iter()).map(|(row, measured)| (measured - kpa[row], rates[row])).collect()
}

fn of_role(data: &ChannelData, errors: &[(f64, f64)], role: Role) -> Vec<(f64, f64)> {
    let chosen = data.blocks.iter().zip(&data.spans).filter(|(block, _)| block.role == role);
    let all = chosen.flat_map(|(_, span)| &errors[span.clone()]);
    all.copied().filter(|(error, rate)| error.is_finite() && rate.is_finite()).collect()
}

/// The variance of the error as a part that is the same everywhere, at least `least`, and one that
/// grows with the square of the rate: least squares of squared errors, each weighted by the
/// variance that is expected of it.
fn parts(errors: &[(f64, f64)], least: f64) -> Option<[f64; 2]> {
    let mean = errors.iter().map(|(e, _)| e * e).sum::<f64>() / errors.len().max(1) as f64;
    if errors.is_empty() || !mean.is_finite() {
        return None;
    }
    let (mut rest, mut timing) = (mean.max(least), 0.0);
    for _ in 0..ROUNDS {
        let [mut s0, mut s1, mut s2, mut y0, mut y1] = [0.0; 5];
        for (error, rate) in errors {
            let (x, y) = (rate * rate, error * error);
            let weight = (rest + timing * x).powi(-2);
            s0 += weight;
            s1 += weight * x;
            s2 += weight * x * x;
            y0 += weight * y;
            y1 += weight * x * y;
        }
        let determinant = s0 * s2 - s1 * s1;
        if determinant <= 1e-12 * s0 * s2 {
            break;
        }
        rest = (y0 * s2 - y1 * s1) / determinant;
        timing = (s0 * y1 - s1 * y0) / determinant;
        // The best of what is possible: one of the two parts at its end.
        if timing < 0.0 {
            (rest, timing) = (y0 / s0, 0.0);
        } else if rest < least {
            (rest, timing) = (least, ((y1 - least * s1) / s2).max(0.0));
        }
        rest = rest.max(least);
    }
    Some([rest, timing])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, measured, normals};

    #[test]
    fn both_parts_of_an_error_are_found() {
        let (noise, rates) = (normals(1, 20_000), normals(2, 20_000));
        let errors: Vec<(f64, f64)> = noise
            .iter()
            .zip(&rates)
            .map(|(n, r)| {
                let rate = 40.0 * r;
                (n * 0.2_f64.hypot(0.01 * rate), rate)
            })
            .collect();
        let [rest, timing] = parts(&errors, 1e-6).unwrap();
        assert!((rest.sqrt() / 0.2 - 1.0).abs() < 0.05 && (timing.sqrt() / 0.01 - 1.0).abs() < 0.05);
        let still: Vec<(f64, f64)> = errors.iter().map(|(e, _)| (*e, 0.0)).collect();
        assert!(parts(&still, 1e-6).unwrap()[1].abs() < 1e-12);
        assert_eq!(parts(&[], 1e-6), None);
    }

    /// Of a parabola the slope between rows as far away on both sides is that in the middle.
    #[test]
    fn a_rate_is_the_slope_around_a_row_also_where_rows_are_rare() {
        for period_s in [0.002, 0.01, 0.2] {
            let time_s: Vec<f64> = (0..60).map(|k| f64::from(k) * period_s).collect();
            let kpa: Vec<f64> = time_s.iter().map(|t| 5.0 - 30.0 * t * t).collect();
            let rates = rates_kpa_s(&time_s, &kpa, &[0]);
            for row in 13..47 {
                assert!(
                    (rates[row] + 60.0 * time_s[row]).abs() < 1e-9,
                    "{period_s}, row {row}: {}",
                    rates[row]
                );
            }
        }
    }

    #[test]
    fn no_rate_reaches_beyond_a_gap() {
        let time_s: Vec<f64> =
            (0..40).map(|k| 0.01 * f64::from(k) + if k < 20 { 0.0 } else { 2.0 }).collect();
        let kpa: Vec<f64> = (0..40).map(|k| if k < 20 { 0.0 } else { 200.0 }).collect();
        assert_eq!(rates_kpa_s(&time_s, &kpa, &[0, 20]), vec![0.0; 40]);
    }

    #[test]
    fn a_band_holds_the_share_of_the_test_blocks_that_it_says() {
        let (data, model) = channel(false);
        let (mut inside, mut count) = (0, 0);
        for seed in 0..20 {
            let data = measured(data.clone(), &model, seed);
            let band = Band::of(&data, &model).unwrap();
            assert!((band.half_width_kpa(0.0) / (1.96 * data.noise_kpa) - 1.0).abs() < 0.15, "{band:?}");
            let held = band.held(&data, &model);
            (inside, count) = (inside + held.0, count + held.1);
        }
        let share = inside as f64 / count as f64;
        assert!(count > 5000 && (0.94..0.96).contains(&share), "{inside} of {count}");
    }
}
