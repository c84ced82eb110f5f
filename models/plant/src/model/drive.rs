//! What drives a chamber.

use super::column;
use crate::numeric::Scalar;

/// The drive as the model feels it, which need not be the one in the recording.
#[derive(Debug, Clone, Copy)]
pub struct Drive<S> {
    /// Fill drive, see [`column::FILL`].
    pub fill: S,
    /// Vent drive, see [`column::VENT`].
    pub vent: S,
    /// Commanded pressure, absolute, Pa.
    pub command: S,
}

impl<S: Scalar> Drive<S> {
    /// The drive in a row of inputs.
    #[inline(always)]
    pub fn recorded(row: &[S::Real]) -> Self {
        Self {
            fill: S::from_real(row[column::FILL]),
            vent: S::from_real(row[column::VENT]),
            command: S::from_real(row[column::COMMAND_PA]),
        }
    }

    /// The same command with a spool driven by `u`, -1 (vent) to 1 (fill).
    #[inline(always)]
    pub fn with_spool(self, u: S) -> Self {
        Self { fill: u, vent: -u, command: self.command }
    }
}
