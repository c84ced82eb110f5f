//! `drive_saturation`: driver limits the drive.

use crate::effects::{Domain, EffectInfo, EffectParameter, Hook, Step, Question, Reach};
use crate::numeric::Scalar;

/// What the catalogue says about it.
pub const INFO: EffectInfo = EffectInfo {
    id: "drive_saturation",
    title: "Driver limits the drive",
    physics: "The driver limits the current, so that the spool stops short of full travel: beyond the limit more drive changes nothing.",
    equation: "u_spool = clamp(u, -limit, limit)",
    source: "A4990 datasheet, current limitation",
    question: Question::Structure,
    domain: Domain::Both,
    reach: Reach::Channel,
    parameters: &[
        // Usual: data sheets state the current at full scale to a few percent.
        EffectParameter::linear("limit", "1", (0.1, 1.0, 1.0), "largest drive that has an effect").usual_to(0.04),
    ],
    probes: &[&[0.9], &[0.75], &[0.6], &[0.4]],
    rivals: &["valve_asymmetry", "vent_restriction", "flow_function"],
    separated_by: "drives on both sides of the limit, held long enough to see two different slopes or none",
    smallest: 0.02,
    traits: &[],
    check: "the driver's current limit against the valve's rated current",
};

/// The effect at work.
#[derive(Debug, Clone)]
pub struct DriveSaturation<S> {
    limit: S,
}

impl<S: Scalar> DriveSaturation<S> {
    /// With the values of [`INFO`]'s parameters.
    pub fn new(values: &[S]) -> Self {
        Self { limit: values[0] }
    }
}

impl<S: Scalar> Hook<S> for DriveSaturation<S> {
    #[inline(always)]
    fn drive(&mut self, _: &Step<'_>, _: usize, drive: S) -> S {
        drive.min(self.limit).max(-self.limit)
    }
}
