//! `coil_heating`: a coil that warms up passes less current. Never named.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Memory, Question, Reach, Step};
use crate::numeric::Scalar;

/// Valves that a channel has at most.
const VALVES: usize = 2;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "coil_heating",
    title: "Coil warms up",
    physics: "The current heats the coil, its resistance grows, and the same voltage moves the spool less, until it has cooled. A valve that wears, a wall that creeps and a supply that sags change the flow as slowly.",
    equation: "u_spool = u / (1 + rise h),  time_constant dh/dt = u^2 - h,  h = 0 at the start",
    source: "copper's resistance grows by 0.39 % per K; heat and one heat capacity",
    question: Question::Foil,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[
        EffectParameter::linear("rise", "1", (0.0, 0.0, 1.0), "growth of the resistance at full drive in the end"),
        EffectParameter::logarithmic("time_constant", "s", (2.0, 30.0, 600.0), "time constant of the warming"),
    ],
    probes: &[&[0.1, 8.0], &[0.1, 30.0], &[0.1, 120.0]],
    rivals: &["valve_wear", "wall_creep", "supply_sag"],
    separated_by: "the same movement after minutes of hard work and after minutes of rest",
    smallest: 0.005,
    traits: &[],
    check: "the temperature of the coil; a driver that regulates the current",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct CoilHeating<S> {
    rise: S,
    time_constant: S,
    /// Heat of each coil over that at full drive in the end.
    heat: [S; VALVES],
}

impl<S: Scalar> CoilHeating<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { rise: values[0], time_constant: values[1], heat: [S::zero(); VALVES] }
    }
}

impl<S: Scalar> Hook<S> for CoilHeating<S> {
    // A gap in the recording cools no coil: nothing is forgotten at a new start.

    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {
        self.heat.iter_mut().for_each(|heat| visit(Memory::Known, heat));
    }

    #[inline(always)]
    fn drive(&mut self, step: &Step<'_>, valve: usize, drive: S) -> S {
        let heat = &mut self.heat[valve];
        let rest = (-self.time_constant.recip().times(step.length_s)).exp();
        let wanted = drive.square();
        let before = *heat;
        *heat = wanted + (before - wanted) * rest;
        drive / (self.rise * (before + *heat).times(0.5)).plus(1.0)
    }
}
