//! What stays unexplained: what the residual still depends on, how much it is, and a smooth
//! correction of it.

use crate::diagnosis::settings::SETTINGS;

use super::discrepancy_model::fit_correction;
use super::residual_test::{Dependence, dependences};
use crate::diagnosis::channel::{ChannelData, Extended, Role, Variable};
use crate::diagnosis::estimation::{ChannelStage, free_of};
use crate::diagnosis::json::{Corrected, Symptom};
use crate::diagnosis::likelihood::{is_hunting, row_count, select_total, total};
use crate::diagnosis::rollout_errors::BlockErrors;
use crate::diagnosis::selection::{Found, Outcome, staged};
use crate::effects::catalogue::CATALOGUE;
use crate::parallel;

fn matters(d: &Dependence) -> bool {
    d.p_value <= SETTINGS.level && d.share >= SETTINGS.dependence_share
}

/// What depends on what, before and after.
#[derive(Debug)]
pub struct Rest {
    /// Stages of the base models.
    pub base_stages: Vec<ChannelStage>,
    /// What their residuals depend on.
    pub symptoms: Vec<Dependence>,
    /// What those of the final models depend on.
    pub left: Vec<Dependence>,
    /// Part of the base models' error above the noise that is left.
    pub share: f64,
}

impl Rest {
    /// Of the models that a search found.
    #[must_use]
    pub fn new(channels: &[ChannelData], outcome: &Outcome, change: bool) -> Self {
        let base_stages: Vec<ChannelStage> =
            parallel::map(channels.iter().zip(&outcome.base), |(data, model)| {
                let free = if change { Vec::new() } else { free_of(data, model, false) };
                ChannelStage::new(data, model.clone(), free)
            });
        let symptoms = dependences(channels, &base_stages);
        let left =
            if outcome.causes.is_empty() { symptoms.clone() } else { dependences(channels, &outcome.stages) };
        let share = share_left(channels, &base_stages, &outcome.stages);
        Self { base_stages, symptoms, left, share }
    }

    /// Does a smooth function of one variable explain more of the base models' error than the names
    /// together? Then they only imitate something else. What makes a loop hunt counts only where
    /// it was named before anything else: later, it takes up what the others leave.
    #[must_use]
    pub fn imitated(&self, channels: &[ChannelData], outcome: &Outcome) -> bool {
        let loss = |stages: &[ChannelStage]| select_total(channels, stages.iter().map(|s| &s.losses));
        let makes_hunt = |cause: &&Found| {
            let looped = channels.iter().zip(&cause.acts).any(|(data, acts)| *acts && data.inputs.in_loop());
            looped && is_hunting(cause.effect)
        };
        let later = outcome.causes.iter().skip_while(makes_hunt).filter(makes_hunt);
        let taken_up: f64 = later.map(|cause| cause.gained).sum();
        let gained = loss(&self.base_stages) - loss(&outcome.stages) - taken_up;
        Variable::ALL.iter().any(|&variable| {
            let clear =
                self.symptoms.iter().filter(|d| d.variable == variable && d.p_value <= SETTINGS.level);
            clear.map(|d| d.explained.max(0.0)).sum::<f64>() > gained
        })
    }
}

/// Effects beside the first for which a smooth function of one measured variable, in their place,
/// explains more. Where something large is named, what is left of it has some pattern, and some
/// other effect always has a part of that.
#[must_use]
pub fn imitated_beside(channels: &[ChannelData], outcome: &Outcome) -> Vec<&'static str> {
    let most = outcome.causes.iter().map(|cause| cause.gained).fold(0.0, f64::max);
    let looped =
        |cause: &Found| channels.iter().zip(&cause.acts).any(|(data, acts)| *acts && data.inputs.in_loop());
    let beside = outcome.causes.iter().filter(|cause| cause.gained < most && !looped(cause));
    let imitated = beside.filter(|cause| {
        let stages = staged(channels, cause.without.clone(), false);
        let found = dependences(channels, &stages);
        let smooth = |variable: Variable| -> f64 {
            let clear = found.iter().filter(|d| d.variable == variable && d.p_value <= SETTINGS.level);
            clear.map(|d| d.explained.max(0.0)).sum()
        };
        Variable::ALL.into_iter().map(smooth).fold(0.0, f64::max) > cause.gained
    });
    imitated.map(|cause| CATALOGUE[cause.effect].id).collect()
}

/// What passes the test and is worth mention, each variable once.
#[must_use]
pub fn significant(channels: &[ChannelData], found: &[Dependence]) -> Vec<Symptom> {
    let mut named = Vec::new();
    let mut list: Vec<Symptom> = Vec::new();
    for d in found {
        if !matters(d) || named.contains(&d.variable.words()) {
            continue;
        }
        named.push(d.variable.words());
        list.push(Symptom {
            channel: channels[d.channel].id.to_string(),
            what: format!("the residual depends on {}", d.variable.words()),
            statistic: "sum of half-block scores over their root sum of squares".to_owned(),
            value: d.statistic,
            p_value: d.p_value,
            share: d.share,
        });
    }
    list
}

/// Part of the base models' squared whitened test residual above the noise that the final models
/// leave.
fn share_left(channels: &[ChannelData], base: &[ChannelStage], last: &[ChannelStage]) -> f64 {
    let mean = |stages: &[ChannelStage]| {
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for (data, stage) in channels.iter().zip(stages) {
            sum += total(data, &stage.losses.fair, &[Role::Test]);
            count += row_count(data, &[Role::Test]);
        }
        sum / count.max(1.0)
    };
    let above = mean(base) - 1.0;
    if above <= 0.05 { 0.0 } else { ((mean(last) - 1.0) / above).clamp(0.0, 1.0) }
}

/// The final models, each with a smooth correction along what its channel's residual depends on
/// most, where that helps.
#[must_use]
pub fn corrected(channels: &[ChannelData], stages: &[ChannelStage], left: &[Dependence]) -> Vec<Extended> {
    parallel::map(channels.iter().zip(stages).enumerate(), |(k, (data, stage))| {
        let along = left.iter().find(|d| d.channel == k && matters(d));
        let fitted = along.and_then(|d| fit_correction(data, stage, d));
        fitted.unwrap_or_else(|| stage.model.clone())
    })
}

/// What the corrections gain on the test blocks; `None` where there is none.
#[must_use]
pub fn correction_gain(
    channels: &[ChannelData],
    plain: &BlockErrors,
    corrected: &[Extended],
) -> Option<Corrected> {
    if corrected.iter().all(|m| m.correction.is_none()) {
        return None;
    }
    let after = BlockErrors::of(channels, corrected, &[Role::Test]);
    let by_channel = channels.iter().zip(corrected).filter_map(|(data, model)| {
        Some((data.id.to_string(), model.correction.as_ref()?.variable.words().to_owned()))
    });
    Some(Corrected { along: by_channel.collect(), gain: plain.gain(&after) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, measured, with};
    use crate::effects::catalogue::index_of;

    /// Where a loop hunts, something smooth explains half of what a cause that makes it hunt gains
    /// beside another one. Are the two imitated, named in this order?
    fn imitated_in_order(ids: [&str; 2]) -> bool {
        let (data, base) = channel(true);
        let sticking = with(&data, &base, "valve_stiction", &[0.1]);
        let channels = [measured(data, &sticking, 1)];
        let stages = staged(&channels, vec![sticking], true);
        let base_stages = staged(&channels, vec![base.clone()], true);
        let loss = |stages: &[ChannelStage]| select_total(&channels, stages.iter().map(|s| &s.losses));
        let gained = loss(&base_stages) - loss(&stages);
        assert!(gained > 0.0);
        let mut symptoms = dependences(&channels, &base_stages);
        symptoms.truncate(1);
        (symptoms[0].p_value, symptoms[0].explained) = (0.0, 0.5 * gained);
        let found = |id: &str| Found {
            effect: index_of(id).unwrap(),
            acts: vec![true],
            p_value: 0.0,
            equivalent: Vec::new(),
            without: vec![base.clone()],
            gained: if id == "valve_stiction" { 0.9 * gained } else { 0.1 * gained },
            rivals: Vec::new(),
            errors: None,
        };
        let outcome = Outcome {
            base: vec![base.clone()],
            causes: ids.map(found).to_vec(),
            stages,
            rounds: Vec::new(),
            explanations: Vec::new(),
            withheld: None,
            by_likelihood: false,
        };
        let rest = Rest { base_stages, symptoms, left: Vec::new(), share: 1.0 };
        rest.imitated(&channels, &outcome)
    }

    #[test]
    fn what_makes_a_loop_hunt_counts_where_it_is_named_first_and_not_where_it_takes_up_the_rest() {
        assert!(!imitated_in_order(["valve_stiction", "valve_lag"]));
        assert!(imitated_in_order(["valve_lag", "valve_stiction"]));
    }
}
