//! The kinds of number with derivatives that systems are compiled for.

use super::source::{RowSource, Rows, Steps};
use crate::numeric::{Dual, Lanes};

/// Derivatives computed at a time: enough for most fits.
pub const DIRECTIONS: usize = 8;

/// Derivatives computed at a time where there are more.
pub const WIDE_DIRECTIONS: usize = 12;

/// Rollouts in lockstep when derivatives are computed too: a dual number is long already.
pub const SENSITIVITY_LANES: usize = 4;

/// Rollouts in lockstep with their derivatives.
pub type DualLanes = Dual<Lanes<SENSITIVITY_LANES>, DIRECTIONS>;

/// One rollout with derivatives.
#[derive(Debug, Clone, Copy)]
pub struct DualRollout<'a, const W: usize> {
    /// Parameters with their derivatives.
    pub parameters: &'a [Dual<f64, W>],
    /// Inputs.
    pub rows: Rows<'a>,
    /// Absolute pressure at the first row, Pa.
    pub pressure: Dual<f64, W>,
    /// How intervals are divided.
    pub steps: Steps,
}

/// Takes the number of a row and the absolute pressure there, Pa.
pub type DualSink<'a, const W: usize> = &'a mut dyn FnMut(usize, &Dual<f64, W>);

/// Rollouts in lockstep with derivatives.
pub struct LaneRollout<'a> {
    /// Parameters with their derivatives.
    pub parameters: &'a [DualLanes],
    /// Inputs.
    pub rows: &'a mut dyn RowSource<Lanes<SENSITIVITY_LANES>>,
    /// Number of rows.
    pub count: usize,
    /// Absolute pressures at the first row, Pa.
    pub pressure: DualLanes,
    /// How intervals are divided.
    pub steps: Steps,
}
