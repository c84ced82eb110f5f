//! What `diagnose` writes and prints about a machine.

use std::path::Path;

use pneudrive_model::data::{Source, write};
use pneudrive_model::diagnosis::json::{Estimate, Report};
use pneudrive_model::diagnosis::machine::{MachineDiagnosis, page};
use pneudrive_model::report::{Table, behind};

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
    outln!("\n{}", recordings(&found.report));
    outln!("{}", alternatives(&found.report));
    outln!("{}", output::wrote_page(&out.join(PAGE), replaced));
    Ok(())
}

fn recordings(report: &Report) -> String {
    let all = report.machine.iter().flat_map(|machine| &machine.recordings);
    let rows: Vec<Vec<String>> = all
        .flat_map(|record| record.load.iter().map(move |(channel, load)| (record, channel, load)))
        .map(|(record, channel, load)| {
            let sizes: Vec<String> = load.iter().map(|(name, e)| size(name, e)).collect();
            vec![
                record.file.clone(),
                channel.clone(),
                format!("{:.3} -> {:.3}", record.test_rmse_before_kpa, record.test_rmse_after_kpa),
                sizes.join("; "),
            ]
        })
        .collect();
    Table::text(&["recording", "channel", "error before -> after, kPa", "load [95 %]"], &rows)
}

fn size(name: &str, e: &Estimate) -> String {
    let unit = behind(&e.unit);
    match (e.state.as_str(), e.ci95) {
        ("taken as the unit", _) => format!("{name} {:.3}{unit} (the unit)", e.value),
        (_, Some([low, high])) => format!("{name} {:.3} [{low:.3}, {high:.3}]{unit}", e.value),
        (_, None) => format!("{name} not identifiable here"),
    }
}

fn alternatives(report: &Report) -> String {
    let rows: Vec<Vec<String>> = report
        .alternatives
        .iter()
        .map(|a| {
            vec![a.causes.join(" + "), format!("{:.3}", a.probability), format!("{:.3}", a.select_rmse_kpa)]
        })
        .collect();
    Table::text(&["missing", "probability", "error where causes are chosen, kPa"], &rows)
}
