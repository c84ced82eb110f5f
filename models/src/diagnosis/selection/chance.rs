//! What chance explains of a candidate that was refitted without having passed the gate.

use super::candidate::Candidate;
use crate::diagnosis::channel::{ChannelData, Extended, Role};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::likelihood::whitened_residuals;
use crate::diagnosis::screening::{Trial, judge, scores};

/// Share of random signs under which the sum of a candidate's scores on the choosing blocks is as
/// large.
#[must_use]
pub fn p_value(channels: &[ChannelData], stages: &[ChannelStage], candidate: &Candidate) -> f64 {
    let trial = |((data, stage), model): ((&ChannelData, &ChannelStage), &Extended)| {
        let left = whitened_residuals(data, &stage.whitening, &data.readings(model));
        let direction: Vec<f64> = stage.residuals.iter().zip(&left).map(|(r, l)| r - l).collect();
        vec![Trial {
            effect: candidate.effect,
            probe: 0,
            start: model.clone(),
            scores: scores(data, &stage.residuals, &direction, &[Role::Select]),
            direction: Vec::new(),
            loss: 0.0,
            promise: 0.0,
            one_sided: true,
            searched: None,
        }]
    };
    let trials: Vec<Vec<Trial>> = channels.iter().zip(stages).zip(&candidate.models).map(trial).collect();
    judge(&trials).first().map_or(1.0, |gate| gate.p_value)
}
