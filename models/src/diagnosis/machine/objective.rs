//! All recordings of one channel as one sum of squares.

use nalgebra::DVector;

use super::recordings::MachineChannel;
use super::ties::{Freedom, TiedModel, Ties};
use crate::diagnosis::channel::{Extended, HATS, Role, hats, rows_of};
use crate::fit::{Normal, Objective};
use crate::model::Parameter;
use crate::parallel;

/// Residuals of rollouts (simulated minus measured, kPa) over the coordinates of what is free: the
/// machine's, the heights of its smooth correction where it has one, then each recording's own.
pub struct JointObjective<'a> {
    channel: &'a MachineChannel,
    start: TiedModel,
    ties: Ties,
    parameters: Vec<Parameter>,
    roles: &'a [Role],
    /// Heights of a correction that is fitted along; 0 or [`HATS`].
    heights: usize,
}

impl<'a> JointObjective<'a> {
    /// From where a model stands.
    #[must_use]
    pub fn new(
        channel: &'a MachineChannel,
        start: &TiedModel,
        freedom: Freedom<'_>,
        roles: &'a [Role],
    ) -> Self {
        let (data, first) = (&channel.recorded[0], &start.models[0]);
        let heights =
            if first.correction.is_some() && !matches!(freedom, Freedom::Known(_)) { HATS } else { 0 };
        Self {
            channel,
            start: start.clone(),
            ties: Ties::of(data, first, freedom),
            parameters: first.parameters(&data.plant),
            roles,
            heights,
        }
    }

    /// The models at some coordinates.
    #[must_use]
    pub fn models_at(&self, coordinates: &[f64]) -> TiedModel {
        TiedModel { models: (0..self.start.models.len()).map(|r| self.model_at(coordinates, r)).collect() }
    }

    fn shared(&self) -> usize {
        self.ties.machine.len() + self.heights
    }

    fn model_at(&self, coordinates: &[f64], recording: usize) -> Extended {
        let mut model = self.start.models[recording].clone();
        let machine = self.ties.machine.iter().zip(coordinates);
        let own = self.shared() + recording * self.ties.load.len();
        let load = self.ties.load.iter().zip(&coordinates[own..]);
        for (&position, &x) in machine.chain(load) {
            let p = &self.parameters[position];
            let value = p.scale.value(x);
            model.values[position] = value.clamp(p.lower, p.upper);
        }
        if let Some(correction) = model.correction.as_mut().filter(|_| self.heights > 0) {
            let from = self.ties.machine.len();
            correction.heights.copy_from_slice(&coordinates[from..from + HATS]);
        }
        model
    }

    /// The coordinate that one of a recording's local columns (machine, heights, load) stands for.
    fn coordinate(&self, recording: usize, column: usize) -> usize {
        let shared = self.shared();
        if column < shared { column } else { shared + recording * self.ties.load.len() + column - shared }
    }

    /// Coordinates of one recording's own parameters, with their positions in its model.
    pub fn own(&self, recording: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let from = self.shared() + recording * self.ties.load.len();
        self.ties.load.iter().enumerate().map(move |(k, &position)| (from + k, position))
    }

    /// One recording's residuals and derivatives by its columns, row by row.
    fn columns(&self, coordinates: &[f64], recording: usize) -> (Vec<f64>, Vec<f64>) {
        let data = &self.channel.recorded[recording];
        let model = self.model_at(coordinates, recording);
        let (readings, own) = data.sensitivities(&model, &self.ties.free());
        let residuals = readings.iter().zip(data.measured_kpa.iter()).map(|(y, m)| y - m).collect();
        let Some(correction) = model.correction.as_ref().filter(|_| self.heights > 0) else {
            return (residuals, own);
        };
        let plain = data.trace(&model.uncorrected());
        let Some(values) = data.series(&plain, correction.variable) else {
            return (residuals, own);
        };
        let weights: Vec<[f64; HATS]> = values.iter().map(|v| hats(&correction.knots, *v)).collect();
        let by_height = data.rate_derivatives(&model, &weights);
        let (machine, all) = (self.ties.machine.len(), self.ties.free().len());
        let mut matrix = Vec::with_capacity(readings.len() * (all + HATS));
        for (row, heights) in own.chunks(all.max(1)).zip(&by_height) {
            matrix.extend_from_slice(&row[..machine]);
            matrix.extend_from_slice(heights);
            matrix.extend_from_slice(&row[machine..]);
        }
        (residuals, matrix)
    }

    fn width(&self) -> usize {
        self.shared() + self.ties.load.len()
    }

    fn bounds_of(&self, position: usize) -> (f64, f64) {
        let p = &self.parameters[position];
        p.coordinate_bounds()
    }
}

/// Heights beyond these, kPa/s, are no correction.
const HIGHEST_KPA_S: f64 = 1e4;

impl Objective for JointObjective<'_> {
    fn dimension(&self) -> usize {
        self.shared() + self.ties.load.len() * self.start.models.len()
    }

    fn bounds(&self) -> Vec<(f64, f64)> {
        let nominal = self.nominal();
        let mut bounds: Vec<(f64, f64)> = self.ties.machine.iter().map(|&k| self.bounds_of(k)).collect();
        bounds.extend(std::iter::repeat_n((-HIGHEST_KPA_S, HIGHEST_KPA_S), self.heights));
        for recording in 0..self.start.models.len() {
            for (coordinate, position) in self.own(recording) {
                let anchored = recording == 0 && self.ties.anchored == Some(position);
                let at = nominal[coordinate];
                bounds.push(if anchored { (at, at) } else { self.bounds_of(position) });
            }
        }
        bounds
    }

    fn nominal(&self) -> Vec<f64> {
        let at = |model: &Extended, position: usize| {
            self.parameters[position].scale.coordinate(model.values[position])
        };
        let first = &self.start.models[0];
        let mut nominal: Vec<f64> = self.ties.machine.iter().map(|&k| at(first, k)).collect();
        if let Some(correction) = first.correction.as_ref().filter(|_| self.heights > 0) {
            nominal.extend_from_slice(&correction.heights);
        }
        for model in &self.start.models {
            nominal.extend(self.ties.load.iter().map(|&k| at(model, k)));
        }
        nominal
    }

    fn normal(&self, coordinates: &[f64]) -> Normal {
        let width = self.width();
        let parts: Vec<Normal> = parallel::map(0..self.start.models.len(), |recording| {
            let (residuals, matrix) = self.columns(coordinates, recording);
            let mut part = Normal::zeros(width);
            for row in rows_of(&self.channel.recorded[recording], self.roles) {
                let (r, j) = (residuals[row], &matrix[row * width..(row + 1) * width]);
                part.cost += r * r;
                for a in 0..width {
                    part.gradient[a] += j[a] * r;
                    for b in a..width {
                        part.matrix[(a, b)] += j[a] * j[b];
                    }
                }
            }
            part
        });
        let mut all = Normal::zeros(self.dimension());
        for (recording, part) in parts.iter().enumerate() {
            all.cost += part.cost;
            for a in 0..width {
                let at = self.coordinate(recording, a);
                all.gradient[at] += part.gradient[a];
                for b in 0..width {
                    all.matrix[(at, self.coordinate(recording, b))] += part.matrix[(a.min(b), a.max(b))];
                }
            }
        }
        all
    }

    fn residuals(&self) -> usize {
        self.channel.recorded.iter().map(|data| rows_of(data, self.roles).len()).sum()
    }

    fn scores(&self, coordinates: &[f64], sink: &mut dyn FnMut(usize, &DVector<f64>, f64)) {
        let width = self.width();
        for recording in 0..self.start.models.len() {
            let (residuals, matrix) = self.columns(coordinates, recording);
            for row in rows_of(&self.channel.recorded[recording], self.roles) {
                let mut score = DVector::zeros(self.dimension());
                for a in 0..width {
                    score[self.coordinate(recording, a)] += matrix[row * width + a] * residuals[row];
                }
                sink(recording, &score, residuals[row] * residuals[row]);
            }
        }
    }
}
