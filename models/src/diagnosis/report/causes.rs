//! From what the search found to the causes of a report.

use crate::diagnosis::settings::SETTINGS;
use std::collections::BTreeMap;

use super::earned::{stands_out, usual};
use crate::diagnosis::channel::{ChannelData, Role};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::inference::{Coordinate, Determined, as_estimated, determines, interval, pool};
use crate::diagnosis::json::{Cause, Estimate, Gain};
use crate::diagnosis::rollout_errors::BlockErrors;
use crate::diagnosis::selection::{Found, Outcome, staged};
use crate::effects::catalogue::CATALOGUE;
use crate::effects::{EffectInfo, EffectParameter, Reach};
use crate::model::Scale;
use crate::order::descending;
use crate::parallel;

/// What was found, with sizes and gains on the test blocks, where the final models leave
/// `final_errors`; the largest gain first.
pub fn measured_causes(
    channels: &[ChannelData],
    outcome: &Outcome,
    final_errors: &BlockErrors,
    change: bool,
) -> Vec<Cause> {
    let weighed = |stages: &[ChannelStage]| BlockErrors::weighted(channels, stages);
    let final_weighed = weighed(&outcome.stages);
    let determined: Vec<Determined<'_>> =
        channels.iter().zip(&outcome.stages).map(|(data, stage)| Determined::new(data, stage)).collect();
    let measured = |found: &Found| {
        let without = staged(channels, found.without.clone(), change);
        let weighted_ci95 = weighed(&without).gain(&final_weighed).ci95;
        let plain = BlockErrors::of(channels, &found.without, &[Role::Test]).gain(final_errors);
        let gain = Gain { weighted_ci95, ..plain };
        cause(channels, outcome, &determined, (found, gain), change)
    };
    let mut causes: Vec<Cause> = outcome.causes.iter().map(measured).collect();
    descending(&mut causes, |item| item.gain.reduction);
    causes
}

/// A found cause as the report has it: where it acts, its parameters with their intervals, its
/// rivals and its gain.
///
/// Where the size is usual over all channels and beyond that on some, it acts on those: a name
/// covers what is wrong, not what is sound. What all channels share acts on all or none. Since a
/// calibration (`change`), every size counts.
fn cause(
    channels: &[ChannelData],
    outcome: &Outcome,
    determined: &[Determined<'_>],
    (found, gain): (&Found, Gain),
    change: bool,
) -> Cause {
    let info = CATALOGUE[found.effect];
    let acting: Vec<(usize, &ChannelData)> =
        channels.iter().enumerate().filter(|(k, _)| found.acts[*k]).collect();
    let mut by_channel: ByChannel = parallel::map(acting.iter(), |(k, data)| {
        let stage = &outcome.stages[*k];
        let known = found.errors.as_ref().map(|errors| as_estimated(data, stage, found.effect, &errors[*k]));
        (data.id.to_string(), known.unwrap_or_else(|| determined[*k].coordinates(found.effect)))
    });
    let looped = channels.iter().any(|data| data.inputs.in_loop());
    if !change && let Some(odd) = odd_channels(info, &by_channel, looped) {
        by_channel = odd;
    }
    let sizes = named(info, pooled(info, &by_channel));
    Cause {
        effect: info.id.to_owned(),
        channels: by_channel.iter().map(|(id, _)| id.clone()).collect(),
        equivalent: found.equivalent.iter().map(|&e| CATALOGUE[e].id.to_owned()).collect(),
        parameters: sizes,
        by_channel: by_channel.into_iter().map(|(id, c)| (id, named(info, c))).collect(),
        p_value: found.p_value,
        probability: None,
        gain,
    }
}

/// What was estimated of an effect, by the channel's id.
type ByChannel = Vec<(String, Vec<Coordinate>)>;

/// Those of the channels on which an effect stands out, where over all of them it is usual.
fn odd_channels(info: &EffectInfo, by_channel: &ByChannel, looped: bool) -> Option<ByChannel> {
    if info.reach == Reach::Rig || !usual(info, &named(info, pooled(info, by_channel)), looped) {
        return None;
    }
    let mut odd = by_channel.clone();
    odd.retain(|(_, coordinates)| stands_out(info, &named(info, coordinates.clone()), looped));
    (!odd.is_empty()).then_some(odd)
}

/// The parameters of an effect by name.
fn named(info: &EffectInfo, estimates: Vec<Coordinate>) -> BTreeMap<String, Estimate> {
    info.parameters.iter().zip(estimates).map(|(p, c)| (p.name.to_owned(), estimate(p, &c))).collect()
}

/// Each parameter over the channels.
fn pooled(info: &EffectInfo, by_channel: &ByChannel) -> Vec<Coordinate> {
    let over_channels = |k: usize| -> Option<Coordinate> {
        let all: Vec<Coordinate> = by_channel.iter().filter_map(|(_, c)| c.get(k).cloned()).collect();
        pool(&all, expected_spread(&info.parameters[k], &all))
    };
    (0..info.parameters.len()).filter_map(over_channels).collect()
}

/// Standard deviation, on the scale of fitting, by which sizes are expected to differ between
/// channels.
fn expected_spread(p: &EffectParameter, channels: &[Coordinate]) -> f64 {
    match p.scale {
        Scale::Linear => {
            let mean = channels.iter().map(|c| c.value).sum::<f64>() / channels.len().max(1) as f64;
            SETTINGS.size_spread * p.distance(mean)
        }
        Scale::Logarithmic => SETTINGS.size_spread,
    }
}

fn estimate(p: &EffectParameter, c: &Coordinate) -> Estimate {
    let value = p.scale.value(c.value);
    let ends = interval(c, p.scale).map(|ends| ends.map(|v| v.clamp(p.lower, p.upper)));
    let open = c.reach.iter().all(|r| r.is_infinite());
    let flat = open || ends.is_none_or(|ends| !determines(p.scale, ends, [p.lower, p.upper]));
    Estimate {
        value,
        ci95: if flat { None } else { ends },
        unit: p.unit.to_owned(),
        state: if flat { "not identifiable here" } else { "identified" }.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::catalogue::index_of;

    /// One size on four channels, each known to a hundredth of what is usual; `odd` times what is
    /// usual on the last.
    fn sizes(effect: &str, odd: f64) -> (&'static EffectInfo, ByChannel) {
        let info = CATALOGUE[index_of(effect).expect(effect)];
        let parameter = &info.parameters[0];
        let coordinate = |size: f64| Coordinate {
            value: parameter.null + size * parameter.usual,
            error: 0.01 * parameter.usual,
            by_block: Vec::new(),
            freedom: 100.0,
            reach: [1.0; 2],
            as_likely: [0.0; 2],
            halving: 0.0,
            considered: 0.0,
        };
        let channels = ["b0c0", "b0c1", "b0c2", "b0c3"].into_iter().zip([0.1, 0.1, 0.1, odd]);
        (info, channels.map(|(id, size)| (id.to_owned(), vec![coordinate(size)])).collect())
    }

    #[test]
    fn an_effect_of_one_channel_acts_on_that() {
        let (info, by_channel) = sizes("transport_delay", 3.0);
        let odd = odd_channels(info, &by_channel, false).expect("one that stands out");
        assert_eq!(odd.into_iter().map(|(id, _)| id).collect::<Vec<_>>(), ["b0c3"]);
        let (info, alike) = sizes("transport_delay", 0.1);
        assert_eq!(odd_channels(info, &alike, false), None);
    }

    #[test]
    fn what_all_channels_share_acts_on_all_or_none() {
        let (info, by_channel) = sizes("supply_sag", 3.0);
        assert_eq!(odd_channels(info, &by_channel, true), None);
    }
}
