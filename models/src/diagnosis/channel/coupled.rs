//! Channels that depend on each other: each is simulated with what the others did the time before.

use super::data::ChannelData;
use super::model::Extended;
use super::neighbours::Pressures;
use super::variable::Variable;
use crate::data::ChannelId;
use crate::effects::catalogue::CATALOGUE;
use crate::effects::{EffectInfo, Series};
use crate::parallel;

/// Passes over all channels when one of them depends on the others.
const PASSES: usize = 4;

/// Traces (reading in kPa gauge, drive, flow drawn) of all channels, each with its neighbours as
/// simulated.
#[must_use]
pub fn settled(channels: &mut [ChannelData], models: &[Extended]) -> Vec<Vec<[f64; 3]>> {
    let needs =
        |what: fn(&EffectInfo) -> bool| models.iter().any(|m| m.effects.iter().any(|&e| what(CATALOGUE[e])));
    let corrected = |by| models.iter().filter_map(|m| m.correction.as_ref()).any(|c| c.variable == by);
    let pressures = needs(EffectInfo::needs_others_pressures) || corrected(Variable::Opposite);
    let draws = needs(EffectInfo::needs_others_draw) || corrected(Variable::OthersDraw);
    let traces = |channels: &[ChannelData]| -> Vec<Vec<[f64; 3]>> {
        parallel::map(channels.iter().zip(models), |(data, model)| data.trace(model))
    };
    let mut now = traces(channels);
    for _ in 0..if pressures || draws { PASSES } else { 0 } {
        if pressures {
            let simulated: Vec<(ChannelId, Series)> = channels
                .iter()
                .zip(&now)
                .map(|(data, trace)| (data.id, trace.iter().map(|row| row[0]).collect()))
                .collect();
            let simulated = Pressures::simulated(simulated);
            channels.iter_mut().for_each(|data| simulated.put_into(data));
        }
        if draws {
            share_draws(channels, models);
        }
        now = traces(channels);
    }
    now
}

/// Hands every channel the flow that the others draw from the supply, by their models.
pub fn share_draws(channels: &mut [ChannelData], models: &[Extended]) {
    let draws: Vec<Vec<f64>> = parallel::map(channels.iter().zip(models), |(data, model)| {
        data.trace(model).iter().map(|row| row[2].max(0.0)).collect()
    });
    let rows = draws.first().map_or(0, Vec::len);
    let mut total = vec![0.0; rows];
    for draw in &draws {
        for (t, d) in total.iter_mut().zip(draw) {
            *t += d;
        }
    }
    for (data, own) in channels.iter_mut().zip(&draws) {
        data.inputs.others_draw = total.iter().zip(own).map(|(t, o)| t - o).collect();
    }
}
