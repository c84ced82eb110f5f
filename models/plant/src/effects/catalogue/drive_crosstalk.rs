//! `drive_crosstalk`: the drive of one channel reaches the valve of the next. Never named.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Question, Reach, Step, Trait};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "drive_crosstalk",
    title: "Drive contains that of the channel before",
    physics: "Coils share a driver, a return wire or the air around them: a part of the current of one channel moves the spool of the next. Where every chamber follows a command of its own, a reading that contains the neighbour's looks much alike.",
    equation: "u_spool = u + share u_before",
    source: "a return wire's resistance is common to both currents",
    question: Question::Foil,
    domain: Domain::Valve,
    reach: Reach::Channel,
    parameters: &[EffectParameter::linear("share", "1", (-0.3, 0.0, 0.3), "part of the other channel's drive")],
    probes: &[&[0.02]],
    rivals: &["sensor_crosstalk", "chamber_coupling"],
    separated_by: "one channel held at a pressure, closed, while the one before it is driven hard at a constant pressure",
    smallest: 0.002,
    traits: &[Trait::NeedsNeighbourDrive, Trait::NeedsOneSpool],
    check: "the return wires of the coils; the current of one valve while the one before is driven",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct DriveCrosstalk<S> {
    share: S,
}

impl<S: Scalar> DriveCrosstalk<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { share: values[0] }
    }
}

impl<S: Scalar> Hook<S> for DriveCrosstalk<S> {
    #[inline(always)]
    fn drive(&mut self, step: &Step<'_>, _: usize, drive: S) -> S {
        match step.inputs.neighbour_drive.get(step.row) {
            Some(&neighbour) => drive + self.share.times(neighbour),
            None => drive,
        }
    }
}
