//! What simulates a channel, whatever the kind of calibrated model.

use crate::error::CreateError;
use crate::inputs::Inputs;
use crate::outputs::Outputs;

/// A model of one channel that is advanced step by step. Pressures are gauge, in kPa.
pub trait Engine: Send {
    /// Begins at rest at this pressure; the inputs hold at the beginning.
    fn start(&mut self, kpa: f64, inputs: &Inputs) -> Outputs;

    /// Advances by step number `step` (0 is the first). Times and rates are left to the caller.
    fn step(&mut self, step: u64, inputs: &Inputs) -> Outputs;

    /// Moves the pressure in the chamber, and what the sensor delivers with it.
    fn set_pressure(&mut self, kpa: f64);

    /// How many numbers [`save`](Engine::save) shows.
    fn size(&self) -> usize;

    /// Shows every number that is remembered from step to step, in an order that stays; `NaN` for
    /// what has not begun.
    fn save(&mut self, into: &mut dyn FnMut(f64));

    /// Takes them back, in the same order.
    fn restore(&mut self, from: &mut dyn FnMut() -> f64);
}

/// Whether the loop of a board at `rate_hz` fits into the step a whole number of times.
pub fn check_loop(step_s: f64, rate_hz: f64) -> Result<(), CreateError> {
    let loops = step_s * rate_hz;
    let whole = loops > 0.5 && (loops - loops.round()).abs() < 1e-6 * loops;
    if whole { Ok(()) } else { Err(CreateError::Loop { step_s, rate_hz }) }
}
