//! The check that later ones are compared with.

use crate::args::CheckArgs;
use crate::failure::Failure;
use crate::setup::Setup;
use pneudrive_host::check::{Report, Verdict};
use pneudrive_record::file_is_writable;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// As it is stored.
#[derive(Serialize, Deserialize)]
struct Stored {
    /// Version of the keys.
    schema: u32,
    #[serde(flatten)]
    report: Report,
}

/// Where it is: as the command line says, or beside the rig file; nowhere without either.
pub fn place(check: &CheckArgs, setup: &Setup) -> Option<PathBuf> {
    let beside = || Some(Path::new(setup.rig.as_ref()?.file()).with_extension("check.json"));
    check.baseline.clone().or_else(beside)
}

/// The baseline, if there is one and it is to be compared with.
pub fn read(place: Option<&Path>, check: &CheckArgs) -> Result<Option<Report>, Failure> {
    let Some(place) = place.filter(|place| place.exists() && !check.new_baseline) else { return Ok(None) };
    let refused = |error: String| {
        Failure::input(format!(
            "{}: {error}; it is the baseline of checks: --new-baseline replaces it",
            place.display()
        ))
    };
    let text = std::fs::read_to_string(place).map_err(|error| refused(error.to_string()))?;
    let Stored { schema, report } =
        serde_json::from_str(&text).map_err(|error| refused(error.to_string()))?;
    if schema != Report::SCHEMA {
        return Err(refused(format!("its schema is {schema}, expected {}", Report::SCHEMA)));
    }
    if (report.level_kpa, report.stretch) != (check.level, check.stretch) {
        return Err(refused(format!(
            "it was made with --level {} --stretch {}, and only equal checks can be compared",
            report.level_kpa, report.stretch
        )));
    }
    Ok(Some(report))
}

/// Refuses a place that [`store`] could not write to, while no chamber has moved.
pub fn can_be_stored(place: Option<&Path>, check: &CheckArgs) -> Result<(), Failure> {
    let Some(place) = place.filter(|place| check.new_baseline || !place.exists()) else { return Ok(()) };
    file_is_writable(&beside(place)).map_err(|error| {
        Failure::input(format!(
            "{}: nothing can be written there: {error}; it is the baseline of later checks: --baseline FILE.json keeps it elsewhere",
            place.display()
        ))
    })
}

/// Where a baseline is written before it takes its place: it is whole at any time.
fn beside(place: &Path) -> PathBuf {
    place.with_extension("json.new")
}

/// Stores `report` where there is no baseline yet, or a new one is wanted; says so. What fails is
/// nothing to compare with.
pub fn store(place: Option<&Path>, check: &CheckArgs, report: &Report) -> Result<Option<String>, Failure> {
    let Some(place) = place else {
        return Ok(Some(
            "no baseline: --baseline FILE.json or a rig file keeps it for the next check".to_owned(),
        ));
    };
    let name = place.display();
    if place.exists() && !check.new_baseline {
        return Ok(None);
    }
    if report.was_broken_off() {
        return Ok(Some(format!("{name}: not written: a check that was broken off is no baseline")));
    }
    if report.verdict == Verdict::Fail {
        return Ok(Some(format!("{name}: not written: a check that fails is no baseline")));
    }
    let stored = Stored { schema: Report::SCHEMA, report: report.clone() };
    let text = serde_json::to_string_pretty(&stored).map_err(Failure::running)?;
    let beside = beside(place);
    std::fs::write(&beside, text + "\n")
        .and_then(|()| std::fs::rename(&beside, place))
        .map_err(|error| Failure::running(format!("{name}: {error}")))?;
    Ok(Some(format!("{name}: written; the next check is compared with this one")))
}
