//! Where a cycle of the supply may hide: a periodogram of what a sine in the supply would do to the readings.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use crate::diagnosis::channel::{ChannelData, Role, rows_of};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::likelihood::SINES;
use crate::effects::Wave;

/// Shortest period looked for, s.
const SHORTEST_S: f64 = 1.5;
/// Frequencies looked at, at most, from the lowest: in an hour's recording the fastest cycles are left out.
const MOST: usize = 160;
/// Distance of neighbouring frequencies, periods per recording.
const SPACING: f64 = 0.8;
/// Every how many frequencies the response is simulated; between them it is interpolated.
const SIMULATED: usize = 4;
/// The strongest cycle on the fit blocks.
#[must_use]
pub fn strongest_cycle(data: &ChannelData, stage: &ChannelStage) -> Option<Wave> {
    if data.plant.model.is_regulator() {
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
    let envelopes = Envelopes::new(data, stage, &frequencies);
    for &frequency in &frequencies {
        if let Some((gain, waves)) = response(data, stage, envelopes.waves(frequency), &white)
            && best.as_ref().is_none_or(|(g, _, _)| gain > *g)
        {
            best = Some((gain, frequency, waves));
        }
    }
    best.map(|(_, frequency_hz, [cosine, sine])| Wave { cosine, sine, frequency_hz, gauge_pa: gauge })
}

/// What sines in the supply do to the readings. To a wave `exp(i w t)` they answer with `Z(w, t) exp(i w t)`; the envelope `Z` changes with
/// the frequency only over the inverse of the time that the readings remember, so it is simulated at some frequencies and
/// interpolated between them.
struct Envelopes<'a> {
    data: &'a ChannelData,
    /// Frequencies at which it was simulated, Hz, ascending.
    frequencies: Vec<f64>,
    /// Real and imaginary part for each of them, compared row by compared row, kPa per part of the gauge pressure.
    values: Vec<Vec<[f64; 2]>>,
}

impl<'a> Envelopes<'a> {
    fn new(data: &'a ChannelData, stage: &ChannelStage, frequencies: &[f64]) -> Self {
        let last = frequencies.last().copied();
        let mut knots: Vec<f64> = frequencies.iter().copied().step_by(SIMULATED).collect();
        knots.extend(last.filter(|last| knots.last() != Some(last)));
        let mut values = Vec::with_capacity(knots.len());
        for part in knots.chunks(SINES) {
            let responses = data.sine_derivatives(&stage.model, part);
            for (k, &frequency) in part.iter().enumerate() {
                let turned = data.rows.iter().zip(&responses).map(|(&row, answer)| {
                    let (sine, cosine) = (TAU * frequency * data.inputs.time_s[row as usize]).sin_cos();
                    let [a, b] = [answer[2 * k], answer[2 * k + 1]];
                    [a * cosine + b * sine, b * cosine - a * sine]
                });
                values.push(turned.collect());
            }
        }
        Self { data, frequencies: knots, values }
    }

    /// The readings' answers to a cosine and a sine, row by row, in standard deviations of the noise.
    fn waves(&self, frequency: f64) -> Vec<f64> {
        let above = self.frequencies.partition_point(|f| *f < frequency).min(self.frequencies.len() - 1);
        let below = above.saturating_sub(1);
        let gap = self.frequencies[above] - self.frequencies[below];
        let part = if gap > 0.0 { (frequency - self.frequencies[below]) / gap } else { 0.0 };
        let scale = 1.0 / self.data.noise_kpa;
        let pairs = self.values[below].iter().zip(&self.values[above]).zip(self.data.rows.iter());
        pairs
            .flat_map(|((low, high), &row)| {
                let (sine, cosine) = (TAU * frequency * self.data.inputs.time_s[row as usize]).sin_cos();
                let [re, im] = [0, 1].map(|k| scale * (low[k] + part * (high[k] - low[k])));
                [re * cosine - im * sine, re * sine + im * cosine]
            })
            .collect()
    }
}

/// How much a cosine and a sine take out of the whitened residual on the fit blocks, and their amplitudes as parts of the gauge pressure.
/// `columns` are what they do to the readings.
fn response(
    data: &ChannelData,
    stage: &ChannelStage,
    mut columns: Vec<f64>,
    white: &[f64],
) -> Option<(f64, [f64; 2])> {
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
