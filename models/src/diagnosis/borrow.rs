//! Other starts for a candidate that is stuck on a channel.
//!
//! A base model that was fitted alone has imitated what it lacks, and with the right effect the fit begins there. On the way back a leak
//! that is zero and a corner without width have no slope. Channels of one rig resemble each other: one that is fitted well lends its
//! parameters.

use rayon::prelude::*;

use super::base::rounded;
use super::blocks::Role;
use super::candidate::{Candidate, acts, assemble, losses_of};
use super::channel::{ChannelData, Extended};
use super::effect_fit::fit_from;
use super::losses::{row_count, total};
use super::stage::{ChannelStage, OPEN};

/// A channel whose mean squared residual is larger by this factor than another's is tried from that one's model.
const WORSE: f64 = 1.5;

/// Fits a candidate from other starts on channels that are described much worse than others or whose valve has lost its corner, and keeps
/// what is better.
#[must_use]
pub fn borrow(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    candidate: &Candidate,
    evaluations: usize,
) -> Candidate {
    let lenders = Lenders::new(channels, stages, candidate);
    let fitted = channels
        .par_iter()
        .zip(stages)
        .enumerate()
        .map(|(k, (data, stage))| {
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
        })
        .collect();
    assemble(channels, stages, candidate.effect, fitted)
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
        let mean = |(data, losses): (&ChannelData, &super::losses::Losses)| {
            total(data, &losses.deviance, &OPEN) / row_count(data, &OPEN).max(1.0)
        };
        let means = channels.iter().zip(&candidate.losses).map(mean).collect();
        let others = stages.iter().map(|stage| stage.model.effects.as_slice()).collect();
        Self { channels, candidate, others, means }
    }

    /// The model of the best channel on which the candidate acts; where that is this one or hardly better, the base of the best of all.
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
