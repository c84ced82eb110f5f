//! From a channel and the user's choices to a model and its inputs.

use std::ops::Range;

use crate::data::{self, Channel, InputError, Needs, Recording};
use crate::model::FlowForm;
use crate::rig::Rig;
use crate::rollout::Series;

use super::{Setup, Subject, subject};

/// A model set up for a channel, with the channel's data in it.
pub struct Prepared {
    /// What is simulated.
    pub setup: Setup,
    /// The machine as the channel has it.
    pub rig: Rig,
    /// The model.
    pub subject: Subject,
    /// Inputs and measurements, one per requested range of rows.
    pub series: Vec<Series>,
}

impl std::fmt::Debug for Prepared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Prepared").field("setup", &self.setup).finish_non_exhaustive()
    }
}

impl Prepared {
    /// Whether `other` is simulated with the same constants: chambers are in the series.
    pub(super) fn same_model(&self, other: &Self) -> bool {
        let constants = |of: &Self| (of.setup, of.rig.valve.clone(), of.rig.controller, of.rig.sensor);
        constants(self) == constants(other)
    }
}

/// Sets up `setup` for `channel` with one series for each range of rows, measured pressures
/// included.
///
/// # Errors
/// [`InputError`] when the recording or the rig lacks something.
pub fn prepare(
    setup: Setup,
    recording: &Recording,
    channel: &Channel,
    rig: &Rig,
    form: FlowForm,
    ranges: &[Range<usize>],
) -> Result<Prepared, InputError> {
    let rig = rig.at(channel.id);
    let series = ranges
        .iter()
        .map(|rows| data::series(recording, channel, &rig, setup.needs(true), rows.clone()))
        .collect::<Result<_, _>>()?;
    Ok(Prepared { setup, subject: subject::subject(setup, &rig, form)?, series, rig })
}

/// Sets up `setup` for a simulation of the whole recording. It starts at the measured pressure
/// where there is one, else at `start_kpa` (gauge).
///
/// # Errors
/// [`InputError`] when the recording or the rig lacks something.
pub fn simulation(
    setup: Setup,
    recording: &Recording,
    channel: &Channel,
    rig: &Rig,
    form: FlowForm,
    start_kpa: f64,
) -> Result<Prepared, InputError> {
    let measured = channel.usable_samples() > 0;
    let needs = Needs { start_kpa, ..setup.needs(measured) };
    let rig = rig.at(channel.id);
    let series = data::series(recording, channel, &rig, needs, 0..recording.rows())?;
    Ok(Prepared { setup, subject: subject::subject(setup, &rig, form)?, series: vec![series], rig })
}
