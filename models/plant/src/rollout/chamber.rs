//! A model with what stands in front of it.

use super::board::LoopMemory;
use crate::board::Board;
use crate::model::{Drive, Model, column};
use crate::numeric::Scalar;

/// One chamber described by a [`Model`], driven as recorded or by a board that follows the command.
/// Its only state is the pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chamber<Q> {
    /// The model.
    pub model: Q,
    /// The board in front of it; without one the drive is the recorded one, and the sensor reads
    /// the pressure as it is.
    pub board: Option<Board>,
}

impl<Q: Model> Chamber<Q> {
    /// Driven as recorded.
    #[must_use]
    pub const fn new(model: Q) -> Self {
        Self { model, board: None }
    }

    /// Driven by a board.
    #[must_use]
    pub const fn behind(model: Q, board: Board) -> Self {
        Self { model, board: Some(board) }
    }

    /// Ticks in a sample interval of this length, s: loops of the board, or one.
    #[must_use]
    pub fn ticks(&self, interval_s: f64) -> usize {
        self.board.as_ref().map_or(1, |board| board.controller.ticks(interval_s))
    }

    /// What is remembered at the start of a segment, where the pressure is `pressure` (absolute,
    /// Pa).
    #[inline(always)]
    pub(super) fn start<S: Scalar>(&self, row: &[S::Real], pressure: S) -> LoopMemory<S> {
        match &self.board {
            Some(board) => board.start(row, pressure),
            None => LoopMemory::none(),
        }
    }

    /// What is recorded at a row, absolute, Pa.
    #[inline(always)]
    pub(super) fn measure<S: Scalar>(&self, pressure: S, memory: &LoopMemory<S>) -> S {
        match &self.board {
            Some(board) => board.report(pressure, memory),
            None => pressure,
        }
    }

    /// Prepares tick number `tick` of the interval that starts at this row.
    #[inline(always)]
    pub(super) fn hold<S: Scalar>(
        &self,
        coefficients: &Q::Coefficients<S>,
        row: &[S::Real],
        tick: usize,
        pressure: S,
        memory: &mut LoopMemory<S>,
    ) -> Q::Held<S> {
        debug_assert!(row.len() >= column::COUNT, "a row has the standard columns");
        let recorded = Drive::recorded(row);
        let drive = match &self.board {
            Some(board) => recorded.with_spool(board.drive(row, tick, pressure, memory)),
            None => recorded,
        };
        self.model.hold(coefficients, row, drive)
    }
}
