//! A calibrated chamber, step by step, from C: what a robot's simulator puts in the place of a
//! first-order actuator.
//!
//! ```text
//! parameter file (fit's, or extended.toml of a diagnosis)
//!        │ Channel::create: the only place that allocates or reads files
//!        ▼
//! Inputs ──▶ Channel::step ──▶ Outputs          save, restore: a row of numbers
//! (drive or set point,         (pressures, spool, temperature, rate)
//!  joint volume, supply)
//! ```
//!
//! A step is what `pneudrive-model simulate` does between two rows of a recording, with the same
//! numbers. Functions for C are in [`abi`]; `include/pneudrive.h` declares them, and
//! `examples/step.c` uses them.
//!
//! ```no_run
//! use pneudrive_capi::{Channel, Control};
//!
//! let mut chamber = Channel::create("extended.toml".as_ref(), "b0c0", 0.001, Control::AsCalibrated)?;
//! let mut inputs = *chamber.nominal();
//! chamber.start(0.0, &inputs)?;
//! inputs.set_point_kpa = 150.0;
//! for _ in 0..1000 {
//!     let outputs = chamber.step(&inputs)?;
//!     println!("{} s: {} kPa", outputs.time_s, outputs.pressure_kpa);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod abi;
mod channel;
mod engine;
mod error;
mod extended;
mod fitted;
mod fmi3;
mod inputs;
mod outputs;
mod partials;
mod prepare;
mod window;

pub use channel::Channel;
pub use error::{CreateError, StepError};
pub use inputs::{Control, Inputs, REPEATS_AFTER, REPEATS_END, REPEATS_START};
pub use outputs::{Outputs, STATE_PRESSURE};
pub use partials::Partials;
