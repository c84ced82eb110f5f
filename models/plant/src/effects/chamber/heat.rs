//! The temperature of the gas in a chamber, as a state beside its pressure: the first law with an
//! outflow at the gas's temperature and a wall of constant conductance at ambient temperature.
//!
//! Over a step the temperature's equation is the linear one that holds at the step's start, and is
//! solved exactly: a wall that answers within the step makes the gas isothermal in it. It is
//! written for what the wall takes, which is proportional to how much warmer the gas is than the
//! wall.
//!
//! Energies and flows are the rates of the pressure that they would cause in a rigid chamber of
//! nominal volume, flows as if of gas at ambient temperature, Pa/s.

use super::{Conditions, HEAT_REFERENCE_PA};
use crate::model::GAMMA;
use crate::numeric::Scalar;

/// The gas at the start of a step.
#[derive(Clone, Copy)]
pub struct Gas<S> {
    /// Absolute, Pa.
    pub pressure: S,
    /// K.
    pub temperature: S,
    /// That of the wall, K.
    pub ambient_k: f64,
    /// Time constant of the temperature at [`HEAT_REFERENCE_PA`], s.
    pub time_constant: S,
    /// Does the volume change by more than the joint's angle?
    pub stretches: bool,
}

/// One step of the temperature.
#[derive(Clone, Copy)]
pub struct Heat<S> {
    ambient_k: f64,
    /// Temperature over the ambient one.
    pub warmth: S,
    /// Energy over the change of the pressure, where the chamber gives way.
    room: Option<S>,
    /// What the wall takes at the start.
    now: S,
    /// The same per kelvin, Pa/(s K).
    per_k: S,
    /// What the wall would take in the end less than the energy that comes, per flow: what is
    /// needed to warm or cool what flows in.
    carried: S,
    /// What it would take more, because the chamber grows.
    grown: S,
    /// The part of the way to the end's balance that is left after the step.
    left: S,
    /// The same, mean over the step.
    mean_left: S,
}

impl<S: Scalar> Heat<S> {
    /// Of `h` seconds.
    #[inline(always)]
    pub fn new(h: f64, gas: &Gas<S>, c: &Conditions<S>) -> Self {
        let &Gas { pressure, temperature, ambient_k, time_constant, stretches } = gas;
        let warmth = temperature.times(1.0 / ambient_k);
        let per_k = time_constant.recip().times(HEAT_REFERENCE_PA / ambient_k);
        let now = temperature.plus(-ambient_k) * per_k;
        // (T - T0)' = .. - k (T - T0)
        let mut k = temperature * per_k / pressure;
        let (mut carried, mut grown) = (warmth.times(1.0 / GAMMA), pressure * c.expansion);
        let mut room = None;
        if stretches {
            let stretch = &c.stretch;
            let gives_way = pressure * stretch.by_pressure;
            let whole = stretch.factor + gives_way.times(GAMMA);
            // At constant energy the temperature follows the pressure and the volume.
            let follows = (stretch.factor + gives_way) / whole;
            k = k * follows / stretch.factor;
            carried = carried / follows;
            grown = (grown * stretch.factor + pressure * stretch.rate) / follows;
            room = Some(whole);
        }
        let left = (-k.times(h)).exp();
        let mean_left = (-left).plus(1.0) / k.times(h);
        Self { ambient_k, warmth, room, now, per_k, carried, grown, left, mean_left }
    }

    /// What the wall would take in the end of an energy, the growth's included, and a flow into the
    /// chamber that stay.
    #[inline(always)]
    pub fn settled(&self, energy: S, flow: S) -> S {
        energy + self.grown - flow * self.carried
    }

    /// What the wall takes, mean over the step.
    #[inline(always)]
    pub fn taken(&self, settled: S) -> S {
        settled + (self.now - settled) * self.mean_left
    }

    /// The part of a flow's energy that the wall does not take within the step, with the energy per
    /// flow.
    #[inline(always)]
    pub fn kept(&self, energy: S) -> S {
        self.carried + (energy - self.carried) * self.mean_left
    }

    /// The temperature over the ambient one, mean over the step.
    #[inline(always)]
    pub fn mean_warmth(&self, settled: S) -> S {
        (self.taken(settled) / self.per_k).times(1.0 / self.ambient_k).plus(1.0)
    }

    /// The temperature at the end of the step, K.
    #[inline(always)]
    pub fn end(&self, settled: S) -> S {
        ((settled + (self.now - settled) * self.left) / self.per_k).plus(self.ambient_k)
    }

    /// The rate of the pressure by an energy, Pa/s.
    #[inline(always)]
    pub fn rate(&self, energy: S) -> S {
        self.room.map_or(energy, |room| energy / room)
    }
}
