//! A board in front of a valve: its sensor, its pressure controller, and the law that the
//! controller follows.
//!
//! The description is that of the rig file. What simulates it: [`rollout`](crate::rollout) rounds
//! every sample as the board does, [`effects`](crate::effects) has the noise in its place, which
//! shakes whatever friction there is.

mod controller;
mod law;
mod sensor;

pub use controller::{Arithmetic, Controller, ticks};
pub use law::Law;
pub use sensor::Sensor;

/// A board, which drives a chamber's valve by the command alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Board {
    /// The controller.
    pub controller: Controller,
    /// Resolution of its arithmetic.
    pub arithmetic: Arithmetic,
    /// The sensor it controls by.
    pub sensor: Sensor,
    /// Ambient pressure, Pa, the zero of gauge pressures.
    pub ambient_pa: f64,
}
