//! Is what is left no more than what is allowed to be left?

use crate::diagnosis::channel::{ChannelData, Extended, Role, rows_of};
use crate::diagnosis::json::Symptom;
use crate::diagnosis::likelihood::{Expected, WANDERS, Whitening, wander};
use crate::diagnosis::rollout_errors::BlockErrors;
use crate::diagnosis::selection::{Candidate, Outcome};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::catalogue::CATALOGUE;
use crate::parallel;

/// RMS error of rollouts over the test blocks that noise, the supply's usual wander and a loop's
/// hunting leave where the model is right, kPa.
#[must_use]
pub fn allowed_kpa(channels: &[ChannelData], models: &[Extended]) -> f64 {
    let variances: Vec<Vec<f64>> = parallel::map(channels.iter().zip(models), |(data, model)| {
        let derivatives = data.disturbances(model);
        let Expected { hunting, .. } = Expected::of(data, model);
        let mut columns: Vec<f64> = derivatives.iter().flat_map(wander).collect();
        // As in the error itself, the start pressure of a block is right.
        Whitening::start_only(data, &derivatives).apply_columns(&mut columns, WANDERS);
        let variance = |row: usize| {
            let wandered = columns[WANDERS * row..][..WANDERS].iter().map(|c| c * c).sum::<f64>();
            data.noise_kpa.powi(2) + wandered + hunting[row]
        };
        rows_of(data, &[Role::Test]).into_iter().map(variance).collect()
    });
    let count: usize = variances.iter().map(Vec::len).sum();
    (variances.iter().flatten().sum::<f64>() / f64::max(count as f64, 1.0)).sqrt()
}

/// Is an error more than what is allowed?
#[must_use]
pub fn beyond(error_kpa: f64, allowed_kpa: f64) -> bool {
    error_kpa > SETTINGS.beyond * allowed_kpa
}

/// Is the base model so far off, where drives are recorded, that weights which belong to noise and
/// wander mean nothing?
#[must_use]
pub fn astray(channels: &[ChannelData], base: &[Extended]) -> bool {
    let driven = channels.iter().all(|data| !data.inputs.in_loop());
    driven
        && BlockErrors::of(channels, base, &[Role::Select]).all()
            > SETTINGS.astray * allowed_kpa(channels, base)
}

/// A remark on a base model that describes nothing.
#[must_use]
pub fn poor(channels: &[ChannelData], base_kpa: f64) -> Option<String> {
    let movement = movement_kpa(channels);
    (base_kpa > SETTINGS.poor * movement).then(|| format!(
        "The base model alone is no description of this recording: its error of {base_kpa:.2} kPa is not small against the movement of the pressure ({movement:.2} kPa RMS). Check the rig file, the units and the columns before trusting any name."
    ))
}

/// The dependence on time that a foil which swings with a period explains.
#[must_use]
pub fn cycle(channels: &[ChannelData], outcome: &Outcome, foil: &Candidate) -> Option<Symptom> {
    let position = CATALOGUE[foil.effect].parameter("period")?;
    let first = foil.acts.iter().position(|acts| *acts).unwrap_or(0);
    let range = foil.models[first].range(&channels[first].plant, foil.effect)?;
    let period_s = foil.models[first].values[range.start + position];
    let considered = outcome.rounds.last()?.iter().find(|c| c.effect == foil.effect)?;
    Some(Symptom {
        channel: channels[first].id.to_string(),
        what: format!("the residual depends on the time, with a period of {period_s:.3} s"),
        statistic: "sum of quarter-block scores over their root sum of squares".to_owned(),
        value: considered.statistic,
        p_value: considered.p_value,
        share: considered.loss.map_or(0.0, |loss| (1.0 - loss / considered.kept).max(0.0)),
    })
}

/// How far the pressures move about their means on the compared rows, kPa RMS.
fn movement_kpa(channels: &[ChannelData]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for data in channels {
        let mean = data.measured_kpa.iter().sum::<f64>() / data.measured_kpa.len().max(1) as f64;
        sum += data.measured_kpa.iter().map(|p| (p - mean).powi(2)).sum::<f64>();
        count += data.measured_kpa.len() as f64;
    }
    (sum / count.max(1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::{channel, with};

    #[test]
    fn a_loop_that_hunts_may_leave_more() {
        for (in_loop, more) in [(true, true), (false, false)] {
            let (data, base) = channel(in_loop);
            let sticking = with(&data, &base, "valve_stiction", &[0.1]);
            let allowed =
                |model: &Extended| allowed_kpa(std::slice::from_ref(&data), std::slice::from_ref(model));
            let (still, hunting) = (allowed(&base), allowed(&sticking));
            assert_eq!(hunting > 1.1 * still, more, "{in_loop}: {still} {hunting}");
        }
    }
}
