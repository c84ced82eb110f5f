//! From what the search found to the causes of a report.

use crate::diagnosis::settings::SETTINGS;
use std::collections::BTreeMap;

use super::earned::{stands_out, usual};
use crate::diagnosis::channel::ChannelData;
use crate::diagnosis::inference::{Coordinate, as_estimated, coordinates, interval, pool};
use crate::diagnosis::json::{Cause, Estimate, Gain};
use crate::diagnosis::selection::{Found, Outcome};
use crate::effects::catalogue::CATALOGUE;
use crate::effects::{EffectInfo, EffectParameter};
use crate::model::Scale;
use crate::parallel;

/// A found cause as the report has it: where it acts, its parameters with their intervals, its rivals and its gain.
///
/// Where the size is usual over all channels and beyond that on some, it acts on those: a name covers what is wrong, not what is sound. Since
/// a calibration (`change`), every size counts.
pub fn cause(channels: &[ChannelData], outcome: &Outcome, found: &Found, gain: Gain, change: bool) -> Cause {
    let info = CATALOGUE[found.effect];
    let acting: Vec<(usize, &ChannelData)> =
        channels.iter().enumerate().filter(|(k, _)| found.acts[*k]).collect();
    let mut by_channel: Vec<(String, Vec<Coordinate>)> = parallel::map(acting.iter(), |(k, data)| {
        let stage = &outcome.stages[*k];
        let known = found.errors.as_ref().map(|errors| as_estimated(data, stage, found.effect, &errors[*k]));
        (data.id.to_string(), known.unwrap_or_else(|| coordinates(data, stage, found.effect)))
    });
    let named = |estimates: Vec<Coordinate>| -> BTreeMap<String, Estimate> {
        info.parameters.iter().zip(estimates).map(|(p, c)| (p.name.to_owned(), estimate(p, &c))).collect()
    };
    let mut sizes = named(pooled(info, &by_channel));
    let looped = channels.iter().any(|data| data.inputs.in_loop());
    if !change && usual(info, &sizes, looped) {
        let mut odd = by_channel.clone();
        odd.retain(|(_, coordinates)| stands_out(info, &named(coordinates.clone())));
        if !odd.is_empty() {
            sizes = named(pooled(info, &odd));
            by_channel = odd;
        }
    }
    Cause {
        effect: info.id.to_owned(),
        channels: by_channel.iter().map(|(id, _)| id.clone()).collect(),
        equivalent: found.equivalent.iter().map(|&e| CATALOGUE[e].id.to_owned()).collect(),
        parameters: sizes,
        by_channel: by_channel.into_iter().map(|(id, c)| (id, named(c))).collect(),
        p_value: found.p_value,
        probability: None,
        gain,
    }
}

/// Each parameter over the channels.
fn pooled(info: &EffectInfo, by_channel: &[(String, Vec<Coordinate>)]) -> Vec<Coordinate> {
    let over_channels = |k: usize| -> Option<Coordinate> {
        let all: Vec<Coordinate> = by_channel.iter().filter_map(|(_, c)| c.get(k).cloned()).collect();
        pool(&all)
    };
    (0..info.parameters.len()).filter_map(over_channels).collect()
}

fn estimate(p: &EffectParameter, c: &Coordinate) -> Estimate {
    let value = match p.scale {
        Scale::Linear => c.value,
        Scale::Logarithmic => c.value.exp(),
    };
    let ends = interval(c, p.scale).map(|ends| ends.map(|v| v.clamp(p.lower, p.upper)));
    let open = c.reach.iter().all(|r| r.is_infinite());
    let flat = open
        || ends.is_none_or(|[low, high]| match p.scale {
            Scale::Linear => high - low > SETTINGS.flat * (p.upper - p.lower),
            Scale::Logarithmic => (high / low).ln() > SETTINGS.flat * (p.upper / p.lower).ln(),
        });
    Estimate {
        value,
        ci95: if flat { None } else { ends },
        unit: p.unit.to_owned(),
        state: if flat { "not identifiable here" } else { "identified" }.to_owned(),
    }
}
