//! Effects that passed the gate, refitted in earnest.

use crate::diagnosis::channel::{ChannelData, Extended, OPEN, Role};
use crate::diagnosis::estimation::{ChannelStage, fit_from, plain_costs};
use crate::diagnosis::evidence::{Explanation, Missing};
use crate::diagnosis::likelihood::{Losses, hunts, least_gain, row_count, total, whitened_residuals};
use crate::diagnosis::resampling::bootstrap;
use crate::diagnosis::screening::Trial;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::CATALOGUE;
use crate::effects::{Question, Reach};
use crate::order::ascending;
use crate::parallel;

/// Starts of a first look on a channel.
const STARTS: usize = 2;
/// A second start is looked at when what it promises is not worse by more than this factor.
const SECOND: f64 = 1.5;

/// One effect refitted on every channel.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Number of the effect.
    pub effect: usize,
    /// Models with it, channel by channel; the stage's where it does not act.
    pub models: Vec<Extended>,
    /// Where it acts.
    pub acts: Vec<bool>,
    /// What they leave, channel by channel.
    pub losses: Vec<Losses>,
}

impl Candidate {
    /// As an explanation, beside effects that were named before. A foil stands for causes outside
    /// the catalogue.
    #[must_use]
    pub fn explanation(&self, named: &[usize]) -> Explanation {
        let missing = if CATALOGUE[self.effect].question == Question::Foil {
            Missing::SomethingElse(named.to_vec())
        } else {
            Missing::Effects(named.iter().copied().chain([self.effect]).collect())
        };
        Explanation { missing, models: self.models.clone() }
    }
}

/// From where a first look at an effect begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Starts {
    /// The best trials, in which the other parameters have made way along their derivatives.
    Trials,
    /// These, and the effect in its best sizes beside parameters that stay where they are:
    /// derivatives lead nowhere where a model is far from straight.
    TrialsAndSizes,
}

/// Looks at one effect on every channel with some evaluations of the model.
#[must_use]
pub fn first_look(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    trials: &[Vec<Trial>],
    (effect, from): (usize, Starts),
    evaluations: usize,
) -> Candidate {
    let fitted = parallel::map(channels.iter().zip(stages).zip(trials), |((data, stage), trials)| {
        let mut starts = best_trials(trials, effect);
        if from == Starts::TrialsAndSizes {
            starts.extend(best_sizes(data, stage, effect));
        }
        let fitted = starts.iter().map(|start| {
            let model = fit_from(data, stage, start, effect, evaluations);
            let losses = losses_of(data, stage, &model);
            (total(data, &losses.deviance, &[Role::Fit]), model, losses)
        });
        match fitted.filter(|(loss, ..)| loss.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((_, model, losses)) => {
                let acts = acts(data, stage, &model, &losses);
                (model, losses, acts)
            }
            None => (stage.model.clone(), stage.losses.clone(), false),
        }
    });
    assemble(channels, stages, effect, fitted)
}

/// Where the best trials of an effect on a channel stand.
fn best_trials(trials: &[Trial], effect: usize) -> Vec<Extended> {
    let mut starts: Vec<&Trial> = trials.iter().filter(|t| t.effect == effect).collect();
    ascending(&mut starts, |item| item.loss);
    let limit = starts.first().map_or(0.0, |t| t.loss * SECOND);
    starts.into_iter().take(STARTS).filter(|t| t.loss <= limit).map(|t| t.start.clone()).collect()
}

/// The model of a channel with an effect in those of its sizes that describe the readings best.
fn best_sizes(data: &ChannelData, stage: &ChannelStage, effect: usize) -> Vec<Extended> {
    let with = |size: &&[f64]| stage.model.with(&data.plant, effect, size);
    let models: Vec<Extended> = CATALOGUE[effect].probes.iter().map(with).collect();
    let mut by_cost: Vec<(f64, Extended)> = plain_costs(data, &models).into_iter().zip(models).collect();
    ascending(&mut by_cost, |item| item.0);
    by_cost.into_iter().take(STARTS).map(|(_, model)| model).collect()
}

/// Refits a candidate with some more evaluations of the model, from where it stands.
#[must_use]
pub fn refit_further(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    before: &Candidate,
    evaluations: usize,
) -> Candidate {
    let effect = before.effect;
    let fitted = parallel::map(channels.iter().zip(stages).zip(&before.models), |((data, stage), before)| {
        if !before.has(effect) {
            return (stage.model.clone(), stage.losses.clone(), false);
        }
        let model = fit_from(data, stage, before, effect, evaluations);
        let losses = losses_of(data, stage, &model);
        let acts = acts(data, stage, &model, &losses);
        (model, losses, acts)
    });
    assemble(channels, stages, effect, fitted)
}

/// Decides on which channels an effect acts.
pub fn assemble(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    effect: usize,
    fitted: Vec<(Extended, Losses, bool)>,
) -> Candidate {
    let shared = CATALOGUE[effect].reach == Reach::Rig;
    let clear = fitted.iter().filter(|(_, _, acts)| *acts).count();
    let any = clear > 0;
    // Where most channels show it clearly, a channel that shows it faintly has it too.
    let common = 2 * clear >= fitted.len().max(2);
    let sizes: Vec<f64> =
        fitted.iter().zip(channels).map(|((model, ..), data)| size(data, model, effect)).collect();
    let largest = sizes.iter().copied().fold(0.0, f64::max);
    let mut candidate = Candidate { effect, models: Vec::new(), acts: Vec::new(), losses: Vec::new() };
    for (k, (model, losses, acts)) in fitted.into_iter().enumerate() {
        let faint = common && {
            let falls = |before: &[f64], after: &[f64]| {
                total(&channels[k], after, &OPEN) < total(&channels[k], before, &OPEN)
            };
            let before = &stages[k].losses;
            falls(&before.deviance, &losses.deviance) && falls(&before.beside_error, &losses.beside_error)
        };
        let traces = sizes[k] < CATALOGUE[effect].smallest.min(SETTINGS.trace * largest);
        let acts = (acts || faint) && !traces || shared && any;
        let acts = acts && model.has(effect);
        candidate.models.push(if acts { model } else { stages[k].model.clone() });
        candidate.losses.push(if acts { losses } else { stages[k].losses.clone() });
        candidate.acts.push(acts);
    }
    candidate
}

/// Distance of an effect's size from none, 0 where it does not act.
#[must_use]
pub fn size(data: &ChannelData, model: &Extended, effect: usize) -> f64 {
    let null = CATALOGUE[effect].parameters[0].null;
    let range = model.range(&data.plant, effect).filter(|_| model.has(effect));
    range.map_or(0.0, |range| (model.values[range.start] - null).abs())
}

pub fn losses_of(data: &ChannelData, stage: &ChannelStage, model: &Extended) -> Losses {
    let residuals = whitened_residuals(data, &stage.whitening, &data.readings(model));
    Losses::of_one(data, &stage.whitening, model, &residuals)
}

/// Does the effect improve this channel beyond what differences between blocks explain? Hunting
/// must explain more than a trace of the error: next to a channel that hunts, others do too in the
/// tiniest way.
pub fn acts(data: &ChannelData, stage: &ChannelStage, model: &Extended, after: &Losses) -> bool {
    let open = |losses: &[f64]| -> Vec<f64> {
        let pairs = data.blocks.iter().zip(losses);
        pairs.filter(|(b, _)| OPEN.contains(&b.role)).map(|(_, loss)| *loss).collect()
    };
    let before = &stage.losses;
    if !surely_less(&open(&before.deviance), &open(&after.deviance)) {
        return false;
    }
    if !hunts(data, model) || hunts(data, &stage.model) {
        return true;
    }
    let (before, after) = (open(&before.beside_error), open(&after.beside_error));
    let gain = before.iter().sum::<f64>() - after.iter().sum::<f64>();
    surely_less(&before, &after) && gain >= least_gain(row_count(data, &OPEN))
}

/// Is the sum over blocks less afterwards, whichever blocks had been recorded (at 97.5 %)? Not by a
/// standard error: what changes most in one or two blocks, as a leak does where the pressure stood
/// high for long, has a large one, however sure it is.
fn surely_less(before: &[f64], after: &[f64]) -> bool {
    let [low, ..] = bootstrap(before, after, |before, after| before - after);
    low > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, measured, with};
    use crate::effects::catalogue::index_of;

    /// Two channels of which the first has a lag of this size and the second another, each with its
    /// noise.
    fn refitted(lags: [f64; 2]) -> (Candidate, usize) {
        let (data, base) = channel(false);
        let lag = index_of("valve_lag").unwrap();
        let channels: Vec<ChannelData> = lags
            .iter()
            .zip(0..)
            .map(|(&size, seed)| measured(data.clone(), &with(&data, &base, "valve_lag", &[size]), seed))
            .collect();
        let stages: Vec<ChannelStage> =
            channels.iter().map(|data| ChannelStage::new(data, base.clone(), (0..7).collect())).collect();
        let trials: Vec<Vec<Trial>> = channels
            .iter()
            .zip(&stages)
            .map(|(data, stage)| {
                crate::diagnosis::screening::Probing::new(data, stage).try_effect(lag, &Default::default())
            })
            .collect();
        (first_look(&channels, &stages, &trials, (lag, Starts::Trials), 20), lag)
    }

    #[test]
    fn an_effect_is_refitted_where_it_acts_and_left_away_where_it_does_not() {
        let (candidate, lag) = refitted([0.02, 0.0]);
        assert_eq!(candidate.acts, [true, false]);
        let (data, _) = channel(false);
        let sizes: Vec<f64> = candidate.models.iter().map(|model| size(&data, model, lag)).collect();
        assert!((sizes[0] / 0.02 - 1.0).abs() < 0.05 && sizes[1] == 0.0, "{sizes:?}");
    }

    #[test]
    fn a_trace_beside_a_large_size_does_not_count_and_the_same_size_everywhere_does() {
        // A fortieth of the other's size is below what is worth a name, 2.5 ms.
        assert_eq!(refitted([0.04, 0.001]).0.acts, [true, false]);
        assert_eq!(refitted([0.02, 0.02]).0.acts, [true, true]);
    }

    #[test]
    fn what_gains_in_every_block_and_most_in_one_is_sure() {
        // Of a leak in a recording of a plant that others wrote.
        let before = [349.0, 24467.0, 938.0, 615.0, 454.0, 469.0, 447.0, 473.0, 8932.0];
        let after = [267.0, 379.0, 408.0, 374.0, 373.0, 364.0, 363.0, 354.0, 359.0];
        assert!(surely_less(&before, &after));
        // One block alone is no evidence: another recording may not have it.
        let one = [349.0, 24467.0, 408.0, 374.0, 373.0, 364.0, 363.0, 354.0, 359.0];
        let rest = [349.0, 379.0, 409.0, 374.5, 373.5, 364.5, 363.5, 354.5, 359.5];
        assert!(!surely_less(&one, &rest));
    }
}
