//! The table of what the diagnosis says: made, compared, written.

use std::path::{Path, PathBuf};

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::diagnosis::{self, diagnose};
use pneudrive_model::rig::Rig;
use system_tests::blind::plan::{Case, table};
use system_tests::blind::score::{named, score};
use system_tests::blind::table::{Entry, Table};

use super::Result;
use super::recording::{Extent, record};

/// Part of its interval by which a number may move.
pub const SHARE: f64 = 0.1;

const HEAD: &str = "\
# What the diagnosis says of fixed recordings by the truth plant, right or wrong: what a rewrite is
# compared with. `cargo run --release -p system-tests --example blind -- table` compares, with
# --write it makes this file.
";

/// What is asked.
pub struct Request {
    /// The table; the committed one where none is given.
    pub file: Option<PathBuf>,
    /// Part of its interval by which a number may move.
    pub share: f64,
    /// Only recordings with this in their name.
    pub only: Option<String>,
    /// Replace the table instead of comparing with it?
    pub write: bool,
}

/// Makes and diagnoses the recordings; prints what differs from the table. `false` where something
/// does.
pub fn run(request: &Request) -> Result<bool> {
    let file = request
        .file
        .clone()
        .unwrap_or_else(|| PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tables/blind.toml")));
    let wanted = |name: &str| request.only.as_ref().is_none_or(|only| name.contains(only.as_str()));
    if request.write && request.only.is_some() {
        return Err("--write makes the whole table: leave --only away".into());
    }
    let mut known = Table { recordings: Vec::new() };
    if !request.write {
        let text = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        known = toml::from_str(&text).map_err(|e| format!("{}: {e}", file.display()))?;
        known.recordings.retain(|entry| wanted(&entry.name));
    }
    let folder = tempfile::tempdir()?;
    let mut now = Table { recordings: Vec::new() };
    for (name, case) in table().into_iter().filter(|(name, _)| wanted(name)) {
        now.recordings.push(diagnosed(folder.path(), &name, &case)?);
    }
    if now.recordings.is_empty() {
        return Err("no recording of the table has such a name".into());
    }
    if request.write {
        std::fs::write(&file, format!("{HEAD}\n{}", toml::to_string(&now)?))?;
        println!("{}: {} recordings", file.display(), now.recordings.len());
        return Ok(true);
    }
    let differences = known.differences(&now, request.share);
    for difference in &differences {
        println!("DIFFERENT {difference}");
    }
    println!("{} recordings, {} differences", now.recordings.len(), differences.len());
    Ok(differences.is_empty())
}

/// Makes one recording and says what the diagnosis says. It is given the data file and the nominal
/// rig, nothing else.
fn diagnosed(folder: &Path, name: &str, case: &Case) -> Result<Entry> {
    let folder = folder.join(name);
    record(&folder, case, Extent::SHORT)?;
    let rig = Rig::parse("rig.toml", &std::fs::read_to_string(folder.join("rig.toml"))?)?;
    let limits = |channel| rig.sensor_limits(channel);
    let loaded =
        load(&folder.join("run.csv"), LoadOptions { limits: Some(&limits), ..LoadOptions::default() })?;
    let report = serde_json::to_value(
        diagnose(&loaded.recording, &rig, diagnosis::Request::default(), &|_, _| {})?.report,
    )?;
    let drive = if case.drive { "drive" } else { "closed loop" };
    let outcome = score(case, &report);
    println!(
        "{name}: hidden [{}] ({drive}), named [{}]: {outcome:?}",
        case.arguments.join(", "),
        named(&report)
    );
    Entry::new(name, case, &report).ok_or_else(|| format!("{name}: the report lacks something").into())
}
