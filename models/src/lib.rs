//! Pressure models of pneumatic chambers: measured data, simulation, fitting, comparison,
//! diagnosis.
//!
//! The modules in the order a recording passes through them:
//!
//! * [`data`]: recordings: reading, checking, masking, importing foreign columns;
//! * [`rig`]: the TOML description of the machine that made a recording;
//! * [`model`]: the pressure models, written once over the numbers of [`numeric`];
//! * [`board`]: the board that drives a valve: its sensor and its controller;
//! * [`rollout`]: simulating them, alone, behind the board's controller, or thousands at once;
//! * [`fit`]: finding their parameters, and how well the data determine them;
//! * [`experiment`]: the three models on one recording: fitted, judged, compared;
//! * [`simulation`]: a recording simulated with what a fit or a diagnosis found;
//! * [`effects`]: the catalogue of physical effects, and channels simulated with them;
//! * [`diagnosis`]: what a simulation gets wrong, why, and what modelling it gains;
//! * [`overview`]: a recording at a glance, as a page;
//! * [`watch`]: a calibrated model beside the rig: what has changed, and since when;
//! * [`store`]: parameter files;
//! * [`export`]: what other simulators are given of a calibrated model;
//! * [`report`]: self-contained HTML pages with plots.
//!
//! [`data`] and [`rig`] are the crate `pneudrive-data`, which fits nothing; [`numeric`], [`model`],
//! [`board`], [`rollout`] and [`effects`] are the crate `pneudrive-plant`, which reads no files.
//!
//! Pressures are kPa gauge at the border (recordings, rig files, results) and Pa absolute inside.
//! Nothing prints: that is for the program `pneudrive-model`, the crate `pneudrive-model-cli`.
//!
//! Four things that most callers want, each an example of its own
//! (`cargo run -p pneudrive-model --example fit`):
//!
//! # Fit
//!
//! ```
#![doc = include_str!("../examples/fit.rs")]
//! ```
//!
//! # Simulate
//!
//! ```
#![doc = include_str!("../examples/simulate.rs")]
//! ```
//!
//! # Compare
//!
//! ```
#![doc = include_str!("../examples/compare.rs")]
//! ```
//!
//! # Diagnose
//!
//! ```
#![doc = include_str!("../examples/diagnose.rs")]
//! ```

pub mod diagnosis;
pub mod experiment;
pub mod export;
pub mod fit;
mod noise;
mod order;
pub mod overview;
pub mod report;
pub mod simulation;
pub mod store;
pub mod trends;
pub mod watch;

pub use pneudrive_data as data;
pub use pneudrive_data::rig;
use pneudrive_plant::parallel;
pub use pneudrive_plant::{board, effects, model, numeric, rollout};
