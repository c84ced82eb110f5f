//! Fitting parameters, and judging how well the data determine them.
//!
//! An [`Objective`] streams residuals into [`Normal`] equations: [`RolloutObjective`] compares
//! simulations with measurements, [`RateObjective`] rates with derivatives. [`minimise`] searches
//! its least sum of squares within bounds, from many starts ([`best_of_starts`]), and
//! [`covariance`] and [`profile`] judge the minimum. [`fit_rollouts`] and [`fit_rates`] do it all.

mod covariance;
mod derivative;
mod jacobian;
mod levenberg;
mod lockstep;
mod long_run;
mod multistart;
mod normal;
mod objective;
mod profile;
mod rate;
mod report;
mod result;
mod rms;
mod run;
mod simulation;
mod space;

pub use covariance::{Covariance, covariance};
pub use derivative::{Slope, slopes};
pub use levenberg::{Ending, Minimum, Stopping, minimise};
pub use long_run::LongRun;
pub use multistart::{Best, Control, Progress, StartOutcome, best_of_starts, start_points};
pub use normal::{Accumulator, Normal};
pub use objective::Objective;
pub use profile::{ProfileInterval, profile};
pub use rate::RateObjective;
pub use result::{Bound, Fit, FittedParameter, Reason, Target, Undetermined};
pub use rms::rollout_rms_kpa;
pub use run::{FitError, FitOptions, Problem, fit_rates, fit_rollouts};
pub use simulation::{RolloutObjective, StartPressure};
pub use space::{Space, SpaceError};
