//! What simulates a channel: one of two kinds of calibrated model behind one interface.

use pneudrive_model::data::ChannelId;
use pneudrive_model::simulation::CalibratedModel;

use crate::error::CreateError;
use crate::extended::ExtendedEngine;
use crate::fitted::FittedEngine;
use crate::inputs::{Control, Inputs};
use crate::outputs::Outputs;

/// A model of one channel that is advanced step by step. Pressures are gauge, in kPa.
pub trait Engine: Send {
    /// Begins at rest at this pressure; the inputs hold at the beginning.
    fn start(&mut self, kpa: f64, inputs: &Inputs) -> Outputs;

    /// Advances by step number `step` (0 is the first). Times and rates are left to the caller.
    fn step(&mut self, step: u64, inputs: &Inputs) -> Outputs;

    /// Moves the pressure in the chamber, and what the sensor delivers with it.
    fn set_pressure(&mut self, kpa: f64);

    /// How many numbers [`values`](Engine::values) shows.
    fn size(&self) -> usize;

    /// Shows every number that is remembered from step to step, in an order that stays; `NaN` for what has not begun.
    fn save(&mut self, into: &mut dyn FnMut(f64));

    /// Takes them back, in the same order.
    fn restore(&mut self, from: &mut dyn FnMut() -> f64);
}

/// A channel's engine and the inputs that it has by itself.
pub struct Prepared {
    /// The engine.
    pub engine: Box<dyn Engine>,
    /// Nominal inputs.
    pub nominal: Inputs,
}

/// Sets up one channel of a calibrated model for steps of `step_s`.
pub fn prepare(
    model: &CalibratedModel,
    id: ChannelId,
    step_s: f64,
    control: Control,
) -> Result<Prepared, CreateError> {
    if !(1e-5..=1.0).contains(&step_s) {
        return Err(CreateError::Step { step_s });
    }
    let rig = model.rig();
    let nominal = Inputs {
        fill: 0.0,
        vent: 0.0,
        set_point_kpa: 0.0,
        supply_kpa: rig.supply.as_ref().map_or(0.0, |supply| supply.pressure_kpa),
        volume_m3: rig.chamber.as_ref().map_or(1e-4, |chamber| chamber.rest_volume_m3()),
        volume_rate_m3_s: 0.0,
        opposite_kpa: [f64::NAN; 2],
        sampled_before_kpa: [f64::NAN; 2],
        others_draw: 0.0,
        repeats: 0,
    };
    let engine: Box<dyn Engine> = match model {
        CalibratedModel::Fitted { name, file } => {
            Box::new(FittedEngine::new((name, file), id, step_s, control, &nominal)?)
        }
        CalibratedModel::Extended { name, file } => {
            Box::new(ExtendedEngine::new((name, file), id, step_s, control, &nominal)?)
        }
    };
    Ok(Prepared { engine, nominal })
}

/// Whether the loop of a board at `rate_hz` fits into the step a whole number of times.
pub fn check_loop(step_s: f64, rate_hz: f64) -> Result<(), CreateError> {
    let loops = step_s * rate_hz;
    let whole = loops > 0.5 && (loops - loops.round()).abs() < 1e-6 * loops;
    if whole { Ok(()) } else { Err(CreateError::Loop { step_s, rate_hz }) }
}
