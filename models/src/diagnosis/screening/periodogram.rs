//! A periodogram of what a sine in the supply would do to the readings.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Vector2};

use super::scores::scores;
use crate::diagnosis::channel::{ChannelData, OPEN, rows_of};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::likelihood::SINES;
use crate::effects::Wave;

/// Every how many frequencies the response is simulated; between them it is interpolated.
const SIMULATED: usize = 4;

/// A channel and what cycles do to it.
pub struct Listener<'a> {
    data: &'a ChannelData,
    stage: &'a ChannelStage,
    envelopes: Envelopes<'a>,
    /// What is left of the readings, whitened, in standard deviations of the noise.
    white: Vec<f64>,
}

impl<'a> Listener<'a> {
    /// Of a channel whose stage is what was found so far, and frequencies in Hz, ascending.
    pub fn new(data: &'a ChannelData, stage: &'a ChannelStage, frequencies: &[f64]) -> Self {
        let mut white: Vec<f64> =
            data.measured_kpa.iter().zip(&stage.readings).map(|(m, y)| (m - y) / data.noise_kpa).collect();
        stage.whitening.apply(&mut white);
        Self { data, stage, envelopes: Envelopes::new(data, stage, frequencies), white }
    }

    /// Gauge supply pressure, Pa.
    fn gauge_pa(&self) -> f64 {
        self.data.inputs.supply_pa.first().copied().unwrap_or(0.0) - self.data.inputs.ambient_pa
    }
}

/// What is heard of one frequency.
pub struct Heard {
    /// The frequency, Hz.
    pub frequency_hz: f64,
    /// How much the best wave takes out of the squared whitened residual ...
    pub gain: f64,
    /// ... and that wave, where the recording tells one.
    pub wave: Option<Wave>,
    /// Products of the residual with a cosine and a sine, quarter of a block by quarter.
    pub parts: Vec<Vector2<f64>>,
}

impl Heard {
    /// Of one frequency on all channels, which have one supply: the same part of its pressure in
    /// all of them.
    pub fn new(listeners: &[Listener<'_>], frequency_hz: f64) -> Self {
        let mut gram = Matrix2::zeros();
        let mut parts: Vec<Vector2<f64>> = Vec::new();
        for Listener { data, stage, envelopes, white } in listeners {
            let mut columns = envelopes.waves(frequency_hz);
            stage.whitening.apply_columns(&mut columns, 2);
            let (mut cosine, mut sine) = (Vec::new(), Vec::new());
            for wave in columns.chunks_exact(2) {
                cosine.push(wave[0]);
                sine.push(wave[1]);
            }
            for row in rows_of(data, &OPEN) {
                let (c, s) = (cosine[row], sine[row]);
                gram.m11 += c * c;
                gram.m12 += c * s;
                gram.m22 += s * s;
            }
            let [cosine, sine] = [cosine, sine].map(|column| scores(data, white, &column, &OPEN));
            parts.resize(parts.len().max(cosine.len()), Vector2::zeros());
            for (part, (c, s)) in parts.iter_mut().zip(cosine.into_iter().zip(sine)) {
                *part += Vector2::new(c, s);
            }
        }
        gram.m21 = gram.m12;
        let right: Vector2<f64> = parts.iter().sum();
        let solution = gram.cholesky().map(|root| root.solve(&right));
        let gain = solution.map_or(0.0, |solution| solution.dot(&right));
        let gauge_pa = listeners.first().map_or(0.0, Listener::gauge_pa);
        let wave = solution.map(|s| Wave { cosine: s[0], sine: s[1], frequency_hz, gauge_pa });
        Self { frequency_hz, gain, wave, parts }
    }
}

/// What sines in the supply do to the readings. To a wave `exp(i w t)` they answer with
/// `Z(w, t) exp(i w t)`; the envelope `Z` changes with the frequency only over the inverse of the
/// time that the readings remember, so it is simulated at some frequencies and interpolated between
/// them.
struct Envelopes<'a> {
    data: &'a ChannelData,
    /// Frequencies at which it was simulated, Hz, ascending.
    frequencies: Vec<f64>,
    /// Real and imaginary part for each of them, compared row by compared row, kPa per part of the
    /// gauge pressure.
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

    /// The readings' answers to a cosine and a sine, row by row, in standard deviations of the
    /// noise.
    fn waves(&self, frequency: f64) -> Vec<f64> {
        let above = self.frequencies.partition_point(|f| *f < frequency).min(self.frequencies.len() - 1);
        let below = above.saturating_sub(1);
        let gap = self.frequencies[above] - self.frequencies[below];
        let part = if gap > 0.0 { (frequency - self.frequencies[below]) / gap } else { 0.0 };
        let scale = 1.0 / self.data.noise_kpa;
        let (low, high) = (&self.values[below], &self.values[above]);
        let mut waves = Vec::with_capacity(2 * low.len());
        for (k, &row) in self.data.rows.iter().enumerate() {
            let (sine, cosine) = (TAU * frequency * self.data.inputs.time_s[row as usize]).sin_cos();
            let re = scale * (low[k][0] + part * (high[k][0] - low[k][0]));
            let im = scale * (low[k][1] + part * (high[k][1] - low[k][1]));
            waves.extend([re * cosine - im * sine, re * sine + im * cosine]);
        }
        waves
    }
}
