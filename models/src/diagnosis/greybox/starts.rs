//! Where climbs begin, and what is expected of a channel's parameters.

use super::posterior::{Expected, Posterior};
use super::uncertainty::Uncertainty;
use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::estimation::{CORNER, EDGES, GAINS, LEAK, free_base, start};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::CATALOGUE;
use crate::model::{Parameter, Scale};

/// Rates at which the search for a regulator begins, 1/s.
const RATES: [f64; 5] = [0.3, 1.0, 3.0, 10.0, 30.0];
/// Deviations at which climbs begin, over the expected ones.
const BEGIN: [f64; 2] = [0.1, 0.3];
/// Gains at which a climb with an effect begins, over those of the base model: an effect that takes
/// up flow leaves more for the valve.
const FACTORS: [f64; 3] = [0.2, 0.5, 1.0];

/// What is expected of a channel, beside its model.
#[derive(Debug, Clone, Copy)]
pub struct Expectation {
    /// Gain of the valve, mm^2.
    pub gain: f64,
    /// Scales of the deviations.
    pub scales: Uncertainty,
}

/// Base models from which a search begins: valves from slow to fast, or regulators.
#[must_use]
pub fn base_starts(data: &ChannelData) -> Vec<Extended> {
    if data.plant.model.is_regulator() {
        return RATES.map(|rate| Extended::base(vec![rate, rate])).to_vec();
    }
    GAINS.iter().flat_map(|gain| EDGES.map(|edge| start(data, *gain, edge))).collect()
}

/// Models with an effect from which a search begins: at every probe, with the base model's gains
/// and smaller ones, and with valves as a base model's search begins: one that is far off may have
/// bent its valve to imitate the effect.
#[must_use]
pub fn effect_starts(data: &ChannelData, base: &Extended, effect: usize) -> Vec<Extended> {
    let gains: Vec<usize> = positions(&data.plant.parameters(), |p| p.unit == "mm2" && p.name != "corner");
    let smaller = FACTORS.map(|factor| {
        let mut model = base.clone();
        gains.iter().for_each(|&k| model.values[k] *= factor);
        model
    });
    let valves = if data.plant.model.is_regulator() {
        vec![base.clone()]
    } else {
        smaller.into_iter().chain(GAINS.map(|gain| start(data, gain, EDGES[1]))).collect()
    };
    let with = |valve: &Extended| {
        CATALOGUE[effect].probes.iter().map(|p| valve.with(&data.plant, effect, p)).collect::<Vec<_>>()
    };
    valves.iter().flat_map(with).collect()
}

fn positions(parameters: &[Parameter], wanted: impl Fn(&Parameter) -> bool) -> Vec<usize> {
    parameters.iter().enumerate().filter(|(_, p)| wanted(p)).map(|(k, _)| k).collect()
}

/// What is expected of the deviations on a channel.
#[must_use]
pub fn scales(data: &ChannelData) -> Uncertainty {
    let pressures = &data.inputs.measured_pa;
    let mean = pressures.iter().sum::<f64>() / pressures.len() as f64;
    let square = pressures.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / pressures.len() as f64;
    let noise_pa = data.noise_kpa * 1e3;
    Uncertainty {
        supply: SETTINGS.greybox_supply,
        discrepancy_pa: (SETTINGS.greybox_discrepancy * square.sqrt()).max(noise_pa),
        noise_pa,
    }
}

/// Deviations at which a climb begins.
#[must_use]
pub fn begin(scales: &Uncertainty) -> Uncertainty {
    let Uncertainty { supply, discrepancy_pa, noise_pa } = *scales;
    Uncertainty { supply: BEGIN[0] * supply, discrepancy_pa: BEGIN[1] * discrepancy_pa, noise_pa }
}

/// The posterior of a model with everything free that the recording can tell something of.
#[must_use]
pub fn posterior<'a>(
    data: &'a ChannelData,
    model: Extended,
    expectation: &Expectation,
    counted: &'a [bool],
) -> Posterior<'a> {
    let parameters = model.parameters(&data.plant);
    let base = data.plant.parameters().len();
    let free: Vec<usize> = free_base(data).into_iter().chain(base..parameters.len()).collect();
    let of_base = |k: usize| expected_of_base(data, &parameters[k], expectation.gain);
    let of = |&k: &usize| if k < base { of_base(k) } else { expected_of_effect(&parameters[k]) };
    let expected = free.iter().map(of).collect();
    Posterior { data, model, parameters, free, expected, scales: expectation.scales, stiff: false, counted }
}

/// Wide enough for any rig, and narrow enough that nothing wanders off where the recording says
/// nothing of it.
fn expected_of_base(data: &ChannelData, p: &Parameter, gain: f64) -> Expected {
    if p.name == "corner" {
        return ((CORNER * gain).ln(), 1.5);
    }
    let regulator = data.plant.model.is_regulator();
    match (regulator, p.scale) {
        (true, _) | (_, Scale::Logarithmic) => {
            let middle = if regulator { p.nominal } else { gain };
            if p.scale == Scale::Logarithmic {
                (middle.ln(), 2.0)
            } else {
                (middle, 0.4 * (p.upper - p.lower))
            }
        }
        // Leaks, edges, and the weight of the volume's rate.
        (_, Scale::Linear) if p.unit == "mm2" => (0.0, 30.0 * LEAK * gain),
        (_, Scale::Linear) if p.name == "volume_weight" => (p.nominal, 0.3),
        (_, Scale::Linear) => (p.nominal, 0.25),
    }
}

/// A linear size is expected near nothing, the logarithm of another anywhere between its bounds.
fn expected_of_effect(p: &Parameter) -> Expected {
    match p.scale {
        Scale::Linear => (p.nominal, 0.3 * (p.upper - p.lower)),
        Scale::Logarithmic => (0.5 * (p.lower.ln() + p.upper.ln()), 0.4 * (p.upper / p.lower).ln()),
    }
}
