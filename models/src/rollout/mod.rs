//! Simulation from the inputs alone: systems, their inputs, and fixed-step Runge-Kutta rollouts.

mod batch;
mod board;
mod chamber;
mod check;
mod columns;
mod gather;
mod run;
mod series;
mod stepper;
mod system;

pub use batch::{
    BATCH_LANES, BatchError, BatchOutput, BatchResults, BatchUnit, Job, simulate_batch, simulate_batch_into,
};
pub use board::{Arithmetic, Board, Controller, Sensor};
pub use chamber::Chamber;
pub use check::{StepCheck, choose_substeps, step_check};
pub use columns::{BatchColumn, BatchInputs};
pub use gather::GatheredRows;
pub use run::{RowSource, Rows, Start, Steps, rollout, simulate};
pub use series::{Series, SeriesError};
pub use stepper::{RowStepper, SystemStepper};
pub use system::System;
