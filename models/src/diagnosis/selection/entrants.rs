//! What a round of the search looks at.

use super::acceptance::{kept_total, least_share};
use super::candidate::{Starts, first_look};
use crate::diagnosis::channel::{ChannelData, OPEN};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::likelihood::{block_losses, total};
use crate::diagnosis::screening::{Gate, Trial};
use crate::diagnosis::settings::SETTINGS;
use crate::order::ascending;
use crate::parallel;

/// Candidates that are looked at in a round at most.
const MOST_LOOKS: usize = 10;
/// Candidates that promise less than this part of the best promise are not looked at.
const PROMISE: f64 = 0.2;
/// The same for this part of what a name would need: a refit finds more than a probe promises, but
/// hardly where little is left.
const HOPEFUL: f64 = 0.75;
/// Evaluations of the model that a first look may spend on each start.
pub const LOOK: usize = 4;
/// Effects that miss more than this part of the best gain on the channel with the largest error are
/// not looked at on all.
const NEAR: f64 = 0.6;

/// What a round refits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Entrants {
    /// What passed the gate and promises enough.
    Passed,
    /// Whatever was tried. The gate sees only what lies straight ahead, and beside what bends a
    /// model, like a tube, the way to what is missing is not straight. What wins without it must
    /// stand out of chance where it ends.
    Everything,
}

/// What a round begins with.
#[derive(Clone, Copy)]
pub struct Field<'a> {
    /// The channels.
    pub channels: &'a [ChannelData],
    /// Where the rounds before have left them.
    pub stages: &'a [ChannelStage],
    /// What was tried beside that, channel by channel.
    pub tried: &'a [Vec<Trial>],
    /// What the gate says of it, effect by effect.
    pub gates: &'a [Gate],
}

/// Effects that are worth a look, and from where it begins.
pub fn to_look_at(
    Field { channels, stages, tried, gates }: Field<'_>,
    entrants: Entrants,
) -> (Vec<usize>, Starts) {
    if entrants == Entrants::Everything {
        let all = gates.iter().map(|gate| gate.effect);
        return (near_the_best(channels, stages, tried, all), Starts::TrialsAndSizes);
    }
    let whole = kept_total(channels, stages);
    let passed = gates.iter().filter(|gate| gate.p_value <= SETTINGS.level);
    let mut promising: Vec<(f64, usize)> =
        passed.map(|gate| (promise(channels, stages, tried, gate.effect), gate.effect)).collect();
    ascending(&mut promising, |item| item.0);
    let promised = promising.first().map_or(0.0, |p| whole - p.0);
    let needed = whole * (1.0 - (1.0 - least_share(channels, stages)).powi(2));
    let least = (PROMISE * promised).max(HOPEFUL * needed);
    promising.retain(|p| whole - p.0 >= least);
    promising.truncate(MOST_LOOKS);
    (promising.into_iter().map(|(_, effect)| effect).collect(), Starts::Trials)
}

/// Of many effects, those that come near the best of them on the channel with the largest error: a
/// look at that is enough to leave out the others.
fn near_the_best(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    tried: &[Vec<Trial>],
    effects: impl Iterator<Item = usize>,
) -> Vec<usize> {
    let left = |k: usize| total(&channels[k], &stages[k].losses.deviance, &OPEN);
    let Some(worst) = (0..channels.len()).max_by(|&a, &b| left(a).total_cmp(&left(b))) else {
        return Vec::new();
    };
    let only = worst..=worst;
    let looked: Vec<(usize, f64)> = parallel::map(effects, |effect| {
        let (channels, stages, tried) =
            (&channels[only.clone()], &stages[only.clone()], &tried[only.clone()]);
        let look = first_look(channels, stages, tried, (effect, Starts::TrialsAndSizes), LOOK);
        (effect, left(worst) - total(&channels[0], &look.losses[0].deviance, &OPEN))
    });
    let most = looked.iter().map(|look| look.1).fold(0.0, f64::max);
    looked
        .into_iter()
        .filter(|look| look.1 > 0.0 && look.1 >= (1.0 - NEAR) * most)
        .map(|look| look.0)
        .collect()
}

/// Sum over the channels of the least loss that a probe promises.
fn promise(channels: &[ChannelData], stages: &[ChannelStage], tried: &[Vec<Trial>], effect: usize) -> f64 {
    let mut sum = 0.0;
    for ((data, stage), trials) in channels.iter().zip(stages).zip(tried) {
        let kept = total(data, &stage.losses.deviance, &OPEN);
        let own = total(data, &block_losses(data, &stage.residuals), &OPEN);
        let least =
            trials.iter().filter(|t| t.effect == effect).map(|t| t.promise).fold(f64::INFINITY, f64::min);
        sum += kept + (least - own).min(0.0);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::screening::{judge, trials};
    use crate::diagnosis::testing::{STRUCTURE, channel, fitted, measured, with};
    use crate::effects::catalogue::CATALOGUE;

    #[test]
    fn of_the_whole_catalogue_only_what_comes_near_the_best_is_looked_at_everywhere() {
        let (data, base) = channel(false);
        // On the first channel alone, behind a gate that is shut.
        let truths = [with(&data, &base, "valve_lag", &[0.05]), base.clone()];
        let channels = [0, 1].map(|k| measured(data.clone(), &truths[k], k as u64));
        let stages = channels.each_ref().map(|data| fitted(data, &base));
        let tried = trials(&channels, &stages, STRUCTURE, &|| {});
        let mut gates = judge(&tried);
        gates.iter_mut().for_each(|gate| gate.p_value = 1.0);
        let field = Field { channels: &channels, stages: &stages, tried: &tried, gates: &gates };
        let ids = |entrants: Entrants| -> Vec<&str> {
            let (looked, _) = to_look_at(field, entrants);
            looked.into_iter().map(|effect| CATALOGUE[effect].id).collect()
        };
        assert_eq!(ids(Entrants::Passed), Vec::<&str>::new());
        let near = ids(Entrants::Everything);
        assert!(near.contains(&"valve_lag") && !near.contains(&"exhaust_leak"), "{near:?}");
        assert!(2 * near.len() < gates.len(), "{near:?} of {}", gates.len());
    }
}
