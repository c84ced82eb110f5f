//! A whole diagnosis: from a recording to what the reports hold.

use crate::data::Recording;
use crate::diagnosis::channel::{ChannelData, Extended, Role, block_length_s, halved, simulate_coarsely};
use crate::diagnosis::design::{Plan, plan};
use crate::diagnosis::discrepancy::{
    Dependence, Rest, adequacy, corrected, correction_gain, imitated_beside, significant,
};
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::estimation::{ChannelStage, models_of};
use crate::diagnosis::evidence::Weighed;
use crate::diagnosis::json::{
    Baseline, BaselineChannel, Cause, Checks, Data, Report, SCHEMA, Unexplained, Verdict, Withheld,
};
use crate::diagnosis::likelihood::limit_cycle;
use crate::diagnosis::preconditions::{Purpose, check, much_missing, prepare_for};
use crate::diagnosis::report::{
    ExtendedFile, alternatives, band_holds, beside, earned, extended_file, measured_causes, probable, verdict,
};
use crate::diagnosis::rollout_errors::BlockErrors;
use crate::diagnosis::screening::Asked;
use crate::diagnosis::second_opinion::second_opinion;
use crate::diagnosis::selection::{Outcome, Progress, adopt, harms, is_shown, search};
use crate::diagnosis::settings::{self, SETTINGS};
use crate::effects::Question;
use crate::effects::catalogue::{CATALOGUE, index_of};
use crate::parallel;
use crate::rig::Rig;

/// File name of the extended model.
pub const EXTENDED_FILE: &str = "extended.toml";

/// How models were fitted where the usual way leaves too much.
const BY_LIKELIHOOD: &str = "The base model is so far from this recording that errors of rollouts say little about single causes. All models were fitted by a likelihood instead that has room for what none of them describes, and a cause is named only if it is the likeliest of the catalogue and its rollouts are the closest.";

/// Everything a report is made of.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// The result for programs.
    pub report: Report,
    /// The extended model.
    pub extended: ExtendedFile,
    /// The channels.
    pub channels: Vec<ChannelData>,
    /// Base models.
    pub base: Vec<Extended>,
    /// Final models, with their corrections: what `extended` holds.
    pub extended_models: Vec<Extended>,
    /// Final stages.
    pub stages: Vec<ChannelStage>,
    /// Stages of the base models.
    pub base_stages: Vec<ChannelStage>,
    /// Dependences of the base models' residuals, strongest first.
    pub symptoms: Vec<Dependence>,
    /// Dependences of what is left.
    pub left: Vec<Dependence>,
    /// The search.
    pub outcome: Outcome,
    /// Was a reference given?
    pub change: bool,
    /// The next experiment, where one would tell more.
    pub plan: Option<Plan>,
}

/// What is asked beside the recording and the rig.
#[derive(Debug, Clone, Copy, Default)]
pub struct Request<'a> {
    /// A calibrated model of the same rig, with its name for messages: then the question is what
    /// has changed since.
    pub reference: Option<(&'a str, &'a ExtendedFile)>,
    /// Highest pressure that a next experiment may command, kPa gauge; without it, the highest so
    /// far.
    pub highest_kpa: Option<f64>,
    /// Numbers of the effects in question, as [`index_of`] tells them; empty: the whole catalogue.
    pub only: &'a [usize],
}

/// Diagnoses a recording. `progress` is told what is being done, and of some work how far it is.
///
/// # Errors
/// [`DiagnosisError`] when the data cannot carry a diagnosis, or the reference does not fit.
pub fn diagnose(
    recording: &Recording,
    rig: &Rig,
    request: Request<'_>,
    progress: &Progress<'_>,
) -> Result<Diagnosis, DiagnosisError> {
    let (mut channels, mut notes) = prepare_for(recording, rig, Purpose::Compare)?;
    let file = recording.source.file.clone();
    notes.extend(check(&file, &channels)?);
    let calibrated = request.reference.map(|(name, file)| file.models(name, &channels)).transpose()?;
    let change = calibrated.is_some();
    let question = if change { Question::Change } else { Question::Structure };
    let asked = Asked { question, only: request.only };
    asked.check(&file, &channels)?;
    simulate_coarsely(&mut channels, true);
    let mut outcome = search(&mut channels, calibrated, asked, progress);
    for (data, model) in channels.iter().zip(&outcome.base) {
        if !data.residuals(model).iter().all(|r| r.is_finite()) {
            return Err(DiagnosisError::NoFit {
                file,
                model: data.plant.model.name(),
                channel: data.id.to_string(),
                hint:
                    "the simulation runs away; check the supply pressure, the units and the sign of the drive"
                        .to_owned(),
            });
        }
    }
    progress("measuring the gain", 0);
    let mut rest = Rest::new(&channels, &outcome, change);
    let shown = |effect: usize| is_shown(&channels, effect);
    let (seen, found): (Vec<_>, Vec<_>) = outcome.causes.iter().partition(|cause| shown(cause.effect));
    // What the rows show may harm; the search sees to it that nothing beside it does.
    let harms = || seen.is_empty() && harms(&channels, &rest.base_stages, &outcome.stages);
    if !found.is_empty() && (rest.imitated(&channels, &outcome) || harms()) {
        outcome.withdraw(&mut channels, &rest.base_stages);
        rest = Rest::new(&channels, &outcome, change);
    }
    if !change && let Some(named) = second_opinion(recording, rig, &channels, &outcome, asked, progress) {
        adopt(&mut outcome, &mut channels, named);
        rest = Rest::new(&channels, &outcome, change);
        notes.push(BY_LIKELIHOOD.to_owned());
    }
    progress("weighing explanations", 0);
    let weighed = alternatives::weighed(&channels, &outcome, &rest, change);
    simulate_coarsely(&mut channels, false);
    outcome.refine(&mut channels, change);
    let mut diagnosis = assemble(recording, rig, channels, outcome, (rest, &weighed), notes, change);
    let looped = diagnosis.channels.iter().any(|data| data.inputs.in_loop());
    diagnosis.report.weigh(&weighed, looped);
    diagnosis.report.asked = request.only.iter().map(|&effect| CATALOGUE[effect].id.to_owned()).collect();
    diagnosis.report.sentence =
        verdict::sentence(&diagnosis.report, change) + &much_missing(&diagnosis.channels);
    progress("planning the next experiment", 0);
    diagnosis.plan_next(rig, request.highest_kpa);
    Ok(diagnosis)
}

impl Diagnosis {
    /// Plans the next experiment, or notes why there is none.
    fn plan_next(&mut self, rig: &Rig, highest_kpa: Option<f64>) {
        // As in the search, where a difference of rivals is looked for and not a size.
        simulate_coarsely(&mut self.channels, true);
        match plan(&self.channels, &self.outcome, &self.report.causes, rig, highest_kpa) {
            Ok(plan) => {
                self.report.next_experiment = plan.as_ref().map(|p| p.experiment.clone());
                self.plan = plan;
            }
            Err(why) => self.report.notes.push(why),
        }
        simulate_coarsely(&mut self.channels, false);
    }
}

fn assemble(
    recording: &Recording,
    rig: &Rig,
    channels: Vec<ChannelData>,
    outcome: Outcome,
    (rest, explanations): (Rest, &[Weighed]),
    mut notes: Vec<String>,
    change: bool,
) -> Diagnosis {
    let finals = models_of(&outcome.stages);
    let base_errors = BlockErrors::of(&channels, &outcome.base, &[Role::Test]);
    let final_errors = BlockErrors::of(&channels, &finals, &[Role::Test]);
    let Rest { base_stages, symptoms, left, share } = rest;
    let imitated = if change { Vec::new() } else { imitated_beside(&channels, &outcome) };
    let causes = measured_causes(&channels, &outcome, &final_errors, change);
    let looped = channels.iter().any(|data| data.inputs.in_loop());
    let shown = |cause: &Cause| index_of(&cause.effect).is_some_and(|k| is_shown(&channels, k));
    let probability = |cause: &Cause| probable::probability(cause, explanations);
    let counted = |cause: &Cause| probable::counted(cause, explanations, looped, shown(cause));
    let allowed_kpa = adequacy::allowed_kpa(&channels, &finals);
    let circumstances = earned::Circumstances { change, looped, adequate: base_errors.all() <= allowed_kpa };
    let as_usual =
        if change { Vec::new() } else { alternatives::tied_with_the_usual(&channels, &outcome.causes) };
    let unearned = earned::Unearned { imitated: &imitated, as_usual: &as_usual };
    let (mut causes, mut imperfections) = earned::part(causes, unearned, circumstances, counted);
    if !change {
        let probable = |cause: &Cause| probability(cause) >= earned::EVEN;
        let (named, unnamed) = beside::part(causes, base_errors.all(), looped, probable);
        causes = named;
        imperfections.extend(unnamed);
    }
    let mut depends_on = significant(&channels, &left);
    let withheld = outcome.withheld.as_ref();
    depends_on.splice(..0, withheld.and_then(|w| adequacy::cycle(&channels, &outcome, &w.foil)));
    let extended_models = corrected(&channels, &outcome.stages, &left);
    let correction = correction_gain(&channels, &final_errors, &extended_models);
    let halved = halved_step(&channels, &finals);
    let gained = (base_errors.all() - final_errors.all()).max(SETTINGS.practical * base_errors.all());
    if !causes.is_empty() && halved > 0.2 * gained {
        notes.push(format!(
            "Halving the integration step changes the simulation by {halved:.2} kPa RMS, which is not small against the gain: take the causes with care."
        ));
    }
    notes.extend(limit_cycle::note(&channels, &finals));
    notes.extend(adequacy::poor(&channels, base_errors.all()));
    let left_kpa = final_errors.all();
    let rest = !depends_on.is_empty() || adequacy::beyond(left_kpa, allowed_kpa);
    let verdict = Verdict::new(!causes.is_empty(), rest);
    let id = |effect: usize| CATALOGUE[effect].id.to_owned();
    let withheld = withheld.map(|w| Withheld { effect: id(w.effect), foil: id(w.foil.effect) });
    // Beside the supply it may have earned its name.
    let withheld = withheld.filter(|w| causes.iter().all(|cause| cause.effect != w.effect));
    // Where nothing is named, the sentence says so.
    notes.extend(withheld.as_ref().filter(|_| verdict != Verdict::Unexplained).map(verdict::withheld));
    notes.extend(verdict::other_supply(&channels, &finals));
    let count = |role| channels.first().map_or(0, |d| d.blocks.iter().filter(|b| b.role == role).count());
    let extended = extended_file(&channels, &extended_models, rig);
    let report = Report {
        schema: SCHEMA.to_owned(),
        data: Data {
            file: recording.source.file.clone(),
            rows: recording.rows(),
            rate_hz: recording.rate_hz(),
            seconds: recording.duration_s(),
        },
        verdict,
        sentence: String::new(),
        baseline: baseline(&channels, &outcome.base, &base_errors),
        symptoms: significant(&channels, &symptoms),
        causes,
        imperfections,
        unexplained: Unexplained { share, test_rmse_kpa: left_kpa, correction, depends_on, withheld },
        next_experiment: None,
        extended_model: Some(EXTENDED_FILE.to_owned()),
        notes,
        checks: Checks {
            halved_step_rms_kpa: halved,
            allowed_rmse_kpa: allowed_kpa,
            blocks: [count(Role::Fit), count(Role::Select), count(Role::Test)],
            block_s: block_length_s(recording.duration_s()),
            band_holds: band_holds([(&channels[..], &extended_models[..], &extended)]),
        },
        settings: settings::list().into_iter().map(|s| (s.name.to_owned(), s.value)).collect(),
        alternatives: Vec::new(),
        machine: None,
        asked: Vec::new(),
    };
    Diagnosis {
        report,
        extended,
        base: outcome.base.clone(),
        extended_models,
        stages: outcome.stages.clone(),
        base_stages,
        symptoms,
        left,
        channels,
        outcome,
        change,
        plan: None,
    }
}

/// The base models with their errors.
fn baseline(channels: &[ChannelData], base: &[Extended], errors: &BlockErrors) -> Baseline {
    let variance = channels.iter().map(|d| d.noise_kpa.powi(2)).sum::<f64>() / channels.len() as f64;
    let of = |(k, data): (usize, &ChannelData)| {
        let named = data.plant.parameters().into_iter().zip(&base[k].values);
        let channel = BaselineChannel {
            parameters: named.map(|(p, v)| (p.name, *v)).collect(),
            test_rmse_kpa: errors.channel(k),
        };
        (data.id.to_string(), channel)
    };
    Baseline {
        model: channels.first().map_or("nonlinear", |d| d.plant.model.name()).to_owned(),
        test_rmse_kpa: errors.all(),
        noise_floor_kpa: variance.sqrt(),
        channels: channels.iter().enumerate().map(of).collect(),
    }
}

/// RMS change of the final simulation when the integration step is halved, kPa.
fn halved_step(channels: &[ChannelData], models: &[Extended]) -> f64 {
    let squares: Vec<Vec<f64>> = parallel::map(channels.iter().zip(models), |(data, model)| {
        let finer = halved(data).readings(model);
        data.readings(model).iter().zip(finer).map(|(a, b)| (a - b).powi(2)).collect()
    });
    let count: usize = squares.iter().map(Vec::len).sum();
    (squares.iter().flatten().sum::<f64>() / f64::max(count as f64, 1.0)).sqrt()
}
