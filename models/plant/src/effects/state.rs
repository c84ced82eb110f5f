//! The state of a stepper between two rows.

use super::chamber::Chamber;
use super::controller::Controller;
use super::hook::Memory;
use crate::numeric::Scalar;

/// What a [`Stepper`](super::Stepper) remembers from row to row, without what its effects do.
#[derive(Debug, Clone, Copy)]
pub struct StepperState<S: Scalar> {
    pub(super) chamber: Chamber<S>,
    pub(super) reading: S,
    pub(super) controller: Controller<S>,
    pub(super) spool: [S; 2],
}

impl<S: Scalar> StepperState<S> {
    /// Pressure in the chamber, absolute, Pa.
    #[must_use]
    pub fn pressure(&self) -> S {
        self.chamber.pressure()
    }

    /// Pressure at the valve, absolute, Pa: another than in the chamber where there is a tube
    /// between them.
    #[must_use]
    pub fn port(&self) -> S {
        self.chamber.port()
    }

    /// Temperature of the gas, K: the ambient one where no effect says otherwise.
    #[must_use]
    pub fn temperature(&self) -> S {
        self.chamber.temperature()
    }

    /// The fill and the vent port's drive behind the effects in the last step; of one spool, the
    /// second is minus the first.
    #[must_use]
    pub fn spool(&self) -> [S; 2] {
        self.spool
    }

    /// Shows every number of it, in an order that stays.
    pub fn values(&mut self, visit: &mut dyn FnMut(&mut S)) {
        let mut any = |_: Memory, value: &mut S| visit(value);
        self.chamber.memory(&mut any);
        self.controller.memory(&mut any);
        visit(&mut self.reading);
        self.spool.iter_mut().for_each(visit);
    }
}
