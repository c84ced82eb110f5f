//! What `diagnose` writes and prints about a machine.

use std::path::Path;

use pneudrive_model::data::{Source, write};
use pneudrive_model::diagnosis::machine::{MachineDiagnosis, page};
use pneudrive_model::diagnosis::tables;

use super::output::{PAGE, REPORT};
use super::print::outln;
use super::{Failure, origin, output};

/// Writes report and models into a folder, and prints the verdict and a table of the recordings.
pub fn write(
    found: &MachineDiagnosis,
    out: &Path,
    sources: &[Source],
    rig: Option<&Path>,
) -> Result<(), Failure> {
    output::folder(out)?;
    let replaced = out.join(PAGE).exists();
    for ((name, file), source) in found.extended.iter().zip(sources) {
        let mut file = file.clone();
        file.provenance = Some(origin::provenance(source, rig));
        file.save(&out.join(name))?;
    }
    output::json(&out.join(REPORT), &found.report)?;
    let from = origin::origin();
    let footer = format!("{} | {} | {}", from.program, from.created, from.command);
    let html = page::page(found, &footer).map_err(Failure::running)?;
    write::text_atomically(&out.join(PAGE), &html)?;
    outln!("{}", found.report.sentence);
    for table in tables::text(&found.report, true) {
        outln!("\n{table}");
    }
    outln!("\n{}", output::wrote_page(&out.join(PAGE), replaced));
    Ok(())
}
