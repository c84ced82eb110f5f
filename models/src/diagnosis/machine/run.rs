//! A diagnosis of several recordings of one machine, or of one recording of a machine that is
//! known.

use super::candidates::possible;
use super::fit::{fit_base, known_base};
use super::loads::differ;
use super::recordings::{MachineChannel, channels};
use super::report;
use super::search::{Findings, find};
use super::ties::TiedModel;
use crate::data::Recording;
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::json::Report;
use crate::diagnosis::report::ExtendedFile;
use crate::diagnosis::screening::Asked;
use crate::diagnosis::selection::Progress;
use crate::effects::Question;
use crate::effects::catalogue::CATALOGUE;
use crate::rig::Rig;

/// Recordings from which it is found out whether their loads differ; of two, one may just be the
/// next experiment.
const LEAST_TO_FIND_OUT: usize = 3;

/// What is asked beside the recordings and the rig.
#[derive(Debug, Clone, Copy, Default)]
pub struct MachineRequest<'a> {
    /// A calibrated model of the same machine, with its name for messages: its valves, supply and
    /// sensor are taken as they are, and only the loads are fitted.
    pub machine: Option<(&'a str, &'a ExtendedFile)>,
    /// Do the loads differ? `None`: find out.
    pub loads_differ: Option<bool>,
    /// Numbers of the effects in question, as
    /// [`index_of`](crate::effects::catalogue::index_of) tells them; empty: the whole catalogue.
    pub only: &'a [usize],
}

/// Everything a report of a machine is made of.
#[derive(Debug)]
pub struct MachineDiagnosis {
    /// The result for programs.
    pub report: Report,
    /// The extended model of each recording, with its file's name.
    pub extended: Vec<(String, ExtendedFile)>,
    pub(super) channels: Vec<MachineChannel>,
    pub(super) findings: Findings,
}

/// Diagnoses recordings of one machine. Nothing, where nobody said so and the loads do not differ:
/// then the recordings are one. That is found out of three recordings and more whose drives are
/// recorded.
///
/// # Errors
/// [`DiagnosisError`] when a recording cannot carry a diagnosis, or the machine does not fit.
pub fn diagnose_machine(
    recordings: &[Recording],
    rig: &Rig,
    request: MachineRequest<'_>,
    progress: &Progress<'_>,
) -> Result<Option<MachineDiagnosis>, DiagnosisError> {
    let asked = request.machine.is_some() || request.loads_differ.is_some();
    if !asked && recordings.len() < LEAST_TO_FIND_OUT {
        return Ok(None);
    }
    let (channels, notes) = match channels(recordings, rig) {
        // Together they may be what each alone is not.
        Err(_) if !asked => return Ok(None),
        found => found?,
    };
    let in_loop = |channel: &MachineChannel| channel.recorded.iter().any(|data| data.inputs.in_loop());
    if !asked && channels.iter().any(in_loop) {
        return Ok(None);
    }
    if channels.iter().any(|channel| channel.recorded[0].plant.model.is_regulator()) {
        return match (request.machine, request.loads_differ) {
            (None, None | Some(false)) => Ok(None),
            _ => Err(DiagnosisError::NoLoad { file: recordings[0].source.file.clone() }),
        };
    }
    let known = match request.machine {
        Some((name, file)) => {
            let first: Vec<_> = channels.iter().map(|channel| channel.recorded[0].clone()).collect();
            Some(file.models(name, &first)?)
        }
        None => None,
    };
    let known = known.as_deref();
    let asked_about = Asked { question: Question::Structure, only: request.only };
    let looked_for = possible(&channels, asked_about);
    if let Some(&effect) = request.only.iter().find(|effect| !looked_for.contains(effect)) {
        return Err(DiagnosisError::NotInQuestion {
            file: recordings[0].source.file.clone(),
            effect: CATALOGUE[effect].id,
            why: "it is not looked for in recordings of one machine",
        });
    }
    let tick = || progress("", 1);
    progress("fitting the machine", 0);
    let base: Option<Vec<TiedModel>> = channels
        .iter()
        .enumerate()
        .map(|(k, channel)| match known {
            Some(models) => known_base(channel, &models[k], &tick),
            None => fit_base(channel, &tick),
        })
        .collect();
    let base = base.ok_or_else(|| DiagnosisError::NoFit {
        file: recordings[0].source.file.clone(),
        model: channels[0].recorded[0].plant.model.name(),
        channel: channels[0].id.to_string(),
        hint: "the simulation runs away; check the supply pressure, the units and the sign of the drive"
            .to_owned(),
    })?;
    if known.is_none() && request.loads_differ.is_none() && !differ(&channels, &base) {
        return Ok(None);
    }
    let findings = find(&channels, base, known, asked_about, progress);
    let names: Vec<String> = recordings.iter().map(|r| r.source.file.clone()).collect();
    let found = report::Found { channels: &channels, findings: &findings, recordings, names: &names };
    let mut report = found.report(notes, request.only);
    let extended = found.extended(rig);
    report.checks.band_holds = found.band_holds(&extended);
    Ok(Some(MachineDiagnosis { report, extended, channels, findings }))
}
