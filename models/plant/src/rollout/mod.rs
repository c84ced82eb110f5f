//! Simulation from the inputs alone: systems, their inputs, and fixed-step Runge-Kutta rollouts.

mod adjoint;
mod batch;
mod board;
mod chamber;
mod check;
mod columns;
mod derivatives;
mod fetch;
mod gather;
mod interval;
mod job;
mod kinds;
mod lanes;
mod model_kind;
mod run;
mod series;
mod simulate;
mod source;
mod stepper;
mod system;

pub use adjoint::{BatchGradient, DIFFERENTIATED, batch_gradient};
pub use batch::{
    BatchOutput, BatchResults, check as check_batch, simulate_batch, simulate_batch_into,
    simulate_batch_single_into,
};
pub use chamber::Chamber;
pub use check::{StepCheck, choose_substeps, step_check};
pub use columns::{BatchColumn, BatchInputs, BatchValues};
pub use gather::GatheredRows;
pub use interval::{ActiveLanes, Interval, Intervals, RowState};
pub use job::{BATCH_LANES, BatchError, BatchUnit, Job, SINGLE_LANES};
pub use kinds::{
    DIRECTIONS, DualLanes, DualRollout, DualSink, LaneRollout, SENSITIVITY_LANES, WIDE_DIRECTIONS,
};
pub use lanes::Lot;
pub use model_kind::ModelKind;
pub use run::rollout;
pub use series::{Series, SeriesError};
pub use simulate::{Start, simulate};
pub use source::{RowSource, Rows, Steps};
pub use stepper::RowStepper;
pub use system::System;
