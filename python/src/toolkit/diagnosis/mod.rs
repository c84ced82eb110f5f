//! Diagnosis: `run` asks, `class` is what Python gets, `kept` what it holds, `tables` how it is
//! displayed.

mod class;
mod kept;
mod run;

pub use class::Diagnosis;
pub use run::diagnose;
