//! The best first-order actuator for a channel: what a simulator's built-in pneumatic cylinder can
//! say of it, and what that costs.

use rand::RngExt;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use serde::Serialize;

use super::calibrated::CalibratedModel;
use super::error::SimulationError;
use super::result::SimulationSettings;
use super::run::simulate;
use crate::data::{Channel, ChannelId, Flags, Recording, Source};
use crate::diagnosis::DiagnosisError;
use crate::experiment::ControllerUse;

/// Length of the course of set points that it is fitted on, s.
const DURATION_S: f64 = 120.0;
/// Period of its rows, s.
const PERIOD_S: f64 = 0.01;
/// Time constants that are tried, s.
const TIME_CONSTANTS_S: [f64; 2] = [1e-3, 10.0];
/// Halvings of their range by the golden section: to a millionth.
const SECTIONS: usize = 60;

/// `pressure = gain * activation + bias`, where the activation follows the set point with a
/// first-order lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FirstOrder {
    /// Which channel.
    pub channel: ChannelId,
    /// Time constant of the lag, s.
    pub time_constant_s: f64,
    /// Pressure per set point.
    pub gain: f64,
    /// Pressure at a set point of 0, kPa gauge.
    pub bias_kpa: f64,
    /// What it leaves of the calibrated model's pressure: root mean square, kPa.
    pub rms_kpa: f64,
    /// The largest difference, kPa.
    pub largest_kpa: f64,
}

/// Fits a first-order actuator to each channel: to its calibrated model's pressures over two
/// minutes of set points of random size (up to `highest_kpa`, kPa gauge) that are held for 0.1 to 3
/// s, with the joint locked and the rig's nominal supply.
///
/// # Errors
/// [`SimulationError`] where the model cannot be simulated from set points.
pub fn first_order(model: &CalibratedModel, highest_kpa: f64) -> Result<Vec<FirstOrder>, SimulationError> {
    let recording = set_points(&channels(model)?, highest_kpa);
    let set_point = |id| recording.channel(id).ok().and_then(|c| c.command_kpa.as_deref());
    let settings = SimulationSettings { controller: control(model), start_kpa: 0.0, rig: None };
    let simulation = simulate(model, &recording, &settings, &mut |_, _| {})?;
    let fitted = simulation.channels.iter().filter_map(|simulated| {
        let command: Vec<f64> = set_point(simulated.id)?.iter().map(|c| f64::from(*c)).collect();
        Some(best(simulated.id, &command, &simulated.kpa))
    });
    Ok(fitted.collect())
}

/// The board's loop where there is one; a regulator has its own.
fn control(model: &CalibratedModel) -> ControllerUse {
    let regulator = match model {
        CalibratedModel::Fitted { .. } => false,
        CalibratedModel::Extended { file, .. } => file.channels.values().all(|c| c.drive == "command"),
    };
    if regulator { ControllerUse::Auto } else { ControllerUse::On }
}

fn channels(model: &CalibratedModel) -> Result<Vec<ChannelId>, SimulationError> {
    match model {
        CalibratedModel::Fitted { file, .. } => Ok(file.channels.keys().copied().collect()),
        CalibratedModel::Extended { name, file } => {
            let id = |text: &String| {
                let problem = |e| DiagnosisError::Reference { file: name.clone(), problem: format!("{e}") };
                text.parse::<ChannelId>().map_err(problem)
            };
            Ok(file.channels.keys().map(id).collect::<Result<_, _>>()?)
        }
    }
}

/// A recording of nothing but set points, each channel's own.
fn set_points(ids: &[ChannelId], highest_kpa: f64) -> Recording {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a constant
    let rows = (DURATION_S / PERIOD_S).round() as usize;
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut levels = || {
        let mut values = vec![0.0_f32; 10];
        while values.len() < rows {
            let hold = rng.random_range(10..300);
            #[allow(clippy::cast_possible_truncation)] // as recordings keep them
            let level = rng.random_range(0.0..highest_kpa) as f32;
            values.extend(std::iter::repeat_n(level, hold));
        }
        values.truncate(rows);
        values
    };
    let channel = |id: &ChannelId| Channel {
        id: *id,
        command_kpa: Some(levels()),
        pressure_kpa: None,
        drive: None,
        flags: vec![Flags::NONE; rows],
    };
    Recording {
        source: Source { file: "set points".to_owned(), sha256: String::new(), bytes: 0 },
        time_s: (0..rows).map(|k| k as f64 * PERIOD_S).collect(),
        line: (2..).take(rows).collect(),
        breaks: Vec::new(),
        period_s: PERIOD_S,
        channels: ids.iter().map(channel).collect(),
        joints: Vec::new(),
        supply_kpa: None,
        board_supplies: Vec::new(),
    }
}

/// Searches the time constant by the golden section of its logarithm; gain and bias follow from it.
fn best(channel: ChannelId, command: &[f64], kpa: &[f64]) -> FirstOrder {
    let of = |log: f64| straight(channel, log.exp(), command, kpa);
    let share = 0.5 * (5.0_f64.sqrt() - 1.0);
    let [mut low, mut high] = TIME_CONSTANTS_S.map(f64::ln);
    for _ in 0..SECTIONS {
        let (a, b) = (high - share * (high - low), low + share * (high - low));
        if of(a).rms_kpa < of(b).rms_kpa {
            high = b;
        } else {
            low = a;
        }
    }
    of(0.5 * (low + high))
}

/// Gain and bias for a time constant, by least squares.
fn straight(channel: ChannelId, time_constant_s: f64, command: &[f64], kpa: &[f64]) -> FirstOrder {
    let rest = (-PERIOD_S / time_constant_s).exp();
    let mut activation = command[0];
    let mut follow = |set_point: &f64| {
        let now = activation;
        activation = set_point + (activation - set_point) * rest;
        now
    };
    let lagging: Vec<f64> = command.iter().map(&mut follow).collect();
    let count = kpa.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let (x, y) = (mean(&lagging), mean(kpa));
    let (mut xx, mut xy) = (0.0, 0.0);
    for (a, p) in lagging.iter().zip(kpa) {
        xx += (a - x) * (a - x);
        xy += (a - x) * (p - y);
    }
    let gain = xy / xx;
    let bias_kpa = y - gain * x;
    let errors = || lagging.iter().zip(kpa).map(|(a, p)| p - gain * a - bias_kpa);
    FirstOrder {
        channel,
        time_constant_s,
        gain,
        bias_kpa,
        rms_kpa: (errors().map(|e| e * e).sum::<f64>() / count).sqrt(),
        largest_kpa: errors().map(f64::abs).fold(0.0, f64::max),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_first_order_channel_is_found_without_error() {
        let id = ChannelId { board: 0, channel: 0 };
        let recording = set_points(&[id], 300.0);
        let command: Vec<f64> =
            recording.channels[0].command_kpa.as_ref().unwrap().iter().map(|c| f64::from(*c)).collect();
        let lag = straight(id, 0.15, &command, &vec![0.0; command.len()]);
        assert_eq!((lag.gain, lag.bias_kpa), (0.0, 0.0));
        let mut p = 0.0;
        let kpa: Vec<f64> = command
            .iter()
            .map(|c| {
                let now = p;
                p = c + (p - c) * (-PERIOD_S / 0.15).exp();
                0.9 * now + 4.0
            })
            .collect();
        let found = best(id, &command, &kpa);
        assert!((found.time_constant_s - 0.15).abs() < 1e-6, "{found:?}");
        assert!((found.gain - 0.9).abs() < 1e-6 && (found.bias_kpa - 4.0).abs() < 1e-4, "{found:?}");
        assert!(found.rms_kpa < 1e-4 && found.largest_kpa < 1e-3, "{found:?}");
    }
}
