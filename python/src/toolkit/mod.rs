//! The modelling toolkit: recordings and rigs in, fits, simulations, comparisons and diagnoses out.

mod arguments;
mod batch;
mod catalogue;
pub mod columns;
mod comparing;
mod comparison;
mod convert;
#[cfg_attr(not(feature = "sim"), path = "no_data_set.rs")]
mod data_set;
mod diagnosis;
mod displays;
mod expected;
mod extended;
mod fitting;
mod loading;
mod parameters;
mod pool;
mod recording;
mod rig;
mod shapes;
mod simulation;
mod stepping;
mod work;

pub use batch::{batch_gradient, model_parameters, simulate_batch};
pub use catalogue::effects;
pub use comparing::compare;
pub use comparison::Comparison;
pub use data_set::record_data_set;
pub use diagnosis::{Diagnosis, diagnose};
pub use extended::ExtendedModel;
pub use fitting::{Fit, fit};
pub use loading::load;
pub use parameters::Parameters;
pub use pool::imported;
pub use recording::Recording;
pub use rig::Rig;
pub use simulation::{Simulation, simulate};
pub use stepping::Stepper;
