//! The next experiment: commands that tell apart what the recordings so far cannot.
//!
//! ```text
//! a cause and its rivals -> explanations, each fitted to the recordings so far
//!     menu of excitations -> each explanation simulated under each -> separation -> the best
//!     -> next_experiment.csv
//! ```

mod menu;
mod planned;
mod separation;
mod trajectory;

use crate::diagnosis::estimation::{ChannelStage, models_of, refit};
use crate::diagnosis::settings::SETTINGS;
use crate::order::descending;

pub use menu::Excitation;
pub use separation::{Explanation, Separation, separation};

use crate::diagnosis::channel::{ChannelData, Extended};
use crate::diagnosis::json::{Cause, ConsideredExperiment, NextExperiment};
use crate::diagnosis::likelihood::Whitening;
use crate::diagnosis::report::verdict;
use crate::diagnosis::selection::{Found, Outcome};
use crate::effects::catalogue::CATALOGUE;
use crate::parallel;
use crate::rig::Rig;
use planned::realisable;

/// File name of the commands.
pub const TRAJECTORY_FILE: &str = "next_experiment.csv";
/// Rivals that are looked at beside the cause itself.
const MOST_RIVALS: usize = 3;
/// Channels on which the separation is computed.
const MOST_WATCHED: usize = 2;
/// Evaluations of a rival's refit to the recordings so far.
const EVALUATIONS: usize = 10;
/// Part of the best separation that is good enough for a shorter excitation.
const NEARLY: f64 = 0.7;
/// Highest part of the supply's gauge pressure that is commanded.
const OF_SUPPLY: f64 = 0.9;
/// What stands for "not there" among the rivals.
pub const NOTHING: &str = "nothing";

/// An experiment to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// For report.json.
    pub experiment: NextExperiment,
    /// Content of the command file.
    pub trajectory: String,
}

/// What the experiment is about.
struct Question {
    /// Names of the explanations, the cause's first.
    names: Vec<String>,
    explanations: Vec<Explanation>,
}

/// Plans the next experiment for the largest tie, or else for a cause at its detection limit.
/// `highest_kpa` limits the commands; without it they stay within those of the recordings. `Err`
/// says why there is a question but no experiment.
///
/// # Errors
/// A sentence: why no experiment can be played.
pub fn plan(
    channels: &[ChannelData],
    outcome: &Outcome,
    causes: &[Cause],
    rig: &Rig,
    highest_kpa: Option<f64>,
) -> Result<Option<Plan>, String> {
    let tied = causes.iter().find(|c| !c.equivalent.is_empty());
    let Some(cause) = tied.or_else(|| causes.iter().find(|c| at_its_limit(c))) else {
        return Ok(None);
    };
    let Some(found) = outcome.causes.iter().find(|f| CATALOGUE[f.effect].id == cause.effect) else {
        return Ok(None);
    };
    if !channels.iter().all(realisable) {
        return Err(format!(
            "No next experiment is planned, because without [controller] and [sensor] in the rig file, or with two valves a channel, it is not known what a board makes of commands. What would tell: {}.",
            CATALOGUE[found.effect].separated_by
        ));
    }
    let question = question(channels, outcome, cause, found);
    if question.explanations.len() < 2 {
        return Ok(None);
    }
    let range_kpa = range(channels, rig, highest_kpa);
    let watched: Vec<usize> = (0..channels.len()).filter(|&k| found.acts[k]).take(MOST_WATCHED).collect();
    let possible = Excitation::ALL.iter().filter(|e| channels.len() > 1 || !e.needs_several());
    let looked = parallel::map(possible, |&e| {
        Some((e, separation(channels, &question.explanations, &watched, e, range_kpa)?))
    });
    let mut looked: Vec<(Excitation, Separation)> = looked.into_iter().flatten().collect();
    descending(&mut looked, |item| item.1.squared);
    let Some(most) = looked.first().map(|l| l.1.squared) else {
        return Ok(None);
    };
    let good = looked.iter().filter(|l| l.1.squared >= NEARLY * most);
    let Some(&(best, apart)) = good.min_by(|a, b| a.0.seconds().total_cmp(&b.0.seconds())) else {
        return Ok(None);
    };
    let noise_kpa = watched.iter().map(|&k| channels[k].noise_kpa).sum::<f64>() / watched.len().max(1) as f64;
    let so_far: usize = watched.iter().map(|&k| channels[k].rows.len()).sum();
    // The rule for ties, on both recordings together.
    let settles = apart.squared > 2.0 * SETTINGS.practical * (so_far + apart.rows) as f64;
    let considered = looked.iter().map(|(e, s)| ConsideredExperiment {
        excitation: e.name().to_owned(),
        seconds: e.seconds(),
        separation_kpa: s.rms_kpa,
    });
    let experiment = NextExperiment {
        cause: cause.effect.clone(),
        rivals: question.names.clone(),
        excitation: best.name().to_owned(),
        trajectory: TRAJECTORY_FILE.to_owned(),
        seconds: best.seconds(),
        range_kpa,
        separation_kpa: apart.rms_kpa,
        separation_noise: apart.rms_kpa / noise_kpa,
        expected_to_settle: settles,
        reason: reason(&question.names, best, &apart, noise_kpa, settles),
        instruction: instruction(best, range_kpa),
        considered: considered.collect(),
    };
    Ok(Some(Plan { trajectory: trajectory::csv(channels, best, range_kpa), experiment }))
}

/// Is it doubtful whether the cause is there at all?
fn at_its_limit(cause: &Cause) -> bool {
    cause.gain.ci95[0] <= 0.0 || cause.parameters.values().all(|e| e.ci95.is_none())
}

fn question(channels: &[ChannelData], outcome: &Outcome, cause: &Cause, found: &Found) -> Question {
    let mut names = vec![cause.effect.clone()];
    let finals = models_of(&outcome.stages);
    let mut explanations = vec![explanation(channels, &outcome.stages, &finals)];
    let without: Vec<Extended> = channels
        .iter()
        .zip(&outcome.stages)
        .map(|(data, stage)| stage.model.without(&data.plant, found.effect))
        .collect();
    if cause.equivalent.is_empty() {
        names.push(NOTHING.to_owned());
        explanations.push(explanation(channels, &outcome.stages, &without));
    }
    let named = |id: &String| found.rivals.iter().find(|r| CATALOGUE[r.effect].id == *id);
    for rival in cause.equivalent.iter().filter_map(named).take(MOST_RIVALS) {
        let models: Vec<Extended> = channels
            .iter()
            .zip(&without)
            .zip(&rival.models)
            .map(|((data, without), fitted)| match fitted.range(&data.plant, rival.effect) {
                Some(range) if !without.has(rival.effect) => {
                    without.with(&data.plant, rival.effect, &fitted.values[range])
                }
                _ => without.clone(),
            })
            .collect();
        names.push(CATALOGUE[rival.effect].id.to_owned());
        explanations.push(explanation(channels, &outcome.stages, &models));
    }
    Question { names, explanations }
}

/// Models refitted to the recordings so far. What is free follows from the stages: their base
/// parameters, and all of the effects.
fn explanation(channels: &[ChannelData], stages: &[ChannelStage], models: &[Extended]) -> Explanation {
    let refitted: Vec<ChannelStage> =
        parallel::map(channels.iter().zip(stages).zip(models), |((data, stage), model)| {
            let base = data.plant.parameters().len();
            let own = stage.free.iter().copied().filter(|k| *k < base);
            let free: Vec<usize> = own.chain(base..model.values.len()).collect();
            let whitening = Whitening::new(data, &data.disturbances(model));
            let (model, _) = refit(data, &whitening, model, &free, EVALUATIONS);
            ChannelStage::new(data, model, free)
        });
    Explanation::new(channels, &refitted)
}

/// Pressures between which is commanded, kPa gauge.
fn range(channels: &[ChannelData], rig: &Rig, highest_kpa: Option<f64>) -> [f64; 2] {
    let gauge = |data: &ChannelData, pa: &[f64]| {
        let kpa = pa.iter().map(|p| (p - data.inputs.ambient_pa) * 1e-3);
        kpa.fold((f64::INFINITY, 0.0_f64), |(low, high), p| (low.min(p), high.max(p)))
    };
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    for data in channels {
        // What was commanded, or, in a recording without commands, what was reached.
        let commanded = gauge(data, &data.inputs.command_pa);
        let seen = if commanded.1 > 1.0 { commanded } else { gauge(data, &data.inputs.measured_pa) };
        (low, high) = (low.min(seen.0), high.max(seen.1));
    }
    let supply = rig.supply.as_ref().map_or(f64::INFINITY, |s| OF_SUPPLY * s.pressure_kpa);
    let sensors = channels.iter().filter_map(|data| rig.sensor_limits(data.id));
    let sensor = sensors.map(|limits| 0.95 * limits.high_kpa).fold(f64::INFINITY, f64::min);
    let limit = rig.highest_set_point_kpa.unwrap_or(f64::INFINITY);
    let high = highest_kpa.unwrap_or(high).min(supply).min(sensor).min(limit);
    let low = low.clamp(0.0, 0.15 * high);
    [low, high].map(|kpa| (kpa * 10.0).round() / 10.0)
}

fn title(id: &str) -> &str {
    if id == NOTHING { "no such effect at all" } else { verdict::title(id) }
}

fn reason(names: &[String], best: Excitation, apart: &Separation, noise_kpa: f64, settles: bool) -> String {
    let quoted: Vec<String> = names.iter().map(|id| format!("\"{}\"", title(id))).collect();
    let expected = if settles {
        "That is enough to tell them apart."
    } else {
        "That may not be enough: repeat it, or allow a higher pressure with --highest-kpa."
    };
    format!(
        "So far {} explain the data equally well. With {} their predictions would differ by {:.2} kPa (root mean square; sensor noise is {noise_kpa:.2} kPa), even after each is refitted. {expected}",
        quoted.join(" and "),
        best.words(),
        apart.rms_kpa,
    )
}

fn instruction(best: Excitation, [low, high]: [f64; 2]) -> String {
    format!(
        "Play {TRAJECTORY_FILE} ({}, {:.0} s, {low:.0} to {high:.0} kPa) with `pneudrive-host --port PORT --trajectory {TRAJECTORY_FILE} --record next.csv`, then diagnose this recording and next.csv together.",
        best.words(),
        best.seconds()
    )
}
