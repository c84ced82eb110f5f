//! What a model is worth on a recording with the curves of the others.
//!
//! Each recording is left out once: the machine is fitted to the others, the recording's own load
//! to the parts of it that may be looked at, and the error counted on its last part. What one
//! recording does to the sizes of the others is a jackknife's (Efron and Stein, Annals of
//! Statistics 9, 1981).

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::evidence::pieces;
use super::fit::refit;
use super::recordings::MachineChannel;
use super::ties::{Freedom, TiedModel, Ties};
use crate::diagnosis::channel::{Extended, OPEN, Role, rows_of};
use crate::diagnosis::json::Gain;
use crate::parallel;

/// Evaluations that fit a machine without one of its recordings.
const OTHERS: usize = 15;
/// Evaluations that fit a load.
const LOAD: usize = 15;

/// Errors of rollouts on the last parts of the recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOut {
    /// Sum of squares (kPa^2) and number of rows of each unit: a recording, or a piece of one where
    /// there are few.
    pub units: Vec<(f64, f64)>,
    /// The model of each recording with the curves of the others.
    pub models: Vec<Extended>,
    /// The models of all recordings in each fit that leaves one out, in its place the one with the
    /// others' curves.
    pub jackknife: Vec<TiedModel>,
}

impl HeldOut {
    /// Of the models of one channel. Where the machine is known, nothing but the loads is fitted.
    #[must_use]
    pub fn of(
        channel: &MachineChannel,
        models: &TiedModel,
        known: Option<&[usize]>,
        tick: &(dyn Fn() + Sync),
    ) -> Self {
        let count = channel.recorded.len();
        let left_out: Vec<TiedModel> = parallel::map(0..count, |recording| {
            tick();
            left_out(channel, models, recording, known)
        });
        let pieces = pieces(count);
        let mut units = Vec::new();
        for (recording, fitted) in left_out.iter().enumerate() {
            let data = &channel.recorded[recording];
            let residuals = data.residuals(&fitted.models[recording]);
            let rows = rows_of(data, &[Role::Test]);
            let length = rows.len().div_ceil(pieces).max(1);
            units.extend(rows.chunks(length).map(|piece| {
                (piece.iter().map(|&row| residuals[row].powi(2)).sum::<f64>(), piece.len() as f64)
            }));
        }
        let own = left_out.iter().enumerate().map(|(k, fitted)| fitted.models[k].clone()).collect();
        Self { units, models: own, jackknife: left_out }
    }

    /// Of several channels together.
    #[must_use]
    pub fn together(parts: &[Self]) -> Self {
        let mut all = parts[0].clone();
        for part in &parts[1..] {
            for (a, b) in all.units.iter_mut().zip(&part.units) {
                *a = (a.0 + b.0, a.1 + b.1);
            }
        }
        all
    }

    /// RMS error, kPa.
    #[must_use]
    pub fn rmse_kpa(&self) -> f64 {
        let (sum, count) = self.units.iter().fold((0.0, 0.0), |a, u| (a.0 + u.0, a.1 + u.1));
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// Reduction of the RMS error from `self` to `after`, with a 95 % interval from how much the
    /// units differ (delta method, Student's t).
    #[must_use]
    pub fn gain(&self, after: &Self) -> Gain {
        let total = |e: &Self| e.units.iter().map(|u| u.0).sum::<f64>();
        let (a, b) = (total(self), total(after));
        let pulls: Vec<f64> =
            self.units.iter().zip(&after.units).map(|(x, y)| 0.5 * (y.0 / b - x.0 / a)).collect();
        let n = pulls.len() as f64;
        let error = (pulls.iter().map(|v| v * v).sum::<f64>() * n / (n - 1.0).max(1.0)).sqrt();
        let quantile =
            StudentsT::new(0.0, 1.0, (n - 1.0).max(1.0)).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975));
        let log = 0.5 * (b / a).ln();
        let ci95 = [log + quantile * error, log - quantile * error].map(|l| 1.0 - l.exp());
        Gain {
            test_rmse_before_kpa: self.rmse_kpa(),
            test_rmse_after_kpa: after.rmse_kpa(),
            reduction: 1.0 - log.exp(),
            ci95,
            weighted_ci95: ci95,
        }
    }
}

/// The models of all recordings when one does not help to fit the machine.
fn left_out(
    channel: &MachineChannel,
    models: &TiedModel,
    recording: usize,
    known: Option<&[usize]>,
) -> TiedModel {
    let mut fitted = models.clone();
    let effects = models.models[recording].effects.clone();
    if known.is_none() && channel.recorded.len() > 1 {
        let mut rest = models.clone();
        rest.models.remove(recording);
        let others = channel.without(recording);
        let rest = refit(&others, &rest, Freedom::Machine, &OPEN, OTHERS).models;
        let mut own = TiedModel { models: vec![models.models[recording].clone()] };
        // The load stays where it stood, the machine is the others'.
        let ties = Ties::of(&channel.recorded[0], &models.models[0], Freedom::Machine);
        for &position in &ties.machine {
            own.models[0].values[position] = rest.models[0].values[position];
        }
        own.models[0].correction.clone_from(&rest.models[0].correction);
        let mut rest = rest.models.into_iter();
        for (k, model) in fitted.models.iter_mut().enumerate() {
            *model = if k == recording {
                own.models[0].clone()
            } else {
                rest.next().unwrap_or_else(|| model.clone())
            };
        }
    }
    let alone = channel.only(recording);
    let start = TiedModel { models: vec![fitted.models[recording].clone()] };
    // Of a machine that was just fitted all effects are known.
    let freedom = Freedom::Known(known.unwrap_or(&effects));
    let mut load = refit(&alone, &start, freedom, &OPEN, LOAD).models;
    fitted.models[recording] = load.models.remove(0);
    fitted
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(squares: &[f64]) -> HeldOut {
        HeldOut {
            units: squares.iter().map(|s| (*s, 1.0)).collect(),
            models: Vec::new(),
            jackknife: Vec::new(),
        }
    }

    #[test]
    fn a_gain_is_as_sure_as_recordings_agree() {
        let before = errors(&[4.0; 8]);
        let gain = before.gain(&errors(&[1.0; 8]));
        assert!((gain.reduction - 0.5).abs() < 1e-12 && gain.ci95.iter().all(|e| (e - 0.5).abs() < 1e-9));
        let gain = before.gain(&errors(&[0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 7.3]));
        assert!((gain.reduction - 0.5).abs() < 1e-12);
        assert!(gain.ci95[0] < 0.0 && gain.ci95[1] > 0.6, "{gain:?}");
    }
}
