//! A system simulated row by row, for callers that look at its state or change it in between.

use super::run::rk4_step;
use super::{Steps, System};
use crate::model::column;

/// One chamber simulated row by row, whatever the system. Rows are laid out as in [`mod@column`]; pressures are absolute, in Pa.
pub trait RowStepper: Send {
    /// Begins at rest at this pressure in front of the interval of `row`.
    fn start(&mut self, row: &[f64], pressure_pa: f64);

    /// Advances over the interval of `row`.
    fn advance(&mut self, row: &[f64]);

    /// What the sensor reads now.
    fn reading_pa(&mut self, row: &[f64]) -> f64;

    /// Shows every number that it remembers, in an order that stays: first the pressure in the chamber, last, where the board's loop is
    /// simulated, the drive of its last loop, -1 to 1.
    fn values(&mut self, visit: &mut dyn FnMut(&mut f64));
}

/// A [`System`] of one chamber with its parameters, and where it stands.
pub struct SystemStepper<Y: System<1, 1>> {
    system: Y,
    coefficients: Y::Coefficients<f64>,
    steps: Steps,
    state: [f64; 1],
    memory: Y::Memory<f64>,
}

impl<Y: System<1, 1>> SystemStepper<Y> {
    /// Stands at rest at `pressure_pa` in front of the interval of `row`; `substeps` Runge-Kutta steps are made per tick.
    #[must_use]
    pub fn new(system: Y, parameters: &[f64], substeps: usize, row: &[f64], pressure_pa: f64) -> Self {
        let coefficients = system.coefficients(parameters);
        let steps = Steps { ticks: system.ticks(row[column::INTERVAL_S]), substeps };
        let (state, memory) = system.start(&coefficients, row, [pressure_pa]);
        Self { system, coefficients, steps, state, memory }
    }
}

impl<Y: System<1, 1> + Send> RowStepper for SystemStepper<Y>
where
    Y::Coefficients<f64>: Send,
    Y::Memory<f64>: Send,
{
    fn start(&mut self, row: &[f64], pressure_pa: f64) {
        (self.state, self.memory) = self.system.start(&self.coefficients, row, [pressure_pa]);
    }

    fn advance(&mut self, row: &[f64]) {
        #[allow(clippy::cast_precision_loss)] // a handful of steps
        let h = row[column::INTERVAL_S] / (self.steps.ticks * self.steps.substeps) as f64;
        for tick in 0..self.steps.ticks {
            let held = self.system.hold(&self.coefficients, row, tick, &self.state, &mut self.memory);
            for _ in 0..self.steps.substeps {
                self.state = rk4_step(&self.system, &self.coefficients, &held, self.state, h);
            }
        }
    }

    fn reading_pa(&mut self, row: &[f64]) -> f64 {
        self.system.measure(&self.coefficients, row, &self.state, &mut self.memory)[0]
    }

    fn values(&mut self, visit: &mut dyn FnMut(&mut f64)) {
        visit(&mut self.state[0]);
        Y::values(&mut self.memory, visit);
    }
}
