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

/// Tries the most promising pairs with base parameters of their own, while much is left.
pub fn from_pairs_afresh(
    channels: &mut [ChannelData],
    (first, stages): (&mut [ChannelStage], &mut Vec<ChannelStage>),
    (round, pairs, gates): (&Entered, &[Pair], &[Gate]),
    rules: Rules<'_>,
    named: &mut Named,
    progress: &Progress<'_>,
) {
    for effects in pairs.iter().take(PAIRS).map(|pair| pair.effects) {
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
