//! Fitting all recordings of a channel together, from many starts.

use crate::order::ascending;
use std::sync::atomic::AtomicBool;

use super::objective::JointObjective;
use super::recordings::MachineChannel;
use super::ties::{Freedom, TiedModel, Ties};
use crate::diagnosis::channel::{ChannelData, Extended, Role, rows_of};
use crate::diagnosis::estimation::{EDGES, GAINS, rounded, start, with_usual};
use crate::effects::catalogue::CATALOGUE;
use crate::fit::{Minimum, Objective, Stopping, minimise};
use crate::model::Scale;
use crate::parallel;

/// Evaluations spent on each start that looks best among its like.
const LOOK: usize = 6;
/// Starts that are followed further, and evaluations spent on each.
const FOLLOWED: (usize, usize) = (2, 14);
/// Evaluations spent on the best.
const LAST: usize = 30;
/// Starts of the base model that are looked at.
const BASE_STARTS: usize = 4;
/// Gains at which an effect is tried, over those of the base model: what takes up flow leaves more
/// for the valve.
const FACTORS: [f64; 3] = [0.2, 0.5, 1.0];
/// Gains of a vent valve at which a search begins, over the fill valve's.
const VENT_GAINS: [f64; 3] = [1.0, 10.0, 100.0];
/// Scales of a load with which effects are tried on a known machine.
const SCALES: [f64; 3] = [0.3, 1.0, 3.0];

/// A fit's end with what the solver knows there.
pub struct Fitted<'a> {
    /// The models.
    pub models: TiedModel,
    /// What was minimised.
    pub objective: JointObjective<'a>,
    /// Where it ended.
    pub minimum: Minimum,
}

/// Fits what is free from where a model stands, with so many evaluations at most.
#[must_use]
pub fn refit<'a>(
    channel: &'a MachineChannel,
    from: &TiedModel,
    freedom: Freedom<'_>,
    roles: &'a [Role],
    evaluations: usize,
) -> Fitted<'a> {
    let objective = JointObjective::new(channel, from, freedom, roles);
    let stopping = Stopping { evaluations, cost_tolerance: 1e-5, gradient_tolerance: 1e-8 };
    let (bounds, nominal) = (objective.bounds(), objective.nominal());
    let minimum = minimise(&objective, &bounds, &nominal, &stopping, &AtomicBool::new(false));
    Fitted { models: objective.models_at(&minimum.coordinates), objective, minimum }
}

/// Mean squared residual of rollouts over the recordings' fit parts, kPa^2; infinite where a
/// simulation runs away.
#[must_use]
pub fn cost(channel: &MachineChannel, models: &TiedModel) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for (data, model) in channel.recorded.iter().zip(&models.models) {
        let residuals = data.residuals(model);
        for row in rows_of(data, &[Role::Fit]) {
            sum += residuals[row].powi(2);
            count += 1.0;
        }
    }
    let mean = sum / count.max(1.0);
    if mean.is_finite() { mean } else { f64::INFINITY }
}

/// The best of some groups of starts: of each group the best by its error is looked at, the best of
/// these are fitted in earnest. Nothing where every simulation runs away.
#[must_use]
pub fn race(
    channel: &MachineChannel,
    groups: &[Vec<TiedModel>],
    known: Option<&[usize]>,
    tick: &(dyn Fn() + Sync),
) -> Option<TiedModel> {
    let loose = known.map_or(Freedom::Loose, Freedom::Known);
    let best_of = |group: &Vec<TiedModel>| {
        let costs: Vec<f64> = parallel::map(group.iter(), |start| cost(channel, start));
        let best = costs.iter().zip(group).filter(|(c, _)| c.is_finite()).min_by(|a, b| a.0.total_cmp(b.0));
        best.map(|(_, start)| start.clone())
    };
    let fitted = |start: &TiedModel, freedom: Freedom<'_>, evaluations: usize| {
        tick();
        let fitted = refit(channel, start, freedom, &[Role::Fit], evaluations);
        (fitted.minimum.normal.cost, fitted.models)
    };
    let ranked = |mut list: Vec<(f64, TiedModel)>| {
        list.retain(|(cost, _)| cost.is_finite());
        ascending(&mut list, |item| item.0);
        list
    };
    let looked: Vec<TiedModel> = groups.iter().filter_map(best_of).collect();
    let looked = ranked(looked.iter().map(|start| fitted(start, loose, LOOK)).collect());
    let (count, evaluations) = FOLLOWED;
    let mut followed =
        ranked(looked.iter().take(count).map(|(_, start)| fitted(start, loose, evaluations)).collect());
    if known.is_none() {
        let tied =
            |(_, models): &(f64, TiedModel)| fitted(&tie(channel, models), Freedom::Machine, evaluations);
        followed = ranked(followed.iter().map(tied).collect());
    }
    let last = known.map_or(Freedom::Machine, Freedom::Known);
    followed.first().map(|(_, models)| fitted(models, last, LAST).1)
}

/// What is the machine's set to the mean over the recordings, on the scale on which it is fitted.
#[must_use]
pub fn tie(channel: &MachineChannel, models: &TiedModel) -> TiedModel {
    let data = &channel.recorded[0];
    let first = &models.models[0];
    let parameters = first.parameters(&data.plant);
    let mut tied = models.clone();
    for position in Ties::of(data, first, Freedom::Machine).machine {
        let logarithmic = parameters[position].scale == Scale::Logarithmic;
        let to = |v: f64| if logarithmic { v.ln() } else { v };
        let mean =
            models.models.iter().map(|m| to(m.values[position])).sum::<f64>() / models.models.len() as f64;
        let value = if logarithmic { mean.exp() } else { mean };
        tied.models.iter_mut().for_each(|m| m.values[position] = value);
    }
    tied
}

/// The effect that is the scale of a load.
#[must_use]
pub fn scale_of_load() -> Option<usize> {
    CATALOGUE.iter().position(|info| info.is_scale_of_load())
}

/// A model with a load of its own scale.
fn scaled(data: &ChannelData, model: &Extended, scale: f64) -> Extended {
    scale_of_load().map_or_else(|| model.clone(), |effect| model.with(&data.plant, effect, &[scale]))
}

/// Base models of a machine from which a search begins.
fn base_starts(channel: &MachineChannel) -> Vec<TiedModel> {
    let (data, count) = (&channel.recorded[0], channel.recorded.len());
    // Of two valves each has its own gain, and where the supply is high their ratio is large.
    let ratios: &[f64] = if data.plant.separate() { &VENT_GAINS } else { &VENT_GAINS[..1] };
    let vent = data.plant.position("gain_out");
    let grid = GAINS.iter().flat_map(|&gain| EDGES.map(|edge| start(data, gain, edge)));
    let grid = grid.flat_map(|model| {
        ratios.iter().map(move |ratio| {
            let mut model = model.clone();
            vent.into_iter().for_each(|k| model.values[k] *= ratio);
            model
        })
    });
    grid.map(|model| TiedModel::alike(with_usual(data, &scaled(data, &model, 1.0)), count)).collect()
}

/// The base model of a machine, without any cause, fitted to all recordings.
#[must_use]
pub fn fit_base(channel: &MachineChannel, tick: &(dyn Fn() + Sync)) -> Option<TiedModel> {
    let starts = base_starts(channel);
    let costs: Vec<f64> = parallel::map(starts.iter(), |start| cost(channel, start));
    let mut ranked: Vec<(f64, TiedModel)> = costs.into_iter().zip(starts).collect();
    ascending(&mut ranked, |item| item.0);
    let groups: Vec<Vec<TiedModel>> =
        ranked.into_iter().take(BASE_STARTS).map(|(_, start)| vec![start]).collect();
    race(channel, &groups, None, tick)
}

/// A known machine with a load of which nothing is known.
#[must_use]
pub fn known_base(channel: &MachineChannel, known: &Extended, tick: &(dyn Fn() + Sync)) -> Option<TiedModel> {
    let data = &channel.recorded[0];
    let of_load = |&e: &usize| CATALOGUE[e].parameters.iter().any(|p| p.of_load);
    let loads: Vec<usize> = known.effects.iter().copied().filter(of_load).collect();
    let bare = loads.iter().fold(known.clone(), |model, &e| model.without(&data.plant, e));
    let start = |scale: f64| vec![TiedModel::alike(scaled(data, &bare, scale), channel.recorded.len())];
    race(channel, &SCALES.map(start), Some(&known.effects), tick)
}

/// Models with one more effect from which a search begins, one group a probe: beside what `from`
/// has found, and of a machine that is not known also from anywhere.
#[must_use]
pub fn effect_starts(
    channel: &MachineChannel,
    from: &TiedModel,
    effect: usize,
    known: Option<&Extended>,
) -> Vec<Vec<TiedModel>> {
    let data = &channel.recorded[0];
    let parameters = data.plant.parameters();
    let gains: Vec<usize> = (0..parameters.len())
        .filter(|&k| parameters[k].unit == "mm2" && parameters[k].name != "corner")
        .collect();
    let weaker = |model: &Extended, factor: f64| {
        let mut model = rounded(data, model).unwrap_or_else(|| model.clone());
        gains.iter().for_each(|&k| model.values[k] *= factor);
        model
    };
    let rescaled = |model: &Extended, scale: f64| {
        let range = scale_of_load().and_then(|e| model.range(&data.plant, e));
        let mut model = model.clone();
        model.values[range.unwrap_or(0..0)].iter_mut().for_each(|v| *v *= scale);
        model
    };
    let calibrated = known.and_then(|k| Some(k.values[k.range(&data.plant, effect)?].to_vec()));
    let probes = CATALOGUE[effect].probes.iter().map(|p| p.to_vec()).chain(calibrated.clone());
    let plain = from.models[0].effects.len() <= 2 && known.is_none();
    probes
        .map(|mut probe| {
            // What is the machine's is known where the machine is.
            if let Some(calibrated) = &calibrated {
                let parameters = CATALOGUE[effect].parameters.iter();
                for ((value, known), p) in probe.iter_mut().zip(calibrated).zip(parameters) {
                    *value = if p.of_load { *value } else { *known };
                }
            }
            let with = |model: &Extended| model.with(&data.plant, effect, &probe);
            let mut group: Vec<TiedModel> = match known {
                Some(_) => SCALES.iter().map(|s| from.each(|m| with(&rescaled(m, *s)))).collect(),
                None => FACTORS.iter().map(|f| from.each(|m| with(&weaker(m, *f)))).collect(),
            };
            if plain {
                group.extend(base_starts(channel).iter().map(|start| start.each(with)));
            }
            group
        })
        .collect()
}
