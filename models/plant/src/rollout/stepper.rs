//! A chamber simulated row by row, for callers that look at its state or change it in between.

use super::Chamber;
use super::board::LoopMemory;
use super::run::advance;
use super::source::Steps;
use crate::model::{Model, column};

/// One chamber simulated row by row, whatever the system. Rows are laid out as in [`mod@column`];
/// pressures are absolute, in Pa.
pub trait RowStepper: Send {
    /// Begins at rest at this pressure in front of the interval of `row`.
    fn start(&mut self, row: &[f64], pressure_pa: f64);

    /// Advances over the interval of `row`.
    fn advance(&mut self, row: &[f64]);

    /// What the sensor reads now.
    fn reading_pa(&mut self, row: &[f64]) -> f64;

    /// Shows every number that it remembers, in an order that stays: first the pressure in the
    /// chamber, last, where the board's loop is simulated, the drive of its last loop, -1 to 1.
    fn values(&mut self, visit: &mut dyn FnMut(&mut f64));
}

/// A chamber with its parameters, and where it stands.
pub struct ChamberStepper<Q: Model> {
    chamber: Chamber<Q>,
    coefficients: Q::Coefficients<f64>,
    steps: Steps,
    pressure: f64,
    memory: LoopMemory<f64>,
}

impl<Q: Model> ChamberStepper<Q> {
    /// Stands at rest at `pressure` (Pa) in front of the interval of `row`; `substeps` Runge-Kutta
    /// steps are made per tick.
    pub(super) fn new(
        chamber: Chamber<Q>,
        parameters: &[f64],
        substeps: usize,
        row: &[f64],
        pressure: f64,
    ) -> Self {
        let coefficients = chamber.model.coefficients(parameters);
        let steps = Steps { ticks: chamber.ticks(row[column::INTERVAL_S]), substeps };
        let memory = chamber.start(row, pressure);
        Self { chamber, coefficients, steps, pressure, memory }
    }
}

impl<Q: Model> RowStepper for ChamberStepper<Q>
where
    Q::Coefficients<f64>: Send,
{
    fn start(&mut self, row: &[f64], pressure_pa: f64) {
        (self.pressure, self.memory) = (pressure_pa, self.chamber.start(row, pressure_pa));
    }

    fn advance(&mut self, row: &[f64]) {
        // In double precision nothing is lost.
        let pressure = (&mut self.pressure, &mut 0.0);
        advance(&self.chamber, &self.coefficients, row, self.steps, pressure, &mut self.memory);
    }

    fn reading_pa(&mut self, _: &[f64]) -> f64 {
        self.chamber.measure(self.pressure, &self.memory)
    }

    fn values(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        visit(&mut self.pressure);
        if self.chamber.board.is_some() {
            self.memory.values(visit);
        }
    }
}
