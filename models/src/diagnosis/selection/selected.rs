//! What a search found.

use super::candidate::Candidate;
use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::estimation::{ChannelStage, models_of};
use crate::diagnosis::likelihood::select_total;

/// A cause as the search found it.
#[derive(Debug, Clone)]
pub struct Found {
    /// Number of the effect in the catalogue.
    pub effect: usize,
    /// Where it acts, channel by channel.
    pub acts: Vec<bool>,
    /// p-value of its gate.
    pub p_value: f64,
    /// Numbers of the effects that explain as well.
    pub equivalent: Vec<usize>,
    /// Models without it, all others refitted.
    pub without: Vec<Extended>,
    /// By how much it lowers their deviance on the choosing blocks.
    pub gained: f64,
    /// Models of the rivals, for the next experiment.
    pub rivals: Vec<Candidate>,
    /// Standard errors of its parameters on their scales, channel by channel, where the likelihood
    /// has given them.
    pub errors: Option<Vec<Vec<f64>>>,
}

impl Found {
    /// Number `winner` of the ranked candidates, which the `equivalent` ones explain as well.
    pub fn new(
        channels: &[ChannelData],
        stages: &[ChannelStage],
        ranked: &[Candidate],
        winner: usize,
        equivalent: &[usize],
        p_value: f64,
    ) -> Self {
        Self {
            effect: ranked[winner].effect,
            acts: ranked[winner].acts.clone(),
            p_value,
            equivalent: equivalent.iter().map(|&k| ranked[k].effect).collect(),
            without: models_of(stages),
            gained: select_total(channels, stages.iter().map(|s| &s.losses))
                - select_total(channels, &ranked[winner].losses),
            rivals: equivalent.iter().map(|&k| ranked[k].clone()).collect(),
            errors: None,
        }
    }

    /// Is it this effect, or one that explains as well?
    pub fn is(&self, effect: usize) -> bool {
        self.effect == effect || self.equivalent.contains(&effect)
    }

    /// Notes what it adds to the stages `without` it.
    pub fn adds(&mut self, channels: &[ChannelData], without: &[ChannelStage], with: &[ChannelStage]) {
        let left = |stages: &[ChannelStage]| select_total(channels, stages.iter().map(|s| &s.losses));
        self.without = models_of(without);
        self.gained = left(without) - left(with);
    }
}

/// A name that was not given because something outside the catalogue explains as well.
#[derive(Debug, Clone)]
pub struct Withheld {
    /// Number of the effect in the catalogue.
    pub effect: usize,
    /// What explains as well, refitted.
    pub foil: Candidate,
}
