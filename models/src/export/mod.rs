//! Calibrated models as other simulators take them: what the exporter writes and the exported
//! library reads.

pub mod fmi;
