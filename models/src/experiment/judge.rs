//! Judging the fitted models, channel by channel and all together.

use crate::data::InputError;
use crate::fit::{Fit, FitError};
use crate::rig::Rig;
use crate::rollout::Start;

use super::score::{Basis, score_on};
use super::{ChannelComparison, ModelKind, ModelResult, Overall, Prepared, Score, Trace, score};

/// Judges a fitted model on both parts of a channel; what keeps it from that is said in the result.
pub(super) fn judge(
    model: ModelKind,
    prepared: Result<Prepared, InputError>,
    fit: Option<Result<Fit, FitError>>,
    rig: &Rig,
    first_row: usize,
    clock: &dyn Fn() -> f64,
) -> ModelResult {
    let mut result = ModelResult {
        model,
        setup: prepared.as_ref().ok().map(|p| p.setup),
        error: None,
        rollout: None,
        one_step: None,
        rollout_fitted: None,
        evaluation_s: None,
        fit: None,
        trace: None,
    };
    let prepared = match prepared {
        Ok(prepared) => prepared,
        Err(error) => {
            result.error = Some(error.to_string());
            return result;
        }
    };
    let fit = match fit {
        Some(Ok(fit)) => fit,
        Some(Err(error)) => {
            result.error = Some(error.to_string());
            return result;
        }
        None => return result,
    };
    let (subject, values) = (&prepared.subject, fit.values());
    let [fitted, judging] = &prepared.series[..] else { return result };
    let starts = fit.starts();
    let start = if starts.is_empty() { Start::Measured } else { Start::Given(&starts) };
    result.rollout_fitted = score(fitted, &subject.simulate(&values, fitted, start, fit.substeps));
    let rollout = subject.simulate(&values, judging, Start::Measured, fit.substeps);
    result.rollout = score(judging, &rollout);
    let steps = subject.one_step(&values, judging, fit.substeps);
    result.one_step = score_on(judging, &steps, Basis::Change);
    result.evaluation_s = Some(evaluation_time(&prepared, &values, clock));
    let ambient_kpa = rig.ambient_or_standard().pressure_kpa_abs;
    let gauge = rollout.iter().map(|pa| pa * 1e-3 - ambient_kpa).collect();
    result.trace = Some(Trace { first_row, rollout_kpa: gauge });
    result.fit = Some(fit);
    result
}

/// Seconds for one evaluation of the right-hand side, from at least a few milliseconds' worth.
fn evaluation_time(prepared: &Prepared, values: &[f64], clock: &dyn Fn() -> f64) -> f64 {
    const LEAST_S: f64 = 5e-3;
    const MOST_ROUNDS: u32 = 10_000;
    let series = &prepared.series[0];
    let per_round: usize = series.segments().iter().map(std::ops::Range::len).sum();
    let began = clock();
    let mut rounds = 0;
    while rounds < MOST_ROUNDS {
        std::hint::black_box(prepared.subject.evaluate_all(values, series));
        rounds += 1;
        if clock() - began > LEAST_S {
            break;
        }
    }
    // Rows are far fewer than 2^52.
    (clock() - began) / (f64::from(rounds) * per_round as f64)
}

/// What counts of one channel towards the whole.
struct Judged {
    rollout: Score,
    one_step_r2: f64,
    evaluation_s: f64,
}

/// One model over all channels; `None` when it could be applied to none.
pub(super) fn overall(model: ModelKind, channels: &[ChannelComparison], fit_s: f64) -> Option<Overall> {
    let results: Vec<Judged> = channels
        .iter()
        .flat_map(|c| c.models.iter().filter(|m| m.model == model))
        .filter_map(|m| {
            let one_step_r2 = m.one_step.map_or(f64::NAN, |s| s.r2);
            Some(Judged { rollout: m.rollout?, one_step_r2, evaluation_s: m.evaluation_s? })
        })
        .collect();
    if results.is_empty() {
        return None;
    }
    // A handful of channels.
    let count = results.len() as f64;
    let mean = |value: &dyn Fn(&Judged) -> f64| results.iter().map(value).sum::<f64>() / count;
    Some(Overall {
        model,
        channels: results.len(),
        rollout_rmse_kpa: mean(&|r| r.rollout.rmse_kpa.powi(2)).sqrt(),
        rollout_r2: mean(&|r| r.rollout.r2),
        rollout_iae_kpa_s: mean(&|r| r.rollout.iae_kpa_s) * count,
        one_step_r2: mean(&|r| r.one_step_r2),
        evaluation_s: mean(&|r| r.evaluation_s),
        fit_s,
    })
}
