//! Several recordings of one machine, whose loads differ.
//!
//! ```text
//! recordings    one channel in each
//!   -> ties             what is the machine's, what the load's
//!   -> objective, fit   all recordings together
//!   -> candidates       the catalogue, "something else", pairs
//!   -> evidence         their densities on held-out parts
//!   -> held_out         what is gained with the curves of the other recordings
//!   -> search, report, run, page
//! ```
//!
//! Valves, supply and sensor are the machine's and alike in all recordings; volume, tube and walls
//! are each recording's own. One recording hardly tells a valve's curve from what is behind it.
//! Several do, and where the machine is known already (its curves from an earlier diagnosis), one
//! is enough.

mod candidates;
mod evidence;
mod fit;
mod held_out;
mod loads;
mod objective;
pub mod page;
mod recordings;
mod report;
mod run;
mod search;
mod sentence;
mod sizes;
mod ties;

#[cfg(test)]
mod tests;

pub use run::{MachineDiagnosis, MachineRequest, diagnose_machine};
