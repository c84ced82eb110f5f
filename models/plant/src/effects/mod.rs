//! The catalogue of physical effects, and the simulation of a channel with any of them at work.
//!
//! * [`catalogue`]: one file per effect: what it is, its parameters, its rivals, and its [`Hook`];
//! * [`simulate()`]: the base model with hooks, over plain numbers or with exact derivatives.
//!
//! A new effect is a new file in `catalogue/` and one line in its list.

mod adjoint;
pub mod catalogue;
mod chamber;
mod controller;
mod deviations;
mod dither;
mod hook;
mod info;
mod inputs;
mod interval;
mod outlet;
mod parameter;
mod phi;
mod plant;
mod remembered;
mod run;
mod simulate;
mod simulated;
mod state;
mod traits;
mod tube;

pub use adjoint::{InputSlopes, input_slopes};
pub use chamber::HEAT_REFERENCE_PA;
pub use deviations::Deviations;
pub use dither::course_from;
pub use hook::{Facing, Hook, LineParameters, Memory, RegulatorLaw, Step, Stretch, Structure};
pub use info::{Domain, EffectInfo, Question, Reach};
pub use inputs::{ChannelInputs, DriveInput, Series};
pub use outlet::OutletParameters;
pub use parameter::EffectParameter;
pub use plant::{BoardLoop, Plant};
pub use simulate::{Disturbance, Row, Stepper, Undisturbed, install, simulate};
pub use simulated::{NARROW, NarrowSensitive, SENSITIVITIES, Sensitive, Simulated};
pub use state::StepperState;
pub use traits::{DerivedSize, Trait, Wave};
