//! Other starts for a candidate that is stuck on a channel.
//!
//! A base model that was fitted alone has imitated what it lacks, and with the right effect the fit
//! begins there. On the way back a leak that is zero and a corner without width have no slope.
//! Channels of one rig resemble each other: one that is fitted well lends its parameters.

use super::candidate::{Candidate, acts, assemble, losses_of};
use crate::diagnosis::channel::{ChannelData, Extended, OPEN, Role};
use crate::diagnosis::estimation::{ChannelStage, fit_base_from, fit_from, free_of, plain_cost, rounded};
use crate::diagnosis::likelihood::{Losses, row_count, total};
use crate::parallel;

/// A channel whose mean squared residual is larger by this factor than another's is tried from that
/// one's model.
const WORSE: f64 = 1.5;

/// Fits a candidate from other starts on channels that are described much worse than others or
/// whose valve has lost its corner, and keeps what is better.
#[must_use]
pub fn borrow(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    candidate: &Candidate,
    evaluations: usize,
) -> Candidate {
    let lenders = Lenders::new(channels, stages, candidate);
    let fitted = parallel::map(channels.iter().zip(stages).enumerate(), |(k, (data, stage))| {
        let mut best = (candidate.models[k].clone(), candidate.losses[k].clone(), candidate.acts[k]);
        for start in [lenders.lent_to(k), corner_back(data, candidate, k)].into_iter().flatten() {
            let model = fit_from(data, stage, &start, candidate.effect, evaluations);
            let losses = losses_of(data, stage, &model);
            if total(data, &losses.deviance, &[Role::Fit]) < total(data, &best.1.deviance, &[Role::Fit]) {
                let acts = acts(data, stage, &model, &losses);
                best = (model, losses, acts);
            }
        }
        best
    });
    assemble(channels, stages, candidate.effect, fitted)
}

/// Fits base models again, on channels that are described much worse than the best one, from that
/// one's, and keeps what is better: valves of one rig are much alike, and a grid of starts may
/// miss.
#[must_use]
pub fn lend_base(channels: &[ChannelData], stages: Vec<ChannelStage>) -> Vec<ChannelStage> {
    let mean = |(data, stage): (&ChannelData, &ChannelStage)| {
        total(data, &stage.losses.deviance, &OPEN) / row_count(data, &OPEN).max(1.0)
    };
    let means: Vec<f64> = channels.iter().zip(&stages).map(mean).collect();
    let Some(lender) = (0..means.len()).min_by(|&a, &b| means[a].total_cmp(&means[b])) else {
        return stages;
    };
    let (lent, least) = (stages[lender].model.clone(), means[lender]);
    parallel::map(channels.iter().zip(stages).zip(means), |((data, stage), mean)| {
        if mean < WORSE * least {
            return stage;
        }
        let model = fit_base_from(data, &lent);
        let free = free_of(data, &model, false);
        let again = ChannelStage::new(data, model, free);
        let left = |stage: &ChannelStage| total(data, &stage.losses.deviance, &[Role::Fit]);
        // Weighed, and in plain kilopascals: far off, one is won while the other is lost.
        let better =
            left(&again) < left(&stage) && plain_cost(data, &again.model) < plain_cost(data, &stage.model);
        if better { again } else { stage }
    })
}

/// The model of a channel on which the candidate acts, with its corner rounded again.
fn corner_back(data: &ChannelData, candidate: &Candidate, k: usize) -> Option<Extended> {
    if candidate.acts[k] { rounded(data, &candidate.models[k]) } else { None }
}

/// Who may lend to whom.
struct Lenders<'a> {
    channels: &'a [ChannelData],
    candidate: &'a Candidate,
    /// The other effects of every channel.
    others: Vec<&'a [usize]>,
    /// Mean squared residuals.
    means: Vec<f64>,
}

impl<'a> Lenders<'a> {
    fn new(channels: &'a [ChannelData], stages: &'a [ChannelStage], candidate: &'a Candidate) -> Self {
        let mean = |(data, losses): (&ChannelData, &Losses)| {
            total(data, &losses.deviance, &OPEN) / row_count(data, &OPEN).max(1.0)
        };
        let means = channels.iter().zip(&candidate.losses).map(mean).collect();
        let others = stages.iter().map(|stage| stage.model.effects.as_slice()).collect();
        Self { channels, candidate, others, means }
    }

    /// The model of the best channel on which the candidate acts; where that is this one or hardly
    /// better, the base of the best of all.
    fn lent_to(&self, k: usize) -> Option<Extended> {
        let Candidate { effect, models, acts, .. } = self.candidate;
        let best = |among: &dyn Fn(usize) -> bool| {
            let like = (0..self.means.len()).filter(|&j| among(j) && self.others[j] == self.others[k]);
            like.min_by(|&a, &b| self.means[a].total_cmp(&self.means[b]))
                .filter(|&j| self.means[k] >= WORSE * self.means[j])
        };
        if let Some(lender) = best(&|j| acts[j]) {
            return Some(models[lender].clone());
        }
        let lender = best(&|j| !acts[j]).filter(|_| acts[k])?;
        let own = models[k].range(&self.channels[k].plant, *effect)?;
        Some(models[lender].with(&self.channels[k].plant, *effect, &models[k].values[own]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::estimation::free_base;
    use crate::diagnosis::testing::{channel, measured};
    use crate::effects::catalogue::index_of;

    /// Channels behind a driver that limits the first one's drive, and a candidate that is stuck
    /// there: no leak, no corner, the limit too wide.
    fn stuck(count: usize) -> (Vec<ChannelData>, Vec<ChannelStage>, Candidate) {
        let effect = index_of("drive_saturation").expect("it is in the catalogue");
        let (data, base) = channel(false);
        let mut channels = vec![data; count];
        let limited = base.with(&channels[0].plant, effect, &[0.2]);
        channels[0].measured_kpa = channels[0].readings(&limited).into();
        let stages: Vec<ChannelStage> =
            channels.iter().map(|data| ChannelStage::new(data, base.clone(), free_base(data))).collect();
        let mut models: Vec<Extended> = stages.iter().map(|stage| stage.model.clone()).collect();
        let mut losses: Vec<Losses> = stages.iter().map(|stage| stage.losses.clone()).collect();
        let mut start = base.with(&channels[0].plant, effect, &[0.24]);
        let corner = channels[0].plant.position("corner").expect("a valve has one");
        (start.values[0], start.values[1], start.values[corner]) = (0.0, 0.0, 1e-4);
        losses[0] = losses_of(&channels[0], &stages[0], &start);
        models[0] = start;
        let acts = (0..count).map(|k| k == 0).collect();
        (channels, stages, Candidate { effect, models, acts, losses })
    }

    fn left(channels: &[ChannelData], candidate: &Candidate) -> f64 {
        total(&channels[0], &candidate.losses[0].deviance, &[Role::Fit])
    }

    #[test]
    fn a_base_model_that_is_stuck_is_fitted_from_the_best_channels_and_no_other_is_touched() {
        let (data, base) = channel(false);
        let channels = [1, 2, 3].map(|seed| measured(data.clone(), &base, seed));
        let stage = |data: &ChannelData, model: &Extended| {
            ChannelStage::new(data, model.clone(), free_of(data, model, false))
        };
        let mut stuck = base.clone();
        let gain = channels[0].plant.position("gain").expect("a valve has one");
        stuck.values[gain] *= 3.0;
        let models = [&stuck, &base, &base];
        let stages: Vec<ChannelStage> = channels.iter().zip(models).map(|(d, m)| stage(d, m)).collect();
        let lent = lend_base(&channels, stages.clone());
        let left = |stage: &ChannelStage| total(&channels[0], &stage.losses.deviance, &[Role::Fit]);
        assert!(left(&lent[0]) < 0.1 * left(&stages[0]), "{} of {}", left(&lent[0]), left(&stages[0]));
        let touched = |k: usize| lent[k].model != stages[k].model;
        assert_eq!([0, 1, 2].map(touched), [true, false, false]);
    }

    #[test]
    fn a_valve_that_lost_its_corner_is_fitted_with_it_again() {
        let (channels, stages, candidate) = stuck(1);
        let better = borrow(&channels, &stages, &candidate, 10);
        let limit = better.models[0].values.last().copied();
        assert!(
            left(&channels, &better) < 1e-3 * left(&channels, &candidate),
            "{} {} {:?}",
            left(&channels, &better),
            left(&channels, &candidate),
            better.models
        );
        assert!(limit.is_some_and(|limit| (limit - 0.2).abs() < 1e-3), "{limit:?}");
    }

    #[test]
    fn a_neighbour_lends_its_valve_and_nothing_else() {
        let (channels, stages, candidate) = stuck(2);
        let lent = Lenders::new(&channels, &stages, &candidate).lent_to(0);
        let expected = stages[1].model.with(&channels[0].plant, candidate.effect, &[0.24]);
        assert_eq!(lent, Some(expected));
        assert_eq!(Lenders::new(&channels, &stages, &candidate).lent_to(1), None);
    }

    #[test]
    fn a_valve_with_a_corner_that_is_described_as_well_as_the_others_is_left_alone() {
        let (channels, stages, mut candidate) = stuck(1);
        let corner = channels[0].plant.position("corner").expect("a valve has one");
        candidate.models[0].values[corner] = 0.02;
        assert_eq!(borrow(&channels, &stages, &candidate, 10).models, candidate.models);
    }
}
