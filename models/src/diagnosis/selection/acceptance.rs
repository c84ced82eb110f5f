//! Is what an effect explains worth its name, and are the names together?

use super::candidate::{Candidate, size};
use crate::diagnosis::channel::{ChannelData, Extended, OPEN, Role};
use crate::diagnosis::estimation::{ChannelStage, models_of};
use crate::diagnosis::likelihood::together;
use crate::diagnosis::likelihood::{Losses, hunts, least_gain, row_count, together_by};
use crate::diagnosis::resampling::bootstrap;
use crate::diagnosis::rollout_errors::BlockErrors;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::CATALOGUE;

/// Part of the plain error that a further name surely takes where it leaves much of the weighed
/// one.
const CLOSER: f64 = 0.1;

/// Is what it gains on the choosing blocks sure, or shown by the rows, and enough for a name?
#[must_use]
pub fn worth_naming(channels: &[ChannelData], stages: &[ChannelStage], candidate: &Candidate) -> bool {
    if !candidate.acts.iter().any(|a| *a) {
        return false;
    }
    let sums = |kind: fn(&Losses) -> &[f64]| {
        let before = together_by(channels, stages.iter().map(|s| &s.losses), kind, &[Role::Select]);
        (before, together_by(channels, &candidate.losses, kind, &[Role::Select]))
    };
    let sum = |losses: &[f64]| losses.iter().sum::<f64>();
    let (before, after) = sums(|losses| &losses.deviance);
    let [low, ..] = bootstrap(&before, &after, |a, b| 1.0 - (b / a).sqrt());
    let gain = 1.0 - (sum(&after) / sum(&before)).sqrt();
    // What the rows show is there. A simulation that has it goes astray where its times are rough.
    (low > 0.0 || is_shown(channels, candidate.effect))
        && gain >= least_share(channels, stages)
        && hunting_is_the_error(channels, stages, candidate, sums(|losses| &losses.beside_error))
        && large_enough(channels, candidate)
}

/// Smallest part of the error of these stages that is worth a name.
#[must_use]
pub fn least_share(channels: &[ChannelData], stages: &[ChannelStage]) -> f64 {
    let any =
        |of: &dyn Fn(&ChannelData, &ChannelStage) -> bool| channels.iter().zip(stages).any(|(d, s)| of(d, s));
    let roughly = |stage: &ChannelStage| stage.model.effects.iter().any(|&effect| roughly_timed(effect));
    if any(&|data, stage| data.inputs.in_loop() && roughly(stage)) {
        SETTINGS.practical_roughly_timed
    } else if any(&|data, stage| hunts(data, &stage.model)) {
        SETTINGS.practical_limit_cycle
    } else {
        SETTINGS.practical
    }
}

/// Does this effect happen at times that rows tell only roughly?
#[must_use]
pub fn roughly_timed(effect: usize) -> bool {
    CATALOGUE[effect].is_roughly_timed()
}

/// Hunting can take up any error that has no pattern. It explains one only if it is where the error
/// is.
fn hunting_is_the_error(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    candidate: &Candidate,
    (before, after): (Vec<f64>, Vec<f64>),
) -> bool {
    let models = stages.iter().map(|s| &s.model).chain(&candidate.models);
    if !channels.iter().cycle().zip(models).any(|(data, model)| hunts(data, model)) {
        return true;
    }
    let least = least_gain(channels.iter().map(|data| row_count(data, &[Role::Select])).sum());
    let [low, ..] = bootstrap(&before, &after, |a, b| a - b);
    let gain = before.iter().sum::<f64>() - after.iter().sum::<f64>();
    low > 0.0 && gain >= least
}

/// Is the effect's size beyond what timing and rounding can look like?
fn large_enough(channels: &[ChannelData], candidate: &Candidate) -> bool {
    let models = candidate.models.iter().zip(channels).zip(&candidate.acts).filter(|(_, acts)| **acts);
    let mut sizes = models.map(|((model, data), _)| size(data, model, candidate.effect));
    sizes.any(|size| size >= CATALOGUE[candidate.effect].smallest)
}

/// Is much unexplained?
#[must_use]
pub fn is_large(channels: &[ChannelData], stages: &[ChannelStage]) -> bool {
    kept_total(channels, stages) > SETTINGS.large_error * open_rows(channels)
}

/// Does a candidate leave much unexplained?
#[must_use]
pub fn leaves_large(channels: &[ChannelData], candidate: &Candidate) -> bool {
    let left: f64 = together(channels, &candidate.losses, &OPEN).iter().sum();
    left > SETTINGS.large_error * open_rows(channels)
}

/// Is much unexplained, too, where a loop that hunts takes up much of it?
#[must_use]
pub fn leaves_much(channels: &[ChannelData], stages: &[ChannelStage]) -> bool {
    let hunting = channels.iter().zip(stages).any(|(data, stage)| hunts(data, &stage.model));
    let large = if hunting { SETTINGS.large_error_limit_cycle } else { SETTINGS.large_error };
    kept_total(channels, stages) > large * open_rows(channels)
}

/// Do names that leave more than that part of a large error only imitate what is not in the
/// catalogue?
#[must_use]
pub fn forced(
    channels: &[ChannelData],
    first: &[ChannelStage],
    last: &[ChannelStage],
    named: &[usize],
) -> bool {
    let roughly = named.iter().any(|&effect| roughly_timed(effect));
    let most = if roughly { SETTINGS.forced_roughly_timed } else { SETTINGS.forced };
    let rows = open_rows(channels);
    let (before, after) = (kept_total(channels, first) / rows, kept_total(channels, last) / rows);
    leaves_much(channels, last) && after - 1.0 > most * (before - 1.0)
}

/// Do the rows of a channel show an effect by themselves? Then it is there, whatever else is
/// missing.
#[must_use]
pub fn is_shown(channels: &[ChannelData], effect: usize) -> bool {
    channels.iter().any(|data| CATALOGUE[effect].is_shown(&data.inputs))
}

/// Does a further name take little of a large error? Beside what is named, something else always
/// has a part of what that leaves; it takes at least as much as all names may leave, or brings
/// rollouts surely closer to the pressure.
#[must_use]
pub fn a_trace_beside(channels: &[ChannelData], stages: &[ChannelStage], candidate: &Candidate) -> bool {
    let rows = open_rows(channels);
    let before = kept_total(channels, stages) / rows;
    let after = together(channels, &candidate.losses, &OPEN).iter().sum::<f64>() / rows;
    after > SETTINGS.large_error
        && after - 1.0 > (1.0 - SETTINGS.forced) * (before - 1.0)
        && !is_surely_closer(channels, &models_of(stages), &candidate.models, (&[Role::Select], CLOSER))
}

/// Are rollouts of models on the blocks of some roles closer to the pressure than those of others,
/// surely by a part of their plain error? Of a loop that hunts they do not tell.
pub fn is_surely_closer(
    channels: &[ChannelData],
    others: &[Extended],
    models: &[Extended],
    (roles, part): (&[Role], f64),
) -> bool {
    let errors = |models: &[Extended]| BlockErrors::of(channels, models, roles);
    let hunting = channels.iter().zip(models).any(|(data, model)| hunts(data, model));
    !hunting && errors(others).gain(&errors(models)).ci95[0] > part
}

/// [Deviance](Losses::deviance) of all channels on the open blocks.
pub fn kept_total(channels: &[ChannelData], stages: &[ChannelStage]) -> f64 {
    together(channels, stages.iter().map(|s| &s.losses), &OPEN).iter().sum()
}

/// Number of compared rows in the open blocks of all channels.
pub fn open_rows(channels: &[ChannelData]) -> f64 {
    channels.iter().map(|data| row_count(data, &OPEN)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::selection::candidate::losses_of;
    use crate::diagnosis::testing::{channel, measured, with_repeated_readings};
    use crate::effects::catalogue::index_of;

    /// What a further name needs beside an effect.
    fn needed_beside(effect: &str, value: f64, in_loop: bool) -> f64 {
        let (data, base) = channel(in_loop);
        let model = base.with(&data.plant, index_of(effect).unwrap(), &[value]);
        let stage = ChannelStage::new(&data, model, Vec::new());
        least_share(&[data], &[stage])
    }

    #[test]
    fn a_name_needs_more_beside_what_leads_a_simulation_of_a_loop_astray() {
        assert_eq!(needed_beside("sensor_offset", 1.0, true), SETTINGS.practical);
        assert_eq!(needed_beside("valve_stiction", 0.05, true), SETTINGS.practical_limit_cycle);
        assert_eq!(needed_beside("stale_samples", 0.5, true), SETTINGS.practical_roughly_timed);
        // A recorded drive leads back, whatever the spool or the samples do.
        assert_eq!(needed_beside("valve_stiction", 0.05, false), SETTINGS.practical);
        assert_eq!(needed_beside("stale_samples", 0.5, false), SETTINGS.practical);
    }

    #[test]
    fn a_further_name_takes_much_of_a_large_error_or_is_none() {
        let (data, base) = channel(false);
        let lag = index_of("valve_lag").unwrap();
        let truth = base.with(&data.plant, lag, &[0.08]);
        let data = measured(data, &truth, 1);
        let stages = [ChannelStage::new(&data, base.clone(), Vec::new())];
        let losses = |model: &Extended| losses_of(&data, &stages[0], model);
        let lagging = |lag_s: f64| base.with(&data.plant, lag, &[lag_s]);
        let beside = |model: Extended, losses: Losses| {
            let candidate =
                Candidate { effect: lag, models: vec![model], acts: vec![true], losses: vec![losses] };
            a_trace_beside(std::slice::from_ref(&data), &stages, &candidate)
        };
        assert!(is_large(std::slice::from_ref(&data), &stages));
        let [small, whole] = [0.005, 0.08].map(lagging);
        assert!(beside(small.clone(), losses(&small)) && !beside(whole.clone(), losses(&whole)));
        // Where the weighed error hardly falls, the pressure may tell.
        assert!(!beside(whole, losses(&small)));
    }

    #[test]
    fn what_the_rows_show_is_named_though_the_gain_is_not_sure_and_nothing_else_is() {
        let (data, base) = channel(false);
        let shown = with_repeated_readings(data.clone());
        // The first of the choosing blocks gains nearly all, the others lose a little: without the
        // first, as in a third of the resamples, nothing is gained.
        let gained_in_one_block = |data: &ChannelData, mut losses: Losses| {
            let mut blocks = data.blocks.iter().zip(&mut losses.deviance);
            let (_, first) = blocks.find(|(block, _)| block.role == Role::Select).unwrap();
            *first *= 0.1;
            blocks.for_each(|(_, loss)| *loss *= 1.02);
            losses
        };
        let named = |data: &ChannelData, id: &str, value: f64| {
            let effect = index_of(id).unwrap();
            let stages = [ChannelStage::new(data, base.clone(), Vec::new())];
            let losses = vec![gained_in_one_block(data, stages[0].losses.clone())];
            let models = vec![base.with(&data.plant, effect, &[value])];
            let candidate = Candidate { effect, models, acts: vec![true], losses };
            worth_naming(std::slice::from_ref(data), &stages, &candidate)
        };
        assert!(named(&shown, "stale_samples", 0.2));
        assert!(!named(&data, "stale_samples", 0.2));
        assert!(!named(&shown, "valve_lag", 0.03));
    }
}
