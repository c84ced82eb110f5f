//! The gate: is there anything of an effect in the residual at all?
//!
//! Every effect is simulated at a few sizes. What it changes in the readings, after the model's own parameters have compensated for
//! as much of it as they can, is a direction `d`; the score of a quarter of a block is `z = r . d`. Under the null hypothesis the signs of
//! the scores are random however the residual is correlated within a block, so `|sum z| / sqrt(sum z^2)` is compared with its largest
//! value over the whole catalogue under random signs (a wild score bootstrap; Cameron, Gelbach and Miller 2008 for few
//! clusters, Westfall and Young 1993 for the maximum).

use std::sync::OnceLock;

use rayon::prelude::*;

use super::blocks::Role;
use super::channel::{ChannelData, Extended};
use super::random::{generator, quantile, signs};
use super::ripple::{Cycle, strongest_cycle};
use super::stage::{ChannelStage, OPEN};
use crate::effects::catalogue::CATALOGUE;
use crate::effects::{Domain, DriveInput, Kind, Question};
use crate::model::Scale;

/// Draws of random signs.
const DRAWS: usize = 999;
/// Largest score, in upper quartiles of their sizes.
const CLIP: f64 = 5.0;
/// Parts of a block with a score of their own.
const PARTS: usize = 4;

/// A direction that takes no more than this part out of the squared residual is not followed further.
const HOPELESS: f64 = 0.002;

/// One size of one effect, tried on one channel.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Number of the effect in the catalogue.
    pub effect: usize,
    /// Number of the probe.
    pub probe: usize,
    /// The model with the effect at this size and its other parameters compensating: where a fit starts.
    pub start: Extended,
    /// Scores, in the order of the blocks; zero where a block does not count.
    pub scores: Vec<f64>,
    /// Sum of squared whitened residuals of `start` on the open blocks.
    pub loss: f64,
    /// The same at the best size along the direction, at which an effect smaller or larger than the probe is not worse off.
    pub promise: f64,
    /// Does only one sign of the score speak for the effect?
    pub one_sided: bool,
}

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

/// Can this effect be asked about on this channel?
#[must_use]
pub fn applicable(data: &ChannelData, effect: usize, question: Question) -> bool {
    let info = CATALOGUE[effect];
    let domain = match data.plant.kind {
        Kind::Linear => info.domain != Domain::Valve,
        Kind::Nonlinear(_) => info.domain != Domain::Regulator,
    };
    let known = match info.id {
        "chamber_coupling" => !data.inputs.opposite_pa.is_empty(),
        "sensor_crosstalk" => !data.inputs.sampled_before_pa.is_empty(),
        // Two valves have a gain each in the base model.
        "valve_asymmetry" => !matches!(data.inputs.drive, DriveInput::Separate { .. }),
        _ => true,
    };
    // A regulator's base model has no parameters of its parts: what has changed in it is an effect that was not there.
    let asked = info.question == question
        || (info.question == Question::Foil && question == Question::Structure)
        || data.plant.kind == Kind::Linear;
    domain && known && asked
}

/// Tries every effect in question on every channel.
#[must_use]
pub fn trials(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    question: Question,
    tick: &(dyn Fn() + Sync),
) -> Vec<Vec<Trial>> {
    // An effect that acts anywhere already is not asked about again elsewhere.
    let named = |effect: usize| stages.iter().any(|s| s.model.effects.contains(&effect));
    channels
        .par_iter()
        .zip(stages)
        .map(|(data, stage)| {
            let wanted: Vec<usize> =
                (0..CATALOGUE.len()).filter(|&e| applicable(data, e, question) && !named(e)).collect();
            let searched = OnceLock::new();
            let cycle = || *searched.get_or_init(|| strongest_cycle(data, stage));
            wanted
                .par_iter()
                .flat_map(|&effect| {
                    let tried = try_effect(data, stage, effect, &cycle);
                    tick();
                    tried
                })
                .collect()
        })
        .collect()
}

fn try_effect(
    data: &ChannelData,
    stage: &ChannelStage,
    effect: usize,
    cycle: &(dyn Fn() -> Option<Cycle> + Sync),
) -> Vec<Trial> {
    let info = CATALOGUE[effect];
    let searched = info.probes.is_empty();
    let probes: Vec<Vec<f64>> = if searched {
        cycle().map_or_else(Vec::new, |cycle| cycle.probes(info.id))
    } else {
        info.probes.iter().map(|p| p.to_vec()).collect()
    };
    let first = info.parameters[0];
    let one_sided = first.null <= first.lower || first.null >= first.upper;
    probes
        .iter()
        .enumerate()
        .filter_map(|(probe, values)| try_probe(data, stage, effect, values).map(|t| (probe, t)))
        .map(|(probe, (start, direction, loss, promise))| Trial {
            effect,
            probe,
            start,
            // A probe that was found by searching the fit blocks is judged on the others.
            scores: scores(
                data,
                &stage.residuals,
                &direction,
                if searched { &[Role::Select] } else { &OPEN },
            ),
            loss,
            promise,
            one_sided: one_sided || searched,
        })
        .collect()
}

/// The model with an effect at one size, what it changes in the whitened readings, its loss on the open blocks, and what the best size promises.
fn try_probe(
    data: &ChannelData,
    stage: &ChannelStage,
    effect: usize,
    values: &[f64],
) -> Option<(Extended, Vec<f64>, f64, f64)> {
    let mut model = stage.model.with(&data.plant, effect, values);
    let parameters = stage.model.parameters(&data.plant);
    let inserted = model.range(&data.plant, effect)?;
    let position = |k: usize| if k < inserted.start { k } else { k + inserted.len() };
    let change = |model: &Extended| {
        let mut d = data.readings(model);
        d.iter_mut().zip(&stage.readings).for_each(|(y, y0)| *y = (*y - y0) / data.noise_kpa);
        stage.whitening.apply(&mut d);
        d
    };
    // The model's own parameters give way, first to keep the readings where they were.
    let give_way = |model: &mut Extended, coefficients: &[f64]| {
        for (&k, c) in stage.free.iter().zip(coefficients) {
            let p = &parameters[k];
            let value = &mut model.values[position(k)];
            *value = match p.scale {
                Scale::Linear => *value + c,
                Scale::Logarithmic => *value * c.clamp(-2.0, 2.0).exp(),
            }
            .clamp(p.lower, p.upper);
        }
    };
    let d = change(&model);
    let along = stage.project(data, &d);
    let back: Vec<f64> = along.iter().map(|c| -c).collect();
    give_way(&mut model, &back);
    let mut linear = d;
    stage.remove(&mut linear, &along);
    let [own, dot, square] = products(data, &stage.residuals, &linear);
    if !(dot * dot > HOPELESS * own * square) {
        // Next to nothing of this is in the residual: what the parameters would do exactly is not worth a simulation.
        return linear.iter().all(|v| v.is_finite()).then_some((
            model,
            linear,
            own - 2.0 * dot + square,
            own,
        ));
    }
    let mut d = change(&model);
    if !d.iter().all(|v| v.is_finite()) {
        return None;
    }
    // Then, for the start of a fit, to come as close to the measurement as they can.
    let mut closest: Vec<f64> = stage.residuals.iter().zip(&d).map(|(r, d)| r - d).collect();
    let forward = stage.project(data, &closest);
    let rest = stage.project(data, &d);
    stage.remove(&mut d, &rest);
    stage.remove(&mut closest, &forward);
    let loss = data
        .blocks
        .iter()
        .zip(&data.spans)
        .filter(|(b, _)| OPEN.contains(&b.role))
        .map(|(_, span)| closest[span.clone()].iter().map(|v| v * v).sum::<f64>())
        .sum();
    give_way(&mut model, &forward);
    let [own, dot, square] = products(data, &stage.residuals, &d);
    let scaled = if dot > 0.0 { own - dot * dot / square } else { own };
    Some((model, d, loss, loss.min(scaled)))
}

/// Products on the open blocks: residual by itself, by a direction, and the direction by itself.
fn products(data: &ChannelData, residuals: &[f64], direction: &[f64]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for (_, span) in data.blocks.iter().zip(&data.spans).filter(|(b, _)| OPEN.contains(&b.role)) {
        for (r, d) in residuals[span.clone()].iter().zip(&direction[span.clone()]) {
            sums = [sums[0] + r * r, sums[1] + r * d, sums[2] + d * d];
        }
    }
    sums
}

fn scores(data: &ChannelData, residuals: &[f64], direction: &[f64], roles: &[Role]) -> Vec<f64> {
    let mut scores = Vec::with_capacity(data.spans.len() * PARTS);
    for (block, span) in data.blocks.iter().zip(&data.spans) {
        let length = span.len();
        for part in 0..PARTS {
            let range = span.start + part * length / PARTS..span.start + (part + 1) * length / PARTS;
            let counts = roles.contains(&block.role);
            let score: f64 = range.map(|row| residuals[row] * direction[row]).sum();
            scores.push(if counts { score } else { 0.0 });
        }
    }
    scores
}

/// Statistics of all effects and what of them chance explains.
#[must_use]
pub fn judge(trials: &[Vec<Trial>]) -> Vec<Gate> {
    // One test for every trial of every channel, and one for the same trial on all channels together.
    let mut tests: Vec<(usize, bool, Vec<f64>)> = Vec::new();
    for channel in trials {
        tests.extend(channel.iter().map(|t| (t.effect, t.one_sided, normalised(&t.scores))));
    }
    if trials.len() > 1 {
        let keys: std::collections::BTreeSet<(usize, usize)> =
            trials.iter().flatten().map(|t| (t.effect, t.probe)).collect();
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
        drawn
            .par_iter()
            .map(|s| tests.iter().map(|(_, one, z)| statistic(*one, z, Some(s))).fold(0.0, f64::max))
            .collect()
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
    gates.sort_by(|a, b| a.p_value.total_cmp(&b.p_value).then(b.statistic.total_cmp(&a.statistic)));
    gates
}

/// Scores clipped and scaled to unit length. One part of a block with a movement like no other would otherwise rule the sum; clipping is
/// odd, so random signs remain right under the null hypothesis.
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

    fn trial(scores: Vec<f64>) -> Trial {
        let start = Extended::base(Vec::new());
        Trial { effect: 0, probe: 0, start, scores, loss: 0.0, promise: 0.0, one_sided: false }
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
