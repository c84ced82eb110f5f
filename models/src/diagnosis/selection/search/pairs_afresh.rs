//! Pairs of effects with base parameters of their own.
//!
//! Where two large effects are there, the base model goes so far to imitate them that neither of
//! them explains anything from where it ends, nor the second beside the first.

use super::naming::{Entered, Named, Rules, name, p_value};
use super::taking_over::{as_candidate, take_over};
use crate::diagnosis::channel::{ChannelData, share_draws};
use crate::diagnosis::estimation::{ChannelStage, models_of};
use crate::diagnosis::screening::{Gate, Pair};
use crate::diagnosis::selection::acceptance::{is_large, kept_total};
use crate::diagnosis::selection::restart::together_afresh;
use crate::diagnosis::selection::search::{Progress, renew};
use crate::diagnosis::selection::selected::Found;
use crate::diagnosis::selection::settling::settle_finely;

/// Pairs that are tried at most, the most promising first.
const PAIRS: usize = 4;
/// Rows of all channels of a loop up to which so many are tried. Simulating a loop takes several
/// times as long: of four channels in 220 s a pair takes one to two seconds, and with a recorded
/// drive 0.2 s.
const ROWS_OF_LOOPS: usize = 36_000;

/// Tries the most promising pairs with base parameters of their own, while much is left.
pub fn from_pairs_afresh(
    channels: &mut [ChannelData],
    (first, stages): (&mut [ChannelStage], &mut Vec<ChannelStage>),
    (round, pairs, gates): (&Entered, &[Pair], &[Gate]),
    rules: Rules<'_>,
    named: &mut Named,
    progress: &Progress<'_>,
) {
    for effects in pairs.iter().take(most_pairs(channels)).map(|pair| pair.effects) {
        if !is_large(channels, stages) {
            return;
        }
        if effects.iter().all(|&effect| named.causes.iter().any(|cause| cause.is(effect))) {
            continue;
        }
        progress("trying two of the catalogue afresh", 0);
        let (left, before) = (kept_total(channels, stages), models_of(stages));
        share_draws(channels, &models_of(first));
        renew(channels, first);
        let afresh = together_afresh(channels, stages, &round.tried, effects);
        let settled = afresh.map(|models| settle_finely(channels, &models, false));
        if let Some(mut other) = settled.filter(|other| kept_total(channels, other) < left) {
            let causes = effects.map(|effect| {
                let candidate = as_candidate(channels, first, &other, effect);
                Found::new(channels, first, &[candidate], 0, &[], p_value(gates, effect))
            });
            let mut again = Named { causes: causes.to_vec(), ..Named::default() };
            name(channels, (first, &mut other), Rules { beating: Some(left), ..rules }, &mut again, progress);
            if take_over(channels, (again, other), (named, stages), &effects, (round, rules.asked)) {
                continue;
            }
        }
        share_draws(channels, &before);
    }
}

/// Pairs that are tried in these channels.
fn most_pairs(channels: &[ChannelData]) -> usize {
    let of_loops = channels.iter().filter(|data| data.inputs.in_loop());
    let rows: usize = of_loops.map(|data| data.rows.len()).sum();
    PAIRS.min(PAIRS * ROWS_OF_LOOPS / rows.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::channel::Extended;
    use crate::diagnosis::screening::{judge, trials};
    use crate::diagnosis::testing::{STRUCTURE, channel, fitted, measured, with};
    use crate::effects::catalogue::{CATALOGUE, index_of};

    const RULES: Rules<'_> = Rules { asked: STRUCTURE, harmless: false, beating: None };

    /// A loop with `effects` hidden, behind a base model of ten times the gain.
    fn hidden(effects: &[(&str, &[f64])]) -> (ChannelData, Extended) {
        let (data, base) = channel(true);
        let truth = effects.iter().fold(base.clone(), |model, (id, size)| with(&data, &model, id, size));
        let mut astray = base;
        astray.values[2] *= 10.0;
        (measured(data, &truth, 1), astray)
    }

    /// What is named where one pair is promising, and nothing was named before.
    fn named(effects: &[(&str, &[f64])], pair: [&str; 2]) -> Vec<&'static str> {
        let (data, astray) = hidden(effects);
        let mut channels = [data];
        let mut first = [fitted(&channels[0], &astray)];
        let tried = trials(&channels, &first, STRUCTURE, &|| {});
        let gates = judge(&tried);
        let round = Entered { tried, ranked: Vec::new() };
        let pairs = [Pair { effects: pair.map(|id| index_of(id).unwrap()), gain: 1.0 }];
        let (mut stages, mut named) = (first.to_vec(), Named::default());
        let found = (&mut first[..], &mut stages);
        from_pairs_afresh(&mut channels, found, (&round, &pairs, &gates), RULES, &mut named, &|_, _| {});
        let mut names: Vec<_> = named.causes.iter().map(|cause| CATALOGUE[cause.effect].id).collect();
        names.sort_unstable();
        names
    }

    #[test]
    fn two_large_effects_are_named_from_base_parameters_of_their_own() {
        let both: [(&str, &[f64]); 2] = [("line_restriction", &[1.3, 0.05, 0.0]), ("sensor_lag", &[0.05])];
        assert_eq!(named(&both, ["line_restriction", "sensor_lag"]), ["line_restriction", "sensor_lag"]);
        assert!(named(&both, ["valve_wear", "chamber_coupling"]).is_empty(), "no valve makes it these");
    }

    #[test]
    fn what_nobody_can_tell_from_another_supply_takes_no_name_away() {
        let (tube, lag) = (("line_restriction", &[1.3, 0.05, 0.0][..]), ("sensor_lag", &[0.05][..]));
        let misstated = ("supply_misstated", &[-0.1][..]);
        assert_eq!(
            named(&[tube, lag, misstated], ["line_restriction", "sensor_lag"]),
            ["line_restriction", "sensor_lag"]
        );
    }

    #[test]
    fn of_long_recordings_of_loops_fewer_pairs_are_tried() {
        let most = |looped: bool, seconds: usize| {
            let (mut data, _) = channel(looped);
            data.rows = (0..100).cycle().take(100 * seconds).collect();
            most_pairs(&[data.clone(), data.clone(), data.clone(), data])
        };
        assert_eq!([60, 220, 400].map(|seconds| most(true, seconds)), [4, 1, 0]);
        assert_eq!(most(false, 400), 4);
    }
}
