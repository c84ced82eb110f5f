//! Pressure models of pneumatic chambers: measured data, simulation, fitting, comparison, diagnosis.
//!
//! The modules in the order a recording passes through them:
//!
//! * [`data`]: recordings: reading, checking, masking, importing foreign columns;
//! * [`rig`]: the TOML description of the machine that made a recording;
//! * [`report`]: self-contained HTML pages with plots.
//!
//! Nothing here reads a clock or prints; the binary `pneudrive-model` (`main.rs` and `cli/`) does.

pub mod data;
pub mod report;
pub mod rig;
