//! How far apart two explanations would be under an excitation, after each has done its best to
//! imitate the other.
//!
//! The criterion is T-optimality (Atkinson and Fedorov, Biometrika 62, 1975): the squared distance,
//! in variances of the noise, that the wrong explanation keeps from the right one after a refit.
//! The refit is linear in the parameters and holds on to what the recordings so far say about them;
//! supply wander and start pressures are free as in every diagnosis.

use nalgebra::DMatrix;

use super::menu::Excitation;
use super::planned::planned;
use crate::diagnosis::channel::{ChannelData, Extended, OPEN, Role, settled};
use crate::diagnosis::estimation::{ChannelStage, models_of, normal_equations};
use crate::diagnosis::likelihood::whitened_residuals;

const ALL: [Role; 3] = [Role::Fit, Role::Select, Role::Test];

/// One explanation of the recordings so far.
#[derive(Debug, Clone)]
pub struct Explanation {
    /// Models, channel by channel.
    pub models: Vec<Extended>,
    /// Positions of their free parameters.
    pub free: Vec<Vec<usize>>,
    /// What the recordings so far say about these, as a normal matrix.
    pub known: Vec<DMatrix<f64>>,
}

impl Explanation {
    /// From the stages that the models have on the recordings so far.
    #[must_use]
    pub fn new(channels: &[ChannelData], stages: &[ChannelStage]) -> Self {
        let known = channels.iter().zip(stages).map(|(data, stage)| {
            normal_equations(data, &OPEN, &stage.residuals, &stage.sensitivities, stage.free.len()).matrix
        });
        Self {
            models: models_of(stages),
            free: stages.iter().map(|s| s.free.clone()).collect(),
            known: known.collect(),
        }
    }
}

/// How far apart some explanations are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Separation {
    /// Squared distance of the two nearest, in variances of the noise.
    pub squared: f64,
    /// The same as a root mean square over the rows compared, kPa.
    pub rms_kpa: f64,
    /// Rows compared.
    pub rows: usize,
}

/// The separation of the explanations that an excitation separates least, over the channels in
/// `watched`. `None` when a simulation runs away.
#[must_use]
pub fn separation(
    channels: &[ChannelData],
    explanations: &[Explanation],
    watched: &[usize],
    excitation: Excitation,
    range_kpa: [f64; 2],
) -> Option<Separation> {
    let seen: Vec<Vec<Prediction>> = explanations
        .iter()
        .map(|explanation| {
            let mut future = planned(channels, excitation, range_kpa);
            let _ = settled(&mut future, &explanation.models);
            let predict = |&k: &usize| {
                let (model, free) = (explanation.models[k].clone(), explanation.free[k].clone());
                Prediction { stage: ChannelStage::new(&future[k], model, free), data: future[k].clone() }
            };
            watched.iter().map(predict).collect()
        })
        .collect();
    let mut least: Option<Separation> = None;
    for truth in 0..seen.len() {
        for (other, explanation) in explanations.iter().enumerate().filter(|(k, _)| *k != truth) {
            let (mut squared, mut squared_kpa, mut rows) = (0.0, 0.0, 0);
            for (place, &k) in watched.iter().enumerate() {
                let distance =
                    seen[other][place].from(&seen[truth][place].stage.readings, &explanation.known[k])?;
                squared += distance;
                squared_kpa += distance * channels[k].noise_kpa.powi(2);
                rows += seen[other][place].data.rows.len();
            }
            if least.is_none_or(|l| squared < l.squared) {
                let rms_kpa = (squared_kpa / rows.max(1) as f64).sqrt();
                least = Some(Separation { squared, rms_kpa, rows });
            }
        }
    }
    least.filter(|l| l.squared.is_finite())
}

/// What one explanation predicts for one channel.
struct Prediction {
    data: ChannelData,
    stage: ChannelStage,
}

impl Prediction {
    /// Squared distance from the truth's readings that is left after a refit.
    fn from(&self, truth: &[f64], known: &DMatrix<f64>) -> Option<f64> {
        let mut data = self.data.clone();
        data.measured_kpa = truth.into();
        let apart = whitened_residuals(&data, &self.stage.whitening, &self.stage.readings);
        let n = self.stage.free.len();
        let normal = normal_equations(&data, &ALL, &apart, &self.stage.sensitivities, n);
        let mut matrix = &normal.matrix + known;
        for k in 0..n {
            matrix[(k, k)] = matrix[(k, k)] * (1.0 + 1e-9) + 1e-12;
        }
        let given_way = normal.gradient.dot(&matrix.cholesky()?.solve(&normal.gradient));
        Some((normal.cost - given_way).max(0.0))
    }
}
