//! The gate: is there anything of an effect in the residual at all?
//!
//! Every effect is simulated at a few sizes. What it changes in the readings, after the model's own
//! parameters have compensated for as much of it as they can, is a direction `d`; the score of a
//! quarter of a block is `z = r . d`. Under the null hypothesis the signs of the scores are random
//! however the residual is correlated within a block, so `|sum z| / sqrt(sum z^2)` is compared with
//! its largest value over the whole catalogue under random signs (a wild score bootstrap; Cameron,
//! Gelbach and Miller 2008 for few clusters, Westfall and Young 1993 for the maximum).

use crate::order::{ascending, descending};
use std::collections::{BTreeMap, BTreeSet};

use super::asked::Asked;
use super::cycles::{Cycles, Search, strongest_cycles};
use super::probe::{Probing, Trial};
use super::scores::{CLIP, DRAWS};
use crate::diagnosis::channel::ChannelData;
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::resampling::{generator, quantile, signs};
use crate::effects::catalogue::CATALOGUE;
use crate::parallel;

/// What the gate says about one effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Gate {
    /// Number of the effect.
    pub effect: usize,
    /// Largest statistic over probes, of all channels together or of any one.
    pub statistic: f64,
    /// Share of random-sign draws in which anything in the catalogue reaches it.
    pub p_value: f64,
}

/// Tries every effect in question on every channel.
#[must_use]
pub fn trials(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    asked: Asked<'_>,
    tick: &(dyn Fn() + Sync),
) -> Vec<Vec<Trial>> {
    // An effect that acts anywhere already is not asked about again elsewhere.
    let named = |effect: usize| stages.iter().any(|s| s.model.has(effect));
    let wanted = parallel::map(channels.iter().zip(stages), |(data, stage)| -> Vec<usize> {
        // What is a part of the base model is a cause only where it would be more than is usual.
        let at_rest = |effect: usize| stage.model.usual.contains(&effect) && !stage.is_held(data, effect);
        let asked = |effect: usize| asked.is_about(data, effect) && !named(effect) && !at_rest(effect);
        (0..CATALOGUE.len()).filter(|&effect| asked(effect)).collect()
    });
    let searched = wanted.iter().flatten().any(|&effect| CATALOGUE[effect].probes.is_empty());
    let cycles = if searched { strongest_cycles(channels, stages) } else { Cycles::default() };
    parallel::map(channels.iter().zip(stages).zip(wanted), |((data, stage), wanted)| {
        let probing = Probing::new(data, stage);
        let tried = parallel::map(wanted, |effect| {
            let tried = probing.try_effect(effect, &cycles);
            tick();
            tried
        });
        tried.into_iter().flatten().collect()
    })
}

/// Statistics of all effects and what of them chance explains.
#[must_use]
pub fn judge(trials: &[Vec<Trial>]) -> Vec<Gate> {
    // One test for every trial of every channel, and one for the same trial on all channels
    // together; what was searched for has its own.
    let by_score = || trials.iter().flatten().filter(|t| t.searched.is_none());
    let mut tests: Vec<(usize, bool, Vec<f64>)> =
        by_score().map(|t| (t.effect, t.one_sided, normalised(&t.scores))).collect();
    if trials.len() > 1 {
        let keys: BTreeSet<(usize, usize)> = by_score().map(|t| (t.effect, t.probe)).collect();
        for (effect, probe) in keys {
            let same: Vec<&Trial> =
                trials.iter().flatten().filter(|t| (t.effect, t.probe) == (effect, probe)).collect();
            let length = same.iter().map(|t| t.scores.len()).max().unwrap_or(0);
            let mut sum = vec![0.0; length];
            for trial in &same {
                for (s, z) in sum.iter_mut().zip(&trial.scores) {
                    *s += z;
                }
            }
            let one_sided = same.iter().all(|t| t.one_sided);
            tests.push((effect, one_sided, normalised(&sum)));
        }
    }
    let statistic = |one_sided: bool, z: &[f64], signs: Option<&[f64]>| {
        let sum: f64 = match signs {
            Some(signs) => z.iter().zip(signs).map(|(z, s)| z * s).sum(),
            None => z.iter().sum(),
        };
        if one_sided { sum } else { sum.abs() }
    };
    let length = tests.iter().map(|(_, _, z)| z.len()).max().unwrap_or(0);
    let draws: Vec<f64> = {
        let mut rng = generator(1);
        let drawn: Vec<Vec<f64>> = (0..DRAWS).map(|_| signs(&mut rng, length)).collect();
        parallel::map(drawn.iter(), |s| {
            tests.iter().map(|(_, one, z)| statistic(*one, z, Some(s))).fold(0.0, f64::max)
        })
    };
    let mut gates: Vec<Gate> = Vec::new();
    for (effect, one_sided, z) in &tests {
        let value = statistic(*one_sided, z, None);
        match gates.iter_mut().find(|g| g.effect == *effect) {
            Some(gate) => gate.statistic = gate.statistic.max(value),
            None => gates.push(Gate { effect: *effect, statistic: value, p_value: 1.0 }),
        }
    }
    for gate in &mut gates {
        let reached = draws.iter().filter(|d| **d >= gate.statistic).count();
        gate.p_value = (reached + 1) as f64 / (DRAWS + 1) as f64;
    }
    let found = trials.iter().flatten().filter_map(|t| Some((t.effect, t.searched?)));
    let found: BTreeMap<usize, Search> = found.collect();
    gates.extend(found.into_iter().map(|(effect, Search { statistic, p_value })| Gate {
        effect,
        statistic,
        p_value,
    }));
    descending(&mut gates, |gate| gate.statistic);
    ascending(&mut gates, |gate| gate.p_value);
    gates
}

/// Scores clipped and scaled to unit length. One part of a block with a movement like no other
/// would otherwise rule the sum; clipping is odd, so random signs remain right under the null
/// hypothesis.
fn normalised(z: &[f64]) -> Vec<f64> {
    let mut sizes: Vec<f64> = z.iter().map(|v| v.abs()).filter(|v| *v > 0.0).collect();
    sizes.sort_by(f64::total_cmp);
    let most = if sizes.is_empty() { 0.0 } else { CLIP * quantile(&sizes, 0.75) };
    let clipped: Vec<f64> = z.iter().map(|v| v.clamp(-most, most)).collect();
    let length = clipped.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length > 0.0 { clipped.iter().map(|v| v / length).collect() } else { clipped }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::channel::Extended;

    fn trial(scores: Vec<f64>) -> Trial {
        let start = Extended::base(Vec::new());
        Trial {
            effect: 0,
            probe: 0,
            start,
            scores,
            direction: Vec::new(),
            loss: 0.0,
            promise: 0.0,
            one_sided: false,
            searched: None,
        }
    }

    #[test]
    fn what_was_searched_for_is_judged_by_the_chance_of_its_search_alone() {
        let search = Search { statistic: 4.2, p_value: 0.002 };
        let found = Trial { effect: 1, searched: Some(search), ..trial(vec![0.0; 40]) };
        let gates = judge(&[vec![trial(vec![1.0; 40]), found]]);
        let of_search: Vec<&Gate> = gates.iter().filter(|gate| gate.effect == 1).collect();
        assert_eq!(of_search, [&Gate { effect: 1, statistic: 4.2, p_value: 0.002 }]);
        assert!(gates.iter().any(|gate| gate.effect == 0 && gate.p_value < 0.01));
    }

    #[test]
    fn one_huge_score_neither_passes_nor_hides_the_others() {
        // Consistent scores pass, also beside one that is a thousand times as large ...
        let mut scores = vec![1.0; 40];
        assert!(judge(&[vec![trial(scores.clone())]])[0].p_value < 0.01);
        scores[0] = 1000.0;
        assert!(judge(&[vec![trial(scores)]])[0].p_value < 0.01);
        // ... which says nothing by itself.
        let mut scores: Vec<f64> = (0..40).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        scores[0] = 1000.0;
        assert!(judge(&[vec![trial(scores)]])[0].p_value > 0.1);
    }
}
