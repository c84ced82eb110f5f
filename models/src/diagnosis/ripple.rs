//! Where a cycle of the supply may hide: a periodogram of what a sine in the supply would do to the readings.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

use super::blocks::Role;
use super::channel::ChannelData;
use super::stage::ChannelStage;
use crate::effects::Kind;

/// Shortest period looked for, s.
const SHORTEST_S: f64 = 1.5;
/// Frequencies looked at, at most.
const MOST: usize = 160;
/// Half-width over which a sine is averaged per frequency pair, periods per recording.
const SPACING: f64 = 0.6;
/// Parts of a period in which the supply rises that are tried.
const RISES: [f64; 2] = [0.3, 0.7];

/// Probes (amplitude kPa, period s, phase, rise) of the strongest cycle on the fit blocks; empty when there is none.
#[must_use]
pub fn ripple_probes(data: &ChannelData, stage: &ChannelStage) -> Vec<Vec<f64>> {
    if data.plant.kind == Kind::Linear {
        return Vec::new();
    }
    // A sine's response over blocks much shorter than its period is a change of level, so the response to a level, held through
    // a block and modulated by the sine, stands for it.
    let derivatives = data.disturbances(&stage.model);
    let duration = data.inputs.duration_s.max(1.0);
    let lowest = 1.5 / duration;
    let count = (((1.0 / SHORTEST_S) - lowest) / (SPACING / duration)).max(1.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at least one
    let count = (count as usize).min(MOST);
    let ratio = (1.0 / SHORTEST_S / lowest).powf(1.0 / count as f64);
    let gauge = data.inputs.supply_pa.first().copied().unwrap_or(0.0) - data.inputs.ambient_pa;
    let residual: Vec<f64> =
        data.measured_kpa.iter().zip(&stage.readings).map(|(m, y)| (m - y) / data.noise_kpa).collect();
    let linear = lowest + SPACING / duration * count as f64 >= 1.0 / SHORTEST_S;
    let mut best: Option<(f64, f64, [f64; 2])> = None;
    for k in 0..count {
        let frequency = if linear {
            lowest + SPACING / duration * k as f64
        } else {
            lowest * ratio.powi(i32::try_from(k).unwrap_or(0))
        };
        if let Some((gain, waves)) = response(data, stage, &derivatives, &residual, frequency) {
            if best.as_ref().is_none_or(|(g, _, _)| gain > *g) {
                best = Some((gain, frequency, waves));
            }
        }
    }
    let Some((_, frequency, [cosine, sine])) = best else {
        return Vec::new();
    };
    let amplitude = (cosine.hypot(sine) * gauge * 1e-3 * PI * PI / 8.0).clamp(0.5, 250.0);
    RISES
        .iter()
        .map(|&rise| {
            // cos(w t) c + sin(w t) s peaks at phase peak; the triangle's first harmonic peaks at rise / 2 + 1 / 4.
            let peak = sine.atan2(cosine) / TAU;
            vec![amplitude, 1.0 / frequency, (0.25 + 0.5 * rise - peak).rem_euclid(1.0), rise]
        })
        .collect()
}

/// How much a cosine and a sine in the supply take out of the residual on the fit blocks, and their amplitudes as parts of the gauge
/// pressure.
fn response(
    data: &ChannelData,
    stage: &ChannelStage,
    derivatives: &[[f64; 3]],
    residual: &[f64],
    frequency: f64,
) -> Option<(f64, [f64; 2])> {
    let mut columns = vec![0.0; 2 * residual.len()];
    for (block, span) in data.blocks.iter().zip(&data.spans) {
        if block.role != Role::Fit {
            continue;
        }
        // The response to a supply s(t) accumulates: dy = integral of s dy/ds. Differences of the level's response in time
        // are weighted with the sine there; what the chamber forgets meanwhile is in those differences too.
        let mut sums = [0.0; 2];
        let mut before = 0.0;
        for row in span.clone() {
            let time = data.inputs.time_s[data.rows[row] as usize];
            let (s, c) = (TAU * frequency * time).sin_cos();
            let step = derivatives[row][1] - before;
            before = derivatives[row][1];
            sums[0] += step * c;
            sums[1] += step * s;
            columns[2 * row] = sums[0] / data.noise_kpa;
            columns[2 * row + 1] = sums[1] / data.noise_kpa;
        }
    }
    stage.whitening.apply_columns(&mut columns, 2);
    let mut white = residual.to_vec();
    stage.whitening.apply(&mut white);
    let (mut gram, mut right) = (DMatrix::<f64>::zeros(2, 2), DVector::<f64>::zeros(2));
    for (row, r) in white.iter().enumerate() {
        let u = [columns[2 * row], columns[2 * row + 1]];
        for a in 0..2 {
            right[a] += u[a] * r;
            for b in 0..2 {
                gram[(a, b)] += u[a] * u[b];
            }
        }
    }
    let solution = gram.cholesky()?.solve(&right);
    Some((solution.dot(&right), [solution[0], solution[1]]))
}
