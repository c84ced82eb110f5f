//! Fits from beginning to end.

use thiserror::Error;

use super::levenberg::{Stopping, minimise};
use super::multistart::{Best, Control, best_of_starts};
use super::report::{Found, report};
use super::result::{Fit, Target};
use super::{Objective, RateObjective, RolloutObjective, Space, StartPressure};
use crate::rollout::{Series, Start, System, choose_substeps};

/// Settings of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitOptions {
    /// Number of starts.
    pub starts: usize,
    /// Seed of the starts' points.
    pub seed: u64,
    /// Is the pressure at the start of a segment measured or fitted?
    pub start_pressure: StartPressure,
    /// Runge-Kutta steps per tick to begin with.
    pub substeps: usize,
    /// Steps are halved until that changes no pressure by more than this, Pa.
    pub integration_tolerance_pa: f64,
    /// Compute profile-likelihood intervals.
    pub profiles: bool,
    /// When a search ends.
    pub stopping: Stopping,
}

impl Default for FitOptions {
    /// Twenty starts on rollouts with fitted start pressures. The integration error stays below a
    /// twentieth of a sensor count (0.84 kPa).
    fn default() -> Self {
        Self {
            starts: 20,
            seed: 1,
            start_pressure: StartPressure::Fitted,
            substeps: 1,
            integration_tolerance_pa: 40.0,
            profiles: false,
            stopping: Stopping::default(),
        }
    }
}

/// Why a fit is impossible.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FitError {
    /// Every parameter is fixed.
    #[error("every parameter is fixed, there is nothing to fit")]
    NothingFree,
    /// Fewer residuals than unknowns.
    #[error("{residuals} usable samples do not determine {unknowns} unknowns")]
    TooFewSamples {
        /// Usable samples.
        residuals: usize,
        /// Free parameters and start pressures.
        unknowns: usize,
    },
    /// The simulation runs away from every start.
    #[error(
        "the simulation runs away from every one of {starts} starts; check units, supply pressure and bounds"
    )]
    RunsAway {
        /// Starts that were made.
        starts: usize,
    },
}

/// A system, what was measured, and which parameters are free.
#[derive(Debug, Clone)]
pub struct Problem<'a> {
    /// The system.
    pub system: &'a dyn System,
    /// Inputs and measurements.
    pub series: &'a Series,
    /// Parameters.
    pub space: Space,
}

/// Fits rollouts: each problem (say, each channel) on its own, all of them and all their starts in
/// parallel.
pub fn fit_rollouts(
    problems: &[Problem<'_>],
    options: &FitOptions,
    control: Control<'_>,
) -> Vec<Result<Fit, FitError>> {
    let objectives: Vec<RolloutObjective<'_>> =
        problems.iter().map(|problem| problem.rollouts(options, options.substeps)).collect();
    let searches = search_all(&objectives, problems, options, control);
    let finish = |(problem, best): (&Problem<'_>, Result<Best, FitError>)| {
        Ok(finish_rollouts(problem, best?, options, control))
    };
    problems.iter().zip(searches).map(finish).collect()
}

/// Fits rates ([`RateObjective`]) with a smoothing derivative over `half_width` samples to either
/// side, of systems that have them ([`System::has_rates`]).
pub fn fit_rates(
    problems: &[Problem<'_>],
    half_width: usize,
    options: &FitOptions,
    control: Control<'_>,
) -> Vec<Result<Fit, FitError>> {
    let objectives: Vec<RateObjective<'_>> = problems
        .iter()
        .map(|problem| RateObjective::new(problem.system, problem.series, problem.space.clone(), half_width))
        .collect();
    let searches = search_all(&objectives, problems, options, control);
    let finish = |(objective, best): (&RateObjective<'_>, Result<Best, FitError>)| {
        let found = Found {
            best: best?,
            target: Target::Rate { half_width },
            start_pressures_pa: vec![],
            substeps: options.substeps,
            integration_error_pa: None,
        };
        Ok(report(objective, objective.space(), found, options, control))
    };
    objectives.iter().zip(searches).map(finish).collect()
}

impl<'a> Problem<'a> {
    fn rollouts(&self, options: &FitOptions, substeps: usize) -> RolloutObjective<'a> {
        RolloutObjective::new(self.system, self.series, self.space.clone(), options.start_pressure, substeps)
    }
}

/// Checks every problem and searches the ones that can be fitted, all starts of all problems in
/// parallel.
fn search_all<O: Objective>(
    objectives: &[O],
    problems: &[Problem<'_>],
    options: &FitOptions,
    control: Control<'_>,
) -> Vec<Result<Best, FitError>> {
    let checks: Vec<Result<(), FitError>> = objectives
        .iter()
        .zip(problems)
        .map(|(objective, problem)| check(objective, &problem.space))
        .collect();
    let sound: Vec<(&O, usize)> = objectives
        .iter()
        .zip(problems)
        .zip(&checks)
        .filter(|(_, check)| check.is_ok())
        .map(|((objective, problem), _)| (objective, problem.space.free_count()))
        .collect();
    let mut found =
        best_of_starts(&sound, options.starts, options.seed, &options.stopping, control).into_iter();
    let outcome = |check: Result<(), FitError>| {
        check?;
        let best = found.next().ok_or(FitError::RunsAway { starts: 0 })?;
        if best.minimum.normal.is_finite() {
            Ok(best)
        } else {
            Err(FitError::RunsAway { starts: best.starts.len() })
        }
    };
    checks.into_iter().map(outcome).collect()
}

fn check(objective: &impl Objective, space: &Space) -> Result<(), FitError> {
    let (residuals, unknowns) = (objective.residuals(), objective.dimension());
    if space.free_count() == 0 {
        Err(FitError::NothingFree)
    } else if residuals <= unknowns {
        Err(FitError::TooFewSamples { residuals, unknowns })
    } else {
        Ok(())
    }
}

/// Halves the step until the best rollout no longer depends on it, refits with that step, and
/// reports.
fn finish_rollouts(problem: &Problem<'_>, mut best: Best, options: &FitOptions, control: Control<'_>) -> Fit {
    const MOST_SUBSTEPS: usize = 64;
    let tolerance = options.integration_tolerance_pa;
    let mut substeps = options.substeps;
    loop {
        let objective = problem.rollouts(options, substeps);
        let starts = objective.start_pressures(&best.minimum.coordinates);
        let values = problem.space.values(&best.minimum.coordinates);
        let start = Start::Given(&starts);
        let check = choose_substeps(
            problem.system,
            &values,
            problem.series,
            start,
            (substeps, MOST_SUBSTEPS),
            tolerance,
        );
        if check.substeps == substeps || control.cancelled() {
            let found = Found {
                best,
                target: Target::Rollout,
                start_pressures_pa: starts.iter().map(|&start| vec![start]).collect(),
                substeps,
                integration_error_pa: Some(check.max_pa),
            };
            return report(&objective, &problem.space, found, options, control);
        }
        substeps = check.substeps;
        let finer = problem.rollouts(options, substeps);
        best.minimum =
            minimise(&finer, &finer.bounds(), &best.minimum.coordinates, &options.stopping, control.cancel);
    }
}
