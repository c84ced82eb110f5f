use super::super::arguments::RigArgument;
use super::super::convert;
use super::super::expected::{Described, Expected};
use super::super::extended::ExtendedModel;
use super::super::recording::Recording;
use super::super::work::{self, Watch};
use super::class::Diagnosis;
use super::kept::Kept;
use crate::errors;
use pneudrive_model::data;
use pneudrive_model::diagnosis::machine::{MachineDiagnosis, MachineRequest, diagnose_machine};
use pneudrive_model::diagnosis::{self as library, ExtendedFile, Request};
use pneudrive_model::effects::catalogue::nameable;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// One recording, or several of one rig.
#[derive(FromPyObject)]
pub enum Recordings {
    One(Py<Recording>),
    Several(Vec<Py<Recording>>),
}

impl Described for Recordings {
    const EXPECTED: &'static str = "a Recording or a sequence of Recordings";
}

impl Described for Reference {
    const EXPECTED: &'static str = "an ExtendedModel or the path of extended.toml";
}

impl Recordings {
    /// Each of them, and what was noticed about their quality.
    fn all(self) -> PyResult<(Vec<data::Recording>, Vec<String>)> {
        let all = match self {
            Self::One(one) => vec![one],
            Self::Several(all) => all,
        };
        if all.is_empty() {
            return Err(errors::unusable("recordings is empty: nothing to diagnose"));
        }
        let mut recordings = Vec::new();
        let mut remarks = Vec::new();
        for loaded in all.iter().map(|recording| &recording.get().loaded) {
            let next = loaded.recording.clone();
            let of = |sentence| {
                if all.len() == 1 { sentence } else { format!("{}: {sentence}", next.source.file) }
            };
            remarks.extend(loaded.quality.sentences().into_iter().map(of));
            recordings.push(next);
        }
        data::each_once(&recordings).map_err(errors::unusable)?;
        Ok((recordings, remarks))
    }
}

/// All as one.
fn joined(recordings: Vec<data::Recording>) -> PyResult<data::Recording> {
    let mut joined: Option<data::Recording> = None;
    for next in recordings {
        joined = Some(match joined {
            None => next,
            Some(first) => first.followed_by(next).map_err(errors::unusable)?,
        });
    }
    joined.ok_or_else(|| errors::unusable("recordings is empty: nothing to diagnose"))
}

/// Whether several recordings have the same load; `None`: find out.
fn loads_differ(loads: &str) -> PyResult<Option<bool>> {
    match loads {
        "auto" => Ok(None),
        "same" => Ok(Some(false)),
        "differ" => Ok(Some(true)),
        other => {
            Err(errors::unusable(format!("loads is {other:?}; it must be \"auto\", \"same\" or \"differ\"")))
        }
    }
}

/// Refuses arguments that ask for two things at once.
fn check(recordings: usize, differ: Option<bool>, reference: bool, machine: bool) -> PyResult<()> {
    let refused = match (reference, machine) {
        (true, true) => {
            "reference and machine are both given: the one asks what has moved on the same rig, the other what another load of the same machine is; pass one"
        }
        (true, false) if differ.is_some() => {
            "loads is given beside reference, which asks what has moved on the rig as it is; pass one"
        }
        (false, true) if differ.is_some() => {
            "loads is given beside machine, whose load is always asked for; pass one"
        }
        (false, false) if differ == Some(true) && recordings < 2 => {
            "loads=\"differ\" needs several recordings of one machine, or machine=, a calibrated model of it"
        }
        _ => return Ok(()),
    };
    Err(errors::unusable(refused))
}

/// What was found: of a machine, or of recordings as one, with where that comes from.
enum Found {
    Machine(Box<MachineDiagnosis>),
    One(Box<library::Diagnosis>, data::Source),
}

/// A calibrated model, or the path of one.
#[derive(FromPyObject)]
pub enum Reference {
    Model(Py<ExtendedModel>),
    Path(PathBuf),
}

impl Reference {
    /// What messages call it, and its content.
    fn resolve(self) -> PyResult<(String, Arc<ExtendedFile>)> {
        match self {
            Self::Model(model) => Ok((model.get().name.clone(), Arc::clone(&model.get().file))),
            Self::Path(path) => {
                let file = ExtendedFile::load(&path).map_err(errors::unusable)?;
                Ok((path.display().to_string(), Arc::new(file)))
            }
        }
    }
}

/// Says what the simulation gets wrong in a recording, why, and how much better it is once the
/// cause is modelled.
///
/// Parameters
/// ----------
/// recording : Recording or sequence of Recording
///     Thirty seconds or more. Several recordings of one rig, with the same channels and columns,
///     are diagnosed together.
/// rig : Rig or path, optional
///     Without it the channels are taken for regulators and compared with the linear model.
/// reference : ExtendedModel or path, optional
///     ``extended.toml`` of an earlier diagnosis of the same rig, or a file that
///     ``Parameters.save`` wrote. The question is then which calibrated parameter has moved;
///     without it, which physical effect the model lacks.
/// loads : {"auto", "same", "differ"}, default "auto"
///     Whether the recordings have different loads (volumes, tubes, walls) on the same valves.
///     ``"differ"`` diagnoses them as recordings of one machine; ``"same"`` as one recording;
///     ``"auto"`` finds out, of three or more whose drives are recorded.
/// machine : ExtendedModel or path, optional
///     Calibrated model of the same machine with another load, such as one of
///     ``Diagnosis.extended_models``: valves, supply and sensor are taken from it, and only the
///     load is fitted.
/// only : sequence of str, optional
///     Ids of the effects that it may be, where you know that it can be nothing else; by default
///     all that ``effects`` knows.
/// highest_kpa : float, optional
///     Highest pressure that a suggested next experiment may command, kPa gauge; by default the
///     highest in the recordings. Nothing is suggested about a machine.
/// progress : callable, optional
///     Called with (steps done, 0, what is being done).
///
/// Returns
/// -------
/// Diagnosis
///     Of a machine ``machine`` and ``extended_models`` hold more.
///
/// Raises
/// ------
/// DataError
///     The data cannot carry a diagnosis, recordings do not belong together, the reference or the
///     machine does not fit, or arguments contradict each other.
///
/// Notes
/// -----
/// docs/diagnosis.md says how to read it, docs/diagnosis-trust.md what it has been measured to
/// find. All cores are used; where several processes share a machine, set the environment variable
/// ``RAYON_NUM_THREADS`` for each.
#[pyfunction]
#[pyo3(signature = (recording, rig=None, *, reference=None, loads="auto", machine=None, only=None, highest_kpa=None, progress=None))]
#[allow(clippy::too_many_arguments)] // keywords of the Python function
pub fn diagnose(
    py: Python<'_>,
    recording: Expected<Recordings>,
    rig: Option<Expected<RigArgument>>,
    reference: Option<Expected<Reference>>,
    loads: &str,
    machine: Option<Expected<Reference>>,
    only: Option<Vec<String>>,
    highest_kpa: Option<f64>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<Diagnosis> {
    let (rig, rig_file) = RigArgument::resolve(rig)?;
    if let Some(kpa) = highest_kpa.filter(|kpa| !(*kpa > 0.0 && kpa.is_finite())) {
        return Err(errors::unusable(format!(
            "highest_kpa is {kpa}; it must be a pressure above 0 kPa gauge"
        )));
    }
    let only: Result<Vec<usize>, _> = only.iter().flatten().map(|id| nameable(id)).collect();
    let only = only.map_err(|unknown| errors::unusable(format!("only: {unknown}")))?;
    let differ = loads_differ(loads)?;
    let (recordings, remarks) = recording.0.all()?;
    check(recordings.len(), differ, reference.is_some(), machine.is_some())?;
    let reference = reference.map(|given| given.0.resolve()).transpose()?;
    let machine = machine.map(|given| given.0.resolve()).transpose()?;
    let several = recordings.len() > 1 && reference.is_none() && differ != Some(false);
    let as_machine = machine.is_some() || several;
    let sources: Vec<data::Source> = recordings.iter().map(|one| one.source.clone()).collect();
    let work = move |watch: &Watch| -> PyResult<Found> {
        let tell = |what: &str, _: u64| {
            watch.checkpoint();
            if what.is_empty() { watch.advance() } else { watch.begin(what) }
        };
        if as_machine {
            let machine = machine.as_ref().map(|(name, file)| (name.as_str(), &**file));
            let request = MachineRequest { machine, loads_differ: differ, only: &only };
            let found = diagnose_machine(&recordings, &rig, request, &tell).map_err(errors::unusable)?;
            if let Some(mut found) = found {
                found.report.notes.extend(remarks);
                return Ok(Found::Machine(Box::new(found)));
            }
        }
        let recording = joined(recordings)?;
        let reference = reference.as_ref().map(|(name, file)| (name.as_str(), &**file));
        let request = Request { reference, highest_kpa, only: &only };
        let mut diagnosis = library::diagnose(&recording, &rig, request, &tell).map_err(errors::unusable)?;
        diagnosis.report.notes.extend(remarks);
        Ok(Found::One(Box::new(diagnosis), recording.source))
    };
    let origin = convert::origin(py, "diagnose")?;
    let footer = format!("{} | {} | {}", origin.program, origin.created, origin.command);
    let kept = match work::run(py, progress.as_ref(), work)?? {
        Found::Machine(mut found) => {
            for ((_, file), source) in found.extended.iter_mut().zip(&sources) {
                file.provenance = Some(convert::provenance(py, "diagnose", source, rig_file.clone())?);
            }
            py.detach(|| Kept::of_machine(*found, &footer))?
        }
        Found::One(mut diagnosis, source) => {
            diagnosis.extended.provenance = Some(convert::provenance(py, "diagnose", &source, rig_file)?);
            py.detach(|| Kept::of(*diagnosis, &footer))?
        }
    };
    Ok(Diagnosis { kept })
}
