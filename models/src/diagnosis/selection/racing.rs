//! One round of the search: what passed the gate is refitted and ranked, and the best may be named.

use super::acceptance::{is_shown, is_surely_closer, kept_total, open_rows, worth_naming};
use super::candidate::{Candidate, first_look, refit_further};
use super::chance::p_value;
use super::entrants::{Entrants, Field, LOOK, to_look_at};
use super::settling::SETTLE;
use super::warm_start::borrow;
use crate::diagnosis::channel::{ChannelData, Extended, OPEN};
use crate::diagnosis::estimation::ChannelStage;
use crate::diagnosis::likelihood::{hunts, together};
use crate::diagnosis::resampling::bootstrap;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::Question;
use crate::effects::catalogue::CATALOGUE;
use crate::order::ascending;
use crate::parallel;

/// Rounds of refits in earnest: candidates that miss more than a part of the best gain so far drop
/// out, the others may spend some more evaluations.
const EARNEST: [(f64, usize); 3] = [(0.6, 5), (0.4, 6), (0.25, 10)];
/// A candidate that leaves so many times as much as the best so far drops out too.
const OUTDONE: f64 = 5.0;
/// A candidate that a round brings forward by less than this part of its gain has arrived.
const ARRIVED: f64 = 0.002;
/// The same of a loop that hunts, whose likelihood differs by as much from one course of the noise
/// to the next.
const ARRIVED_HUNTING: f64 = 0.02;
/// Times that the best candidate is fitted further where much is left ...
const MORE: usize = 3;
/// ... unless that leaves more than this part of it.
const STUCK: f64 = 0.95;

/// An effect in one round of the search.
#[derive(Debug, Clone, PartialEq)]
pub struct Considered {
    /// Number of the effect in the catalogue.
    pub effect: usize,
    /// Its statistic.
    pub statistic: f64,
    /// Its p-value over the whole catalogue.
    pub p_value: f64,
    /// Squared whitened error on the open blocks without it.
    pub kept: f64,
    /// The same with it, where it was refitted.
    pub loss: Option<f64>,
}

/// What a round ended with.
pub struct Raced {
    /// All candidates but the harmful ones, best first.
    pub ranked: Vec<Candidate>,
    /// Which of them is worth naming, if one is.
    pub winner: Option<usize>,
    /// Those that would be worth naming by their weighted errors, with which rollouts go further
    /// astray in kilopascals than the base models do.
    pub harmful: Vec<Candidate>,
}

/// A whole round: refits candidates and says which of them is worth naming.
pub fn round(
    field: Field<'_>,
    entrants: Entrants,
    rounds: &mut Vec<Vec<Considered>>,
    harms: impl Fn(&[Extended]) -> bool,
) -> Raced {
    judged(field, entrants, race(field, entrants, rounds), harms)
}

/// Refits candidates and ranks them, best first.
pub fn race(field: Field<'_>, entrants: Entrants, rounds: &mut Vec<Vec<Considered>>) -> Vec<Candidate> {
    let Field { channels, stages, tried, gates } = field;
    let whole: f64 = kept_total(channels, stages);
    let (looked, from) = to_look_at(field, entrants);
    let loss = |candidate: &Candidate| -> f64 { together(channels, &candidate.losses, &OPEN).iter().sum() };
    // A first look at all, then in earnest at the best, as long as that brings them further.
    let mut ranked: Vec<(f64, Candidate)> = parallel::map(looked.iter(), |&effect| {
        let candidate = first_look(channels, stages, tried, (effect, from), LOOK);
        (loss(&candidate), candidate)
    });
    let mut moving = vec![true; ranked.len()];
    for (near, evaluations) in EARNEST {
        let least = ranked.iter().map(|c| c.0).fold(f64::INFINITY, f64::min);
        parallel::map(ranked.iter_mut().zip(&mut moving), |((left, candidate), moving)| {
            if !*moving || *left - least > near * (whole - least) || *left > OUTDONE * least {
                return;
            }
            let further = refit_further(channels, stages, candidate, evaluations);
            let further = borrow(channels, stages, &further, evaluations);
            let next = loss(&further);
            let hunting = channels.iter().zip(&further.models).any(|(data, model)| hunts(data, model));
            let arrived = if hunting { ARRIVED_HUNTING } else { ARRIVED };
            *moving = *left - next > arrived * (whole - *left);
            // Not only where it is better: of several looks at a loop that hunts the best would be
            // better by luck.
            (*left, *candidate) = (next, further);
        });
    }
    ascending(&mut ranked, |item| item.0);
    // Where much is left the best may not have arrived yet.
    if let Some((left, best)) = ranked.first_mut() {
        for _ in 0..MORE {
            if *left <= SETTINGS.large_error * open_rows(channels) {
                break;
            }
            let further = refit_further(channels, stages, best, SETTLE);
            let further = borrow(channels, stages, &further, SETTLE);
            let next = loss(&further);
            let stuck = next > STUCK * *left;
            if next < *left {
                (*left, *best) = (next, further);
            }
            if stuck {
                break;
            }
        }
    }
    let ranked: Vec<Candidate> = ranked.into_iter().map(|(_, c)| c).collect();
    let considered = gates
        .iter()
        .map(|gate| {
            let refitted = ranked.iter().find(|c| c.effect == gate.effect);
            let loss = refitted.map(&loss);
            Considered {
                effect: gate.effect,
                statistic: gate.statistic,
                p_value: gate.p_value,
                kept: whole,
                loss,
            }
        })
        .collect();
    rounds.push(considered);
    ranked
}

/// Which of the ranked candidates is worth naming. `harms` says of models whether they are harmful:
/// what takes up any error, like a spool that sticks, is then no winner, and what comes after it
/// may be.
pub fn judged(
    Field { channels, stages, .. }: Field<'_>,
    entrants: Entrants,
    mut ranked: Vec<Candidate>,
    harms: impl Fn(&[Extended]) -> bool,
) -> Raced {
    let everything = entrants == Entrants::Everything;
    let mut harmful = Vec::new();
    let by_chance =
        |candidate: &Candidate| everything && p_value(channels, stages, candidate) > SETTINGS.level;
    let worth = |candidate: &Candidate| {
        !is_foil(candidate) && worth_naming(channels, stages, candidate) && !by_chance(candidate)
    };
    loop {
        let winner = ranked.iter().position(worth);
        match winner {
            Some(k) if !is_shown(channels, ranked[k].effect) && harms(&ranked[k].models) => {
                harmful.push(ranked.remove(k));
            }
            _ => return Raced { ranked, winner, harmful },
        }
    }
}

/// Does it stand for causes outside the catalogue?
pub fn is_foil(candidate: &Candidate) -> bool {
    CATALOGUE[candidate.effect].question == Question::Foil
}

/// Does it stand for a supply that is not what the rig file states? No cause has such a part of the
/// error, and others may be there beside it.
pub fn is_of_the_rig_file(candidate: &Candidate) -> bool {
    is_foil(candidate) && CATALOGUE[candidate.effect].needs_stated_supply()
}

/// Candidates that explain the open blocks as well as the winner: a paired bootstrap over blocks
/// cannot tell them apart and they leave little of the gain, or their errors are nearly the same.
pub fn rivals(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    ranked: &[Candidate],
    winner: usize,
) -> Vec<usize> {
    let before = kept_total(channels, stages);
    let best = together(channels, &ranked[winner].losses, &OPEN);
    let gain = before - best.iter().sum::<f64>();
    (0..ranked.len())
        .filter(|&k| k != winner)
        .filter(|&k| {
            let other = together(channels, &ranked[k].losses, &OPEN);
            let left = other.iter().sum::<f64>() - best.iter().sum::<f64>();
            let [_, low, ..] = bootstrap(&other, &best, |a, b| a - b);
            nearly_the_same(best.iter().sum(), other.iter().sum(), is_foil(&ranked[k]))
                || (low <= 0.0 && left < SETTINGS.tie_gain * gain)
        })
        .filter(|&k| {
            // What is weighed has room for a supply that wanders; a foil that needs it is none.
            let others = &ranked[k].models;
            !is_foil(&ranked[k])
                || !is_surely_closer(channels, others, &ranked[winner].models, (&OPEN, SETTINGS.practical))
        })
        .collect()
}

/// Is an error, of which the square is given, larger than another by less than is worth a name? No
/// model is exactly the rig, and as little as that the rest of it decides. What stands for causes
/// outside the catalogue takes the name from one inside it, and must be as close in the square.
fn nearly_the_same(best_squared: f64, other_squared: f64, foil: bool) -> bool {
    let factor = 1.0 + SETTINGS.practical;
    other_squared < if foil { factor } else { factor * factor } * best_squared
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::screening::{judge, trials};
    use crate::diagnosis::selection::candidate::losses_of;
    use crate::diagnosis::testing::{STRUCTURE, channel, fitted, measured, with};
    use crate::effects::catalogue::index_of;

    #[test]
    fn errors_that_differ_by_less_than_is_worth_a_name_do_not_tell_rivals_apart() {
        let with = |part: f64, foil: bool| {
            nearly_the_same(400.0, 400.0 * (1.0 + part * SETTINGS.practical).powi(2), foil)
        };
        assert!(with(0.9, false) && !with(1.1, false));
        assert!(with(0.4, true) && !with(0.6, true), "a foil takes the name away");
    }

    #[test]
    fn a_foil_that_is_weighed_alike_is_a_rival_unless_its_rollouts_are_surely_further() {
        let (data, base) = channel(false);
        let swinging = with(&data, &base, "supply_ripple", &[30.0, 5.0, 0.0, 0.5]);
        let channels = [measured(data.clone(), &swinging, 0)];
        let stages = channels.each_ref().map(|data| fitted(data, &base));
        let [ripple, foil, sag] =
            ["supply_ripple", "inflow_cycle", "supply_sag"].map(|id| index_of(id).unwrap());
        let losses = losses_of(&channels[0], &stages[0], &swinging);
        let of = |effect: usize, model: &Extended| Candidate {
            effect,
            models: vec![model.clone()],
            acts: vec![true],
            losses: vec![losses.clone()],
        };
        let rivals = |other: Candidate| rivals(&channels, &stages, &[of(ripple, &swinging), other], 0);
        assert_eq!(rivals(of(foil, &swinging)), [1]);
        assert!(rivals(of(foil, &base)).is_empty());
        assert_eq!(rivals(of(sag, &base)), [1], "it is in the catalogue, and a tie is a tie");
    }

    #[test]
    fn what_harms_is_no_winner_and_no_rival_and_what_comes_after_it_may_win() {
        let (data, base) = channel(false);
        let truth = with(&data, &base, "valve_lag", &[0.05]);
        let channels = [0, 1].map(|seed| measured(data.clone(), &truth, seed));
        let stages = channels.each_ref().map(|data| fitted(data, &base));
        let tried = trials(&channels, &stages, STRUCTURE, &|| {});
        let gates = judge(&tried);
        let field = Field { channels: &channels, stages: &stages, tried: &tried, gates: &gates };
        let raced =
            |harms: &dyn Fn(&[Extended]) -> bool| round(field, Entrants::Passed, &mut Vec::new(), harms);
        let effect = |raced: &Raced| raced.winner.map(|k| raced.ranked[k].effect);
        let first = raced(&|_| false);
        let best = effect(&first).expect("a lag of the spool is seen");
        assert!(first.harmful.is_empty());
        let second = raced(&|models| models[0].has(best));
        assert!(effect(&second).is_some_and(|winner| winner != best));
        assert!(second.harmful.iter().any(|c| c.effect == best));
        assert!(second.ranked.iter().all(|c| c.effect != best));
        assert_eq!(effect(&raced(&|_| true)), None);
    }

    #[test]
    fn what_the_gate_does_not_see_may_win_where_everything_is_refitted_and_noise_may_not() {
        let (data, base) = channel(false);
        let lagging = with(&data, &base, "valve_lag", &[0.05]);
        let winner = |truth: &Extended, entrants: Entrants| {
            let channels = [measured(data.clone(), truth, 0)];
            let stages = channels.each_ref().map(|data| fitted(data, &base));
            let tried = trials(&channels, &stages, STRUCTURE, &|| {});
            let mut closed = judge(&tried);
            closed.iter_mut().for_each(|gate| gate.p_value = 1.0);
            let field = Field { channels: &channels, stages: &stages, tried: &tried, gates: &closed };
            let raced = round(field, entrants, &mut Vec::new(), |_: &[Extended]| false);
            raced.winner.map(|k| CATALOGUE[raced.ranked[k].effect].id)
        };
        assert_eq!(winner(&lagging, Entrants::Passed), None);
        assert_eq!(winner(&lagging, Entrants::Everything), Some("valve_lag"));
        assert_eq!(winner(&base, Entrants::Everything), None);
    }
}
