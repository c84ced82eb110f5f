//! Simulating the channels of a recording with a calibrated model: pressures in kPa from commands
//! or drives alone.
//!
//! ```text
//! CalibratedModel (what fit or diagnose saved) + Recording -> simulate -> Simulation
//! ```

mod calibrated;
mod error;
mod extended;
mod first_order;
mod fitted;
mod result;
mod run;

pub use calibrated::CalibratedModel;
pub use error::SimulationError;
pub use first_order::{FirstOrder, first_order};
pub use result::{SimulatedBand, SimulatedChannel, SimulatedModel, Simulation, SimulationSettings};
pub use run::simulate;
