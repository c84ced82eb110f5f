//! Sizes of a machine's parameters and of its loads', with intervals.
//!
//! An interval counts what residuals that last leave open (the robust covariance of the joint fit)
//! and what the estimate moves by when one recording is left out (jackknife): how much recordings
//! differ is the floor of every interval.

use std::collections::BTreeMap;

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::fit::refit;
use super::held_out::HeldOut;
use super::recordings::MachineChannel;
use super::ties::{Freedom, TiedModel, Ties};
use crate::diagnosis::channel::{Extended, OPEN};
use crate::diagnosis::inference::determines;
use crate::diagnosis::json::Estimate;
use crate::effects::catalogue::CATALOGUE;
use crate::fit::covariance;
use crate::model::Parameter;

/// Evaluations that bring a fitted model to the parts that chose it as well.
const AGAIN: usize = 30;

/// The models of one channel fitted to all that may be looked at, with the sizes of its effects.
#[derive(Debug)]
pub struct Sizes {
    /// The models.
    pub models: TiedModel,
    /// Parameters of effects (`effect.parameter`) that are the machine's.
    pub machine: BTreeMap<String, Estimate>,
    /// Those of each recording's load.
    pub loads: Vec<BTreeMap<String, Estimate>>,
}

impl Sizes {
    /// Of models that stand near their optimum.
    #[must_use]
    pub fn of(
        channel: &MachineChannel,
        models: &TiedModel,
        known: Option<&[usize]>,
        held_out: &HeldOut,
    ) -> Self {
        let freedom = known.map_or(Freedom::Machine, Freedom::Known);
        let fitted = refit(channel, models, freedom, &OPEN, AGAIN);
        let precision = covariance(&fitted.objective, &fitted.minimum);
        let data = &channel.recorded[0];
        let parameters = fitted.models.models[0].parameters(&data.plant);
        let base = data.plant.parameters().len();
        let ties = Ties::of(data, &fitted.models.models[0], freedom);
        let estimate = |recording: usize, coordinate: usize, position: usize| {
            let jackknife = jackknife(held_out, recording, position, &parameters[position]);
            let error = precision.standard_errors[coordinate].hypot(jackknife);
            let quantile = match known {
                Some(_) => precision.quantile(coordinate, 0.95),
                None => quantile(held_out.jackknife.len()),
            };
            let value = fitted.models.models[recording].values[position];
            sized(&parameters[position], value, quantile * error)
        };
        let named = |position: usize| parameters[position].name.clone();
        let machine = ties.machine.iter().enumerate().filter(|(_, position)| **position >= base);
        let machine = machine.map(|(k, &position)| (named(position), estimate(0, k, position))).collect();
        let loads = (0..channel.recorded.len())
            .map(|recording| {
                let own = fitted.objective.own(recording);
                own.map(|(k, position)| {
                    let mut size = estimate(recording, k, position);
                    if recording == 0 && ties.anchored == Some(position) {
                        size.state = "taken as the unit".to_owned();
                        size.ci95 = Some([size.value; 2]);
                    }
                    (named(position), size)
                })
                .collect()
            })
            .collect();
        let mut sizes = Self { models: fitted.models, machine, loads };
        sizes.derive(channel, held_out, known.is_some());
        sizes
    }

    /// Adds what several parameters of an effect make together, at the recordings' mean flow.
    fn derive(&mut self, channel: &MachineChannel, held_out: &HeldOut, known: bool) {
        let data = &channel.recorded[0];
        let flow_kpa_s = mean_rate_kpa_s(channel);
        for &effect in &self.models.models[0].effects {
            let (Some(size), Some(range)) =
                (CATALOGUE[effect].derived(), self.models.models[0].range(&data.plant, effect))
            else {
                continue;
            };
            let of = |model: &Extended| (size.of)(&model.values[range.clone()], flow_kpa_s).max(1e-12).ln();
            for (recording, load) in self.loads.iter_mut().enumerate() {
                let value = of(&self.models.models[recording]);
                let values: Vec<f64> =
                    held_out.jackknife.iter().map(|fit| of(&fit.models[recording])).collect();
                let half = quantile(values.len()) * jackknife_error(&values);
                // One recording has no others to be left out.
                let ci95 = (!known && half < SURE).then(|| [(value - half).exp(), (value + half).exp()]);
                let state = if ci95.is_some() { "identified" } else { "not identifiable here" };
                let estimate = Estimate {
                    value: value.exp(),
                    ci95,
                    unit: size.unit.to_owned(),
                    state: state.to_owned(),
                };
                load.insert(format!("{}.{}", CATALOGUE[effect].id, size.name), estimate);
            }
        }
    }
}

/// A derived size is determined when its interval's half is less than this factor's logarithm: ten
/// times.
const SURE: f64 = std::f64::consts::LN_10;

/// Mean rate at which the recorded pressures move, kPa/s.
fn mean_rate_kpa_s(channel: &MachineChannel) -> f64 {
    let (mut moved, mut seconds) = (0.0, 0.0);
    for data in &channel.recorded {
        moved += data.inputs.measured_pa.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f64>() * 1e-3;
        seconds += data.inputs.duration_s;
    }
    moved / f64::max(seconds, 1e-9)
}

/// Half width of a 95 % interval in standard errors of a jackknife over so many recordings.
fn quantile(recordings: usize) -> f64 {
    let freedom = (recordings as f64 - 1.0).max(1.0);
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

/// Standard error of a recording's parameter over the fits that leave one recording out, on the
/// scale of fitting.
fn jackknife(held_out: &HeldOut, recording: usize, position: usize, p: &Parameter) -> f64 {
    let values: Vec<f64> = held_out
        .jackknife
        .iter()
        .map(|fit: &TiedModel| {
            let model: &Extended = &fit.models[recording];
            p.scale.coordinate(model.values[position])
        })
        .collect();
    jackknife_error(&values)
}

/// Standard error from estimates that each leave one recording out.
fn jackknife_error(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    ((n - 1.0) / n * values.iter().map(|v| (v - mean).powi(2)).sum::<f64>()).sqrt()
}

fn sized(p: &Parameter, value: f64, half: f64) -> Estimate {
    let ends = [-half, half].map(|by| p.scale.moved(value, by).clamp(p.lower, p.upper));
    let flat = !half.is_finite() || !determines(p.scale, ends, [p.lower, p.upper]);
    Estimate {
        value,
        ci95: (!flat).then_some(ends),
        unit: p.unit.to_owned(),
        state: if flat { "not identifiable here" } else { "identified" }.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jackknife_of_means_has_the_error_of_the_mean() {
        let values: [f64; 5] = [3.0, 4.0, 7.0, 1.0, 5.0];
        let left_out: Vec<f64> =
            values.iter().map(|v| (values.iter().sum::<f64>() - v) / (values.len() - 1) as f64).collect();
        let mean = values.iter().sum::<f64>() / 5.0;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 4.0;
        assert!((jackknife_error(&left_out) - (variance / 5.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_reaches_over_most_of_a_range_is_not_determined() {
        let parameter = Parameter {
            name: "p".to_owned(),
            unit: "1",
            lower: 0.1,
            upper: 10.0,
            nominal: 1.0,
            scale: crate::model::Scale::Logarithmic,
            meaning: "",
        };
        let known = sized(&parameter, 2.0, 0.1);
        assert_eq!(known.ci95, Some([2.0 * (-0.1_f64).exp(), 2.0 * 0.1_f64.exp()]));
        let flat = sized(&parameter, 1.0, 2.2);
        assert_eq!((flat.ci95, flat.state.as_str()), (None, "not identifiable here"));
    }
}
