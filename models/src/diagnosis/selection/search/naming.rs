//! One pass of the search: rounds until nothing passes, and what of the names stays.

use std::rc::Rc;

use super::Progress;
use crate::diagnosis::channel::{ChannelData, Extended, Role, share_draws};
use crate::diagnosis::estimation::{ChannelStage, models_of};
use crate::diagnosis::evidence::Explanation;
use crate::diagnosis::likelihood::hunts;
use crate::diagnosis::rollout_errors::BlockErrors;
use crate::diagnosis::screening::{Asked, Gate, Trial, judge, trials};
use crate::diagnosis::selection::acceptance::{
    a_trace_beside, forced, is_large, is_shown, kept_total, leaves_much,
};
use crate::diagnosis::selection::candidate::Candidate;
use crate::diagnosis::selection::elimination::eliminate;
use crate::diagnosis::selection::entrants::{Entrants, Field};
use crate::diagnosis::selection::racing::{
    Considered, Raced, is_foil, is_of_the_rig_file, judged, race, rivals, round,
};
use crate::diagnosis::selection::selected::{Found, Withheld};
use crate::diagnosis::selection::settling::settle_finely;
use crate::diagnosis::settings::SETTINGS;
use crate::effects::Question;

/// What the rounds of a search find.
#[derive(Default)]
pub struct Named {
    /// Causes in the order in which they were named.
    pub causes: Vec<Found>,
    /// The first round, beside nothing: a further search need not do it again, and may begin with
    /// another effect.
    pub first_round: Option<Rc<Entered>>,
    /// What was considered in every round.
    pub rounds: Vec<Vec<Considered>>,
    /// What was refitted on the way.
    pub explanations: Vec<Explanation>,
    /// A name that was found and not given.
    pub withheld: Option<Withheld>,
    /// Squared whitened error on the open blocks that all names together left, before any was taken
    /// back, where they made rollouts worse and that is much.
    pub harmful: Option<f64>,
}

/// What a round has tried and refitted.
pub struct Entered {
    /// The catalogue, channel by channel.
    pub tried: Vec<Vec<Trial>>,
    /// What passed the gate, best first.
    pub ranked: Vec<Candidate>,
}

/// What may be named.
#[derive(Clone, Copy)]
pub struct Rules<'a> {
    /// What is asked.
    pub asked: Asked<'a>,
    /// Nothing with which rollouts on the choosing blocks are worse than without any name?
    pub harmless: bool,
    /// Squared whitened error on the open blocks that another search has left: there two names must
    /// leave no more, and the whole catalogue is not refitted. Nothing, in the first search.
    pub beating: Option<f64>,
}

/// Names one cause after the other until nothing passes, and takes back what is not needed beside
/// the others, or all of it when too much of the error of the `first` stages is left.
pub fn name(
    channels: &mut [ChannelData],
    (first, stages): (&[ChannelStage], &mut Vec<ChannelStage>),
    Rules { asked, harmless, beating }: Rules<'_>,
    Named { causes, first_round, rounds, explanations, withheld, harmful }: &mut Named,
    progress: &Progress<'_>,
) {
    let fixed = asked.question == Question::Change;
    let mut base_kpa = choosing_kpa(channels, &models_of(first));
    // Only the first round of a search is beside nothing.
    let mut again = first_round.clone().filter(|_| causes.is_empty());
    while causes.len() < usize::from(SETTINGS.most_causes) {
        let done = again.take();
        let entered = done
            .clone()
            .unwrap_or_else(|| Rc::new(enter(channels, stages, (asked, causes.len()), rounds, progress)));
        if beating.is_none() {
            first_round.get_or_insert_with(|| entered.clone());
        }
        let Entered { tried, ranked } = &*entered;
        let gates = judge(tried);
        let harms = |models: &[Extended]| harmless && goes_astray(channels, models, base_kpa);
        let field = Field { channels, stages, tried, gates: &gates };
        let mut raced = judged(field, Entrants::Passed, ranked.clone(), harms);
        // Where the drive is recorded, a model that is far off is the likelihood's matter.
        let looped = channels.iter().all(|data| data.inputs.in_loop());
        if looped
            && beating.is_none()
            && raced.winner.is_none()
            && !causes.is_empty()
            && is_large(channels, stages)
        {
            progress("refitting the whole catalogue", causes.len() as u64);
            raced = round(field, Entrants::Everything, rounds, harms);
        }
        let Raced { ranked, winner, harmful: refused } = raced;
        let named: Vec<usize> = causes.iter().map(|cause| cause.effect).collect();
        // Beside another supply everything explains more: what is not named there is none.
        if withheld.is_none() && done.is_none() {
            let acting = ranked.iter().chain(&refused).filter(|c| c.acts.contains(&true));
            explanations.extend(acting.map(|c| c.explanation(&named)));
        }
        let Some(winner) = winner else {
            break;
        };
        if !causes.is_empty() && a_trace_beside(channels, stages, &ranked[winner]) {
            break;
        }
        let equivalent = rivals(channels, stages, &ranked, winner);
        if let Some(&foil) = equivalent.iter().find(|&&k| is_foil(&ranked[k])) {
            // Another search is judged by what it has named so far.
            if beating.is_some() {
                break;
            }
            let name = Withheld { effect: ranked[winner].effect, foil: ranked[foil].clone() };
            if withheld.is_some() || !is_of_the_rig_file(&ranked[foil]) {
                withheld.get_or_insert(name);
                break;
            }
            *withheld = Some(name);
            // Whatever it is, this part of the error is accounted for: the search goes on with the
            // supply that the recording speaks for.
            *stages = settle_finely(channels, &ranked[foil].models, fixed);
            continue;
        }
        let p_value = p_value(&gates, ranked[winner].effect);
        causes.push(Found::new(channels, stages, &ranked, winner, &equivalent, p_value));
        *stages = settle_finely(channels, &ranked[winner].models, fixed);
        if beating.is_some_and(|least| causes.len() > 1 && kept_total(channels, stages) > least) {
            break;
        }
        if is_shown(channels, ranked[winner].effect) {
            // It is there, whatever rollouts say: what comes beside it need not make up for it.
            base_kpa = choosing_kpa(channels, &models_of(stages));
        }
    }
    eliminate(channels, first, stages, causes, fixed);
    // A rival that turned out to be needed as well is no rival.
    let named: Vec<usize> = causes.iter().map(|c| c.effect).collect();
    for cause in causes.iter_mut() {
        cause.equivalent.retain(|e| !named.contains(e));
        cause.rivals.retain(|r| !named.contains(&r.effect));
    }
    let found = causes.iter().any(|c| !is_shown(channels, c.effect));
    let harmed = found && harms(channels, first, stages);
    *harmful = harmed.then(|| kept_total(channels, stages));
    if !causes.is_empty() && forced(channels, first, stages, &named) {
        keep_shown(channels, (first, stages), causes, fixed);
    }
    if causes.is_empty() {
        *stages = first.to_vec();
        share_draws(channels, &models_of(first));
    }
}

/// Tries the catalogue beside so many causes, and refits what passes.
fn enter(
    channels: &[ChannelData],
    stages: &[ChannelStage],
    (asked, causes): (Asked<'_>, usize),
    rounds: &mut Vec<Vec<Considered>>,
    progress: &Progress<'_>,
) -> Entered {
    progress("trying the catalogue", causes as u64);
    let tried = trials(channels, stages, asked, &|| progress("", 1));
    progress("refitting what passed", causes as u64);
    let field = Field { channels, stages, tried: &tried, gates: &judge(&tried) };
    let ranked = race(field, Entrants::Passed, rounds);
    Entered { tried, ranked }
}

/// The p-value of an effect's gate, 1 where it has none.
pub fn p_value(gates: &[Gate], effect: usize) -> f64 {
    gates.iter().find(|gate| gate.effect == effect).map_or(1.0, |gate| gate.p_value)
}

/// Do names that leave much make rollouts worse than the `first` stages do, counted in plain
/// kilopascals? The search weighs errors by what noise and wander explain; where the model is wrong
/// altogether, that can be won while the pressure is lost. Where little is left it is not: then the
/// pressure says only how the supply happened to wander.
#[must_use]
pub fn harms(channels: &[ChannelData], first: &[ChannelStage], last: &[ChannelStage]) -> bool {
    leaves_much(channels, last)
        && goes_astray(channels, &models_of(last), choosing_kpa(channels, &models_of(first)))
}

/// Do rollouts leave `base_kpa` or more? Of a loop that hunts they do not tell: none is in step
/// with the recording, and one that does not hunt at all is as close. There the likelihood judges
/// alone.
pub fn goes_astray(channels: &[ChannelData], models: &[Extended], base_kpa: f64) -> bool {
    let hunting = channels.iter().zip(models).any(|(data, model)| hunts(data, model));
    !hunting && choosing_kpa(channels, models) >= base_kpa
}

/// RMS error of rollouts on the choosing blocks, kPa.
pub fn choosing_kpa(channels: &[ChannelData], models: &[Extended]) -> f64 {
    BlockErrors::of(channels, models, &[Role::Select]).all()
}

/// Takes all names back but those which the recording shows by itself.
pub fn keep_shown(
    channels: &mut [ChannelData],
    (first, stages): (&[ChannelStage], &mut Vec<ChannelStage>),
    causes: &mut Vec<Found>,
    fixed: bool,
) {
    let (shown, others): (Vec<Found>, Vec<Found>) =
        std::mem::take(causes).into_iter().partition(|cause| is_shown(channels, cause.effect));
    *causes = shown;
    if causes.is_empty() || others.is_empty() {
        return;
    }
    let without = |(data, stage): (&ChannelData, &ChannelStage)| {
        others.iter().fold(stage.model.clone(), |model, cause| model.without(&data.plant, cause.effect))
    };
    let models: Vec<Extended> = channels.iter().zip(stages.iter()).map(without).collect();
    *stages = settle_finely(channels, &models, fixed);
    causes.iter_mut().for_each(|cause| cause.adds(channels, first, stages));
}
