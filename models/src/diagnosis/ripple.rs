//! Where a cycle of the supply may hide: a periodogram of what a sine in the supply would do to the readings.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

use super::blocks::Role;
use super::channel::{ChannelData, SINES};
use super::dependence::rows_of;
use super::stage::ChannelStage;
use crate::effects::Kind;

/// Shortest period looked for, s.
const SHORTEST_S: f64 = 1.5;
/// Frequencies looked at, at most, from the lowest: in an hour's recording the fastest cycles are left out.
const MOST: usize = 160;
/// Distance of neighbouring frequencies, periods per recording.
const SPACING: f64 = 0.8;
/// Parts of a period in which the supply rises that are tried.
const RISES: [f64; 2] = [0.3, 0.7];

/// A sine in the supply pressure.
#[derive(Debug, Clone, Copy)]
pub struct Cycle {
    frequency_hz: f64,
    /// Amplitudes of its cosine and its sine, as parts of the gauge pressure.
    waves: [f64; 2],
    gauge_pa: f64,
}

/// The strongest cycle on the fit blocks.
#[must_use]
pub fn strongest_cycle(data: &ChannelData, stage: &ChannelStage) -> Option<Cycle> {
    if data.plant.kind == Kind::Linear {
        return None;
    }
    let duration = data.inputs.duration_s.max(1.0);
    let lowest = 1.5 / duration;
    let count = (((1.0 / SHORTEST_S) - lowest) / (SPACING / duration)).max(1.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at least one
    let count = (count as usize).min(MOST);
    let gauge = data.inputs.supply_pa.first().copied().unwrap_or(0.0) - data.inputs.ambient_pa;
    let residual: Vec<f64> =
        data.measured_kpa.iter().zip(&stage.readings).map(|(m, y)| (m - y) / data.noise_kpa).collect();
    let mut best: Option<(f64, f64, [f64; 2])> = None;
    let frequencies: Vec<f64> = (0..count).map(|k| lowest + SPACING / duration * k as f64).collect();
    let mut white = residual;
    stage.whitening.apply(&mut white);
    for part in frequencies.chunks(SINES) {
        let responses = data.sine_derivatives(&stage.model, part);
        for (k, &frequency) in part.iter().enumerate() {
            if let Some((gain, waves)) = response(data, stage, &responses, &white, k)
                && best.as_ref().is_none_or(|(g, _, _)| gain > *g)
            {
                best = Some((gain, frequency, waves));
            }
        }
    }
    best.map(|(_, frequency_hz, waves)| Cycle { frequency_hz, waves, gauge_pa: gauge })
}

impl Cycle {
    /// Probes of an effect that is searched for over the periods; none for others.
    #[must_use]
    pub fn probes(&self, effect: &str) -> Vec<Vec<f64>> {
        let [cosine, sine] = self.waves;
        let (share, period_s) = (cosine.hypot(sine), 1.0 / self.frequency_hz);
        match effect {
            "supply_ripple" => {
                let amplitude_kpa = (share * self.gauge_pa * 1e-3 * PI * PI / 8.0).clamp(0.5, 250.0);
                // cos(w t) c + sin(w t) s peaks at phase peak; the triangle's first harmonic peaks at rise / 2 + 1 / 4.
                let peak = sine.atan2(cosine) / TAU;
                let phase = |rise: f64| (0.25 + 0.5 * rise - peak).rem_euclid(1.0);
                RISES.iter().map(|&rise| vec![amplitude_kpa, period_s, phase(rise), rise]).collect()
            }
            "inflow_cycle" => {
                let phase = (cosine.atan2(sine) / TAU).rem_euclid(1.0);
                vec![vec![share.clamp(0.002, 0.4), period_s, phase]]
            }
            _ => Vec::new(),
        }
    }
}

/// How much the cosine and the sine of number `k` take out of the whitened residual on the fit blocks, and their amplitudes as parts of
/// the gauge pressure.
fn response(
    data: &ChannelData,
    stage: &ChannelStage,
    responses: &[[f64; 2 * SINES]],
    white: &[f64],
    k: usize,
) -> Option<(f64, [f64; 2])> {
    let pair = |row: &[f64; 2 * SINES]| [row[2 * k] / data.noise_kpa, row[2 * k + 1] / data.noise_kpa];
    let mut columns: Vec<f64> = responses.iter().flat_map(pair).collect();
    stage.whitening.apply_columns(&mut columns, 2);
    let (mut gram, mut right) = (DMatrix::<f64>::zeros(2, 2), DVector::<f64>::zeros(2));
    for row in rows_of(data, &[Role::Fit]) {
        let u = [columns[2 * row], columns[2 * row + 1]];
        for a in 0..2 {
            right[a] += u[a] * white[row];
            for b in 0..2 {
                gram[(a, b)] += u[a] * u[b];
            }
        }
    }
    let solution = gram.cholesky()?.solve(&right);
    Some((solution.dot(&right), [solution[0], solution[1]]))
}
