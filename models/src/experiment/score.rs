//! How far predicted pressures are from measured ones.

use serde::{Deserialize, Serialize};

use crate::data::{Channel, Recording};
use crate::model::column;
use crate::rollout::Series;

const KPA_PER_PA: f64 = 1e-3;

/// Agreement over the usable samples of a stretch of rows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Coefficient of determination, 1 - (sum of squared errors) / (sum of squares about the mean):
    /// 1 is perfect, 0 is as good as the mean, below 0 is worse. Of the pressure for a rollout; of
    /// the pressure's change over the step for one-step predictions, because the pressure itself
    /// hardly changes in one step and any prediction of it looks perfect.
    pub r2: f64,
    /// Root mean square error, kPa.
    pub rmse_kpa: f64,
    /// Mean absolute error, kPa.
    pub mae_kpa: f64,
    /// Integral of the absolute error over time, kPa s. Grows with the length: compare it only over
    /// the same stretch.
    pub iae_kpa_s: f64,
    /// Largest absolute error, kPa.
    pub largest_kpa: f64,
    /// Samples compared.
    pub samples: usize,
    /// Time they stand for, s.
    pub seconds: f64,
}

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Basis {
    /// The pressure.
    Pressure,
    /// Its change since the row before.
    Change,
}

/// Compares rollouts (absolute, Pa, one value per row) with the measurements of `series`; `None`
/// when no sample is usable.
#[must_use]
pub fn score(series: &Series, predicted_pa: &[f64]) -> Option<Score> {
    score_on(series, predicted_pa, Basis::Pressure)
}

pub(super) fn score_on(series: &Series, predicted_pa: &[f64], basis: Basis) -> Option<Score> {
    let usable = |row: usize| series.weights()[row] > 0.0;
    let measured = |row: usize| series.measured()[row] * KPA_PER_PA;
    let rows: Vec<usize> = series
        .segments()
        .iter()
        .flat_map(|range| {
            let first = if basis == Basis::Change { range.start + 1 } else { range.start };
            first..range.end
        })
        .filter(|&row| usable(row) && (basis == Basis::Pressure || usable(row - 1)))
        .collect();
    let samples = rows.iter().map(|&row| {
        let value = match basis {
            Basis::Pressure => measured(row),
            Basis::Change => measured(row) - measured(row - 1),
        };
        Sample {
            measured_kpa: value,
            error_kpa: predicted_pa[row] * KPA_PER_PA - measured(row),
            interval_s: series.row(row)[column::INTERVAL_S],
        }
    });
    score_samples(samples)
}

/// One compared row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// What was measured, kPa.
    pub measured_kpa: f64,
    /// Predicted minus measured, kPa.
    pub error_kpa: f64,
    /// Time the row stands for, s.
    pub interval_s: f64,
}

/// The score of some rows; `None` when there is none.
#[must_use]
pub fn score_samples(samples: impl IntoIterator<Item = Sample>) -> Option<Score> {
    let (mut count, mut mean, mut spread) = (0.0, 0.0, 0.0);
    let (mut squares, mut absolute, mut integral, mut largest, mut seconds) = (0.0, 0.0, 0.0, 0.0_f64, 0.0);
    let mut samples_seen = 0;
    for Sample { measured_kpa: value, error_kpa, interval_s: interval } in samples {
        samples_seen += 1;
        // A rollout that ran away is infinitely wrong, not skipped.
        let error = if error_kpa.is_nan() { f64::INFINITY } else { error_kpa.abs() };
        count += 1.0;
        let off = value - mean;
        mean += off / count;
        spread += off * (value - mean);
        squares += error * error;
        absolute += error;
        integral += error * interval;
        largest = largest.max(error);
        seconds += interval;
    }
    (count > 0.0).then(|| Score {
        r2: 1.0 - squares / spread,
        rmse_kpa: (squares / count).sqrt(),
        mae_kpa: absolute / count,
        iae_kpa_s: integral,
        largest_kpa: largest,
        samples: samples_seen,
        seconds,
    })
}

/// The score of a channel's rows, simulated as `kpa` (kPa gauge); only those marked in `usable`
/// count. `None` when nothing was measured there.
#[must_use]
pub fn score_rows(recording: &Recording, channel: &Channel, kpa: &[f64], usable: &[bool]) -> Option<Score> {
    let measured = channel.pressure_kpa.iter().flatten().enumerate().filter(|(row, _)| usable[*row]);
    score_samples(measured.map(|(row, measured)| Sample {
        measured_kpa: f64::from(*measured),
        error_kpa: kpa[row] - f64::from(*measured),
        interval_s: match recording.time_s.get(row + 1) {
            Some(next) if !recording.breaks.contains(&(row + 1)) => next - recording.time_s[row],
            _ => recording.period_s,
        },
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 10 Hz, pressures 100, 101, 103, 106 kPa, the third masked.
    fn series() -> Series {
        let mut rows = Vec::new();
        for k in 0..4 {
            let mut row = [0.0; column::COUNT];
            row[column::TIME_S] = 0.1 * f64::from(k);
            row[column::INTERVAL_S] = 0.1;
            row[column::INVERSE_VOLUME_PER_M3] = 1.0;
            rows.extend(row);
        }
        let measured = vec![100e3, 101e3, 103e3, 106e3];
        let weights = vec![1.0, 1.0, 0.0, 1.0];
        Series::new(column::COUNT, rows, measured, weights, std::iter::once(0..4).collect()).unwrap()
    }

    #[test]
    fn scores_are_what_a_calculator_gives() {
        // Errors 1, -1, (masked), 2 kPa; mean 307/3, squares about it 186/9 = 62/3.
        let got = score(&series(), &[101e3, 100e3, 0.0, 108e3]).unwrap();
        assert!((got.rmse_kpa - 2.0_f64.sqrt()).abs() < 1e-12, "{got:?}");
        assert!((got.mae_kpa - 4.0 / 3.0).abs() < 1e-12);
        assert!((got.iae_kpa_s - 0.4).abs() < 1e-12);
        assert!((got.r2 - (1.0 - 6.0 / (62.0 / 3.0))).abs() < 1e-12);
        assert_eq!((got.samples, got.largest_kpa), (3, 2.0));
    }

    #[test]
    fn changes_need_two_usable_rows() {
        let got = score_on(&series(), &[f64::NAN, 101.5e3, 0.0, 0.0], Basis::Change).unwrap();
        assert_eq!(got.samples, 1);
        assert!((got.mae_kpa - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_rollout_that_ran_away_is_infinitely_wrong() {
        let got = score(&series(), &[101e3, f64::NAN, 0.0, 108e3]).unwrap();
        assert!(got.rmse_kpa.is_infinite() && got.r2 == f64::NEG_INFINITY);
    }
}
