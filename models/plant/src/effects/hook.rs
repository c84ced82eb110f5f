//! Where an effect can take hold of a simulated channel.

use super::inputs::ChannelInputs;
use super::outlet::OutletParameters;
use crate::model::{Areas, GeneralFlow, ValveLaw};
use crate::numeric::Scalar;

/// The moment a hook is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Step<'a> {
    /// Row of the recording whose interval is simulated.
    pub row: usize,
    /// Middle of the step, s from the start of the recording.
    pub time_s: f64,
    /// Length of the step, s.
    pub length_s: f64,
    /// Does the force on the spool move without jumps ([`Structure::lags`])?
    pub lags: bool,
    /// The channel's measured inputs.
    pub inputs: &'a ChannelInputs,
}

impl Step<'_> {
    /// The part of the row's interval that is over at the end of the step, 0 to 1.
    #[must_use]
    pub fn end_of_interval(&self) -> f64 {
        let end_s = self.time_s + 0.5 * self.length_s - self.inputs.time_s[self.row];
        (end_s / self.inputs.interval_s[self.row]).min(1.0)
    }
}

/// How a regulator answers: `dp/dt = speed (beta command - alpha p)`.
#[derive(Debug, Clone, Copy)]
pub struct RegulatorLaw<S> {
    /// Speed while the pressure rises, 1 in the base model.
    pub rising: S,
    /// Speed while it falls.
    pub falling: S,
    /// Added to the command, Pa.
    pub offset_pa: S,
    /// Largest rate of the pressure, Pa/s.
    pub slew_pa_s: Option<S>,
}

/// A chamber's relative volume: what multiplies the geometric volume.
#[derive(Debug, Clone, Copy)]
pub struct Stretch<S> {
    /// Volume over geometric volume.
    pub factor: S,
    /// Its rate by itself, 1/s.
    pub rate: S,
    /// Its derivative by the chamber's pressure, 1/Pa.
    pub by_pressure: S,
}

/// Pressures that move a chamber's wall, absolute, Pa.
#[derive(Debug, Clone, Copy)]
pub struct Facing<S> {
    /// In the chamber.
    pub own: S,
    /// In the chamber on the other side of the joint, where it is known and an effect
    /// [asks for it](Structure::faces).
    pub opposite: Option<S>,
}

/// The parts of a channel an effect can replace as a whole.
#[derive(Debug, Clone, Copy)]
pub struct Structure<S> {
    /// A flow function instead of the rig's.
    pub flow_function: Option<GeneralFlow<S>>,
    /// Does an effect change the volume ([`Hook::stretch`])? Without one, chambers are advanced
    /// without divisions by it.
    pub stretches: bool,
    /// Does an effect change it by the pressure in the chamber opposite?
    pub faces: bool,
    /// Time constant of the gas temperature at ambient pressure, s.
    pub heat_time_constant_s: Option<S>,
    /// Restriction behind the vent port.
    pub outlet: Option<OutletParameters<S>>,
    /// Tube between valve and chamber.
    pub line: Option<LineParameters<S>>,
    /// Does an effect let the force on the spool follow the drive, and never jump with it?
    pub lags: bool,
}

/// A tube between valve and chamber.
#[derive(Debug, Clone, Copy)]
pub struct LineParameters<S> {
    /// Flow pressure over the rate at which it changes the chamber's pressure, s: what is lost when
    /// the flow is turbulent.
    pub time_constant_s: S,
    /// Its volume over the chamber's.
    pub volume_ratio: S,
    /// Flow pressure below which its loss is laminar rather than turbulent, Pa.
    pub laminar_pa: S,
}

/// What a filter does with a number that a simulation remembers from row to row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Memory {
    /// It depends on the pressures so far, and is estimated along with them.
    Estimated,
    /// It follows from what is recorded, or is over within a row: taken as it is.
    Known,
}

/// An effect at work in the simulation of one channel. Every method passes its argument through by
/// default.
///
/// `drive` to `sense` are called once a step, in this order; `sample` once a row.
///
/// An effect marks what it has of these `#[inline(always)]`: what is left as a function of its own
/// is compiled for the oldest processors.
#[allow(unused_variables)]
pub trait Hook<S: Scalar> {
    /// Forgets the past: a new stretch of rows begins.
    fn reset(&mut self) {}

    /// Shows everything that the effect remembers from row to row.
    fn memory(&mut self, visit: &mut dyn FnMut(Memory, &mut S)) {}

    /// Replaces parts of the channel; called once, before the simulation.
    fn structure(&self, structure: &mut Structure<S>) {}

    /// The drive that reaches valve number `valve` (0: the spool or the fill valve, 1: the vent
    /// valve), mean over the step.
    #[inline(always)]
    fn drive(&mut self, step: &Step<'_>, valve: usize, drive: S) -> S {
        drive
    }

    /// Changes the law of the valve.
    #[inline(always)]
    fn valve(&mut self, step: &Step<'_>, law: &mut ValveLaw<S>) {}

    /// Changes the law of a regulator.
    #[inline(always)]
    fn regulator(&mut self, step: &Step<'_>, law: &mut RegulatorLaw<S>) {}

    /// Changes the areas of the ports.
    #[inline(always)]
    fn areas(&mut self, step: &Step<'_>, areas: &mut Areas<S>) {}

    /// The supply pressure at this channel's valve, absolute, Pa. `areas` and `pressure` (chamber,
    /// absolute, Pa) are those of this step.
    #[inline(always)]
    fn supply(&mut self, step: &Step<'_>, supply: S, areas: &Areas<S>, pressure: S) -> S {
        supply
    }

    /// Changes the volume, at these pressures. Only of a [`Structure`] that says so.
    #[inline(always)]
    fn stretch(&mut self, step: &Step<'_>, pressures: &Facing<S>, stretch: &mut Stretch<S>) {}

    /// What the sensor delivers, gauge, Pa, at the end of the step.
    #[inline(always)]
    fn sense(&mut self, step: &Step<'_>, gauge: S) -> S {
        gauge
    }

    /// The pressure behind what a neighbour's sensor shows in the long run, both gauge, Pa:
    /// sensors of one rig are of one kind, and what this one's has, theirs has.
    #[inline(always)]
    fn shown(&self, reading: S) -> S {
        reading
    }

    /// What is recorded in row `row`, gauge, Pa.
    fn sample(&mut self, inputs: &ChannelInputs, row: usize, reading: S) -> S {
        reading
    }
}
