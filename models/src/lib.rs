//! Pressure models of pneumatic chambers: measured data, simulation, fitting, comparison, diagnosis.
//!
//! The modules in the order a recording passes through them:
//!
//! * [`data`]: recordings: reading, checking, masking, importing foreign columns;
//! * [`rig`]: the TOML description of the machine that made a recording;
//! * [`model`]: the pressure models, written once over the numbers of [`numeric`];
//! * [`rollout`]: simulating them, alone, behind the board's controller, or thousands at once;
//! * [`fit`]: finding their parameters, and how well the data determine them;
//! * [`experiment`]: the three models on one recording: fitted, judged, compared;
//! * [`effects`]: the catalogue of physical effects, and channels simulated with them;
//! * [`diagnosis`]: what a simulation gets wrong, why, and what modelling it gains;
//! * [`store`]: parameter files;
//! * [`report`]: self-contained HTML pages with plots.
//!
//! Nothing here reads a clock or prints; the binary `pneudrive-model` (`main.rs` and `cli/`) does.

pub mod data;
pub mod diagnosis;
pub mod effects;
pub mod experiment;
pub mod fit;
pub mod model;
pub mod numeric;
pub mod report;
pub mod rig;
pub mod rollout;
pub mod store;
