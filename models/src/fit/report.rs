//! From a minimum to a [`Fit`]: values, intervals, and what the data leave open.

use super::covariance::{Covariance, covariance};
use super::levenberg::{Ending, Minimum};
use super::multistart::{Best, Control};
use super::profile::profile;
use super::result::{Bound, Fit, FittedParameter, Reason, Target, Undetermined};
use super::{FitOptions, Objective, Space};
use crate::model::Parameter;

/// Confidence level of all intervals.
const LEVEL: f64 = 0.95;

/// Correlation above which two parameters make up for each other.
const CONFOUNDED: f64 = 0.999;

/// Share of a parameter's range that its interval must not exceed to call the parameter determined.
const WIDE: f64 = 0.5;

/// What a search found, before it is judged.
pub(super) struct Found {
    pub best: Best,
    pub target: Target,
    pub start_pressures_pa: Vec<Vec<f64>>,
    pub substeps: usize,
    pub integration_error_pa: Option<f64>,
}

/// Judges a minimum. The first coordinates of the objective are the free parameters of `space`.
pub(super) fn report(
    objective: &impl Objective,
    space: &Space,
    found: Found,
    options: &FitOptions,
    control: Control<'_>,
) -> Fit {
    let agreeing_starts = found.best.agreeing();
    let Best { minimum, starts } = found.best;
    let precision = covariance(objective, &minimum);
    let values = space.values(&minimum.coordinates);
    let free: Vec<usize> = space.free_indices().collect();
    let slopes = space.slopes(&minimum.coordinates);
    let mut parameters: Vec<FittedParameter> =
        space.parameters().iter().zip(&values).map(|(parameter, value)| fixed(parameter, *value)).collect();
    for (j, &index) in free.iter().enumerate() {
        let judged = judge(&space.parameters()[index], &minimum, &precision, j, slopes[j]);
        parameters[index] = FittedParameter { value: values[index], ..judged };
        if options.profiles && !control.cancelled() {
            let rise =
                precision.quantile(j, LEVEL).powi(2) * precision.residual_variance * precision.inflation[j];
            let error = precision.standard_errors[j];
            let interval = profile(objective, &minimum, j, rise, error, control.cancel);
            let physical = |end: Option<f64>| end.map(|x| value_at(&space.parameters()[index], x));
            parameters[index].profile95 = Some([physical(interval.lower), physical(interval.upper)]);
        }
    }
    let covariance = (0..free.len())
        .map(|a| (0..free.len()).map(|b| precision.matrix[(a, b)] * slopes[a] * slopes[b]).collect())
        .collect();
    #[allow(clippy::cast_precision_loss)] // far below 2^52
    let residuals = objective.residuals() as f64;
    Fit {
        undetermined: undetermined(space, &free, &minimum, &precision),
        parameters,
        target: found.target,
        rms: (minimum.normal.cost / residuals).sqrt(),
        residuals: objective.residuals(),
        start_pressures_pa: found.start_pressures_pa,
        condition: precision.condition,
        free: free.iter().map(|&index| space.parameters()[index].name.clone()).collect(),
        covariance,
        effective_samples: precision.effective_samples,
        substeps: found.substeps,
        integration_error_pa: found.integration_error_pa,
        ending: minimum.ending,
        starts,
        agreeing_starts,
        seed: options.seed,
    }
}

fn fixed(parameter: &Parameter, value: f64) -> FittedParameter {
    FittedParameter {
        name: parameter.name.clone(),
        unit: parameter.unit,
        value,
        fixed: true,
        at_bound: None,
        standard_error: None,
        ci95: None,
        profile95: None,
    }
}

/// The value of a parameter at a coordinate.
fn value_at(parameter: &Parameter, coordinate: f64) -> f64 {
    parameter.scale.value(coordinate)
}

/// A free parameter with its interval.
fn judge(
    parameter: &Parameter,
    minimum: &Minimum,
    precision: &Covariance,
    j: usize,
    slope: f64,
) -> FittedParameter {
    let error = precision.standard_errors[j];
    let bound = if minimum.normal.gradient[j] > 0.0 { Bound::Lower } else { Bound::Upper };
    let at_bound = minimum.active[j].then_some(bound);
    // Where a search was stopped there is no minimum whose curvature would tell anything.
    let known = at_bound.is_none() && error.is_finite() && minimum.ending != Ending::Cancelled;
    let half = precision.quantile(j, LEVEL) * error;
    let centre = minimum.coordinates[j];
    FittedParameter {
        fixed: false,
        at_bound,
        standard_error: known.then_some(error * slope),
        ci95: known.then(|| [value_at(parameter, centre - half), value_at(parameter, centre + half)]),
        ..fixed(parameter, 0.0)
    }
}

fn undetermined(
    space: &Space,
    free: &[usize],
    minimum: &Minimum,
    precision: &Covariance,
) -> Vec<Undetermined> {
    let bounds = space.bounds();
    let name = |j: usize| space.parameters()[free[j]].name.clone();
    let reason = |j: usize| {
        if minimum.active[j] {
            return None;
        }
        if minimum.normal.matrix[(j, j)] <= 0.0 {
            return Some(Reason::NoEffect);
        }
        let rivals: Vec<String> = (0..free.len())
            .filter(|&other| other != j && precision.correlation[(j, other)].abs() > CONFOUNDED)
            .map(name)
            .collect();
        let width = 2.0 * precision.quantile(j, LEVEL) * precision.standard_errors[j];
        let wide = width > WIDE * (bounds[j].1 - bounds[j].0);
        match (rivals.is_empty(), wide) {
            (false, _) => Some(Reason::Confounded(rivals)),
            (true, true) => Some(Reason::Wide),
            (true, false) => None,
        }
    };
    (0..free.len()).filter_map(|j| Some(Undetermined { name: name(j), reason: reason(j)? })).collect()
}
