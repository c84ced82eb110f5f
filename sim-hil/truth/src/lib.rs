//! The truth plant: the rig behind the boards, in finer detail than any model that is fitted to it.
//!
//! [`Plant`] integrates supply, valves, tubes, chambers, joints and sensors on its own fixed grid
//! (20 kHz by default) and knows nothing of boards, buses or clocks: time comes in as an argument,
//! drives go in, ADC samples come out. With no [`Effect`] switched on it is the paper's nonlinear
//! model (fixed gas temperature, prompt spool, locked joint, ideal sensor but for noise and
//! quantisation); everything a real rig adds is switched on by name.
//!
//! `docs/plant.md` holds the equations, their sources and the table of effects.
//!
//! ```
//! use pneudrive_truth::{ChannelId, Effect, Plant, PlantParameters};
//!
//! let effects = vec!["supply_sag=40".parse::<Effect>()?, "valve_hysteresis=0.06@b0c2".parse()?];
//! let mut plant = Plant::new(PlantParameters::default(), &effects, 7)?;
//! let channel = ChannelId { board: 0, channel: 2 };
//! plant.set_drive(channel, 1.0)?;
//! plant.advance_to(500_000_000); // 0.5 s
//! let counts = plant.sample(0)?;
//! assert!(counts[2] > 1000 && counts[0] < 430, "{counts:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod ageing;
mod background;
mod chamber;
mod drive;
mod effects;
mod error;
mod flow;
mod id;
mod integrator;
mod joint;
pub mod noise;
mod parameters;
mod physics;
mod rig;
mod sensor;
mod supply;
mod truth;
mod validate;
mod valve;

pub use background::Background;
pub use effects::{
    Effect, EffectDefinition, EffectGroup, EffectParameter, Scope, catalogue, definition, effects_table,
};
pub use error::{EffectError, PlantError, with_unit};
pub use flow::{ANR_DENSITY_KG_PER_M3, ANR_TEMPERATURE_K, FlowFunction};
pub use id::{CHANNELS_PER_BOARD, ChannelId};
pub use parameters::{
    AmbientParameters, ChamberParameters, GasModel, JointParameters, Nuisances, PlantParameters,
    SensorParameters, SupplyParameters, ValveParameters,
};
pub use rig::Plant;
pub use sensor::{
    ADC_REFERENCE_V, counts10_to_kpa, counts12_to_kpa, kpa_to_counts10, kpa_to_volts, volts_to_kpa,
};
pub use truth::ChannelTruth;
