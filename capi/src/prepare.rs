//! From a calibrated model to the engine of one of its channels.

use pneudrive_model::data::ChannelId;
use pneudrive_model::simulation::CalibratedModel;

use crate::engine::Engine;
use crate::error::CreateError;
use crate::extended::ExtendedEngine;
use crate::fitted::FittedEngine;
use crate::inputs::{Control, Inputs};

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
    let rig = model.rig().at(id);
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
