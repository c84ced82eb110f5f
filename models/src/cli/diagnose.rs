//! `pneudrive-model diagnose`

use std::io::IsTerminal;
use std::path::PathBuf;

use indicatif::ProgressBar;
use pneudrive_model::data::write;
use pneudrive_model::diagnosis::{EXTENDED_FILE, ExtendedFile, diagnose, page};
use pneudrive_model::report::Table;

use super::input::DataArgs;
use super::{Failure, origin, output};

/// Say what the simulation gets wrong, why, and what modelling it gains
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model diagnose run.csv --rig rig.toml --out diagnosis/\n  \
pneudrive-model diagnose run.csv --rig rig.toml --out diagnosis/ --reference calibrated/extended.toml\n\n\
DIR receives report.html, report.json and extended.toml. Without --reference the question is which physical effect the model \
lacks; with it, which calibrated parameter has moved. The exit status is 0 whatever the verdict.")]
pub struct Args {
    #[command(flatten)]
    input: DataArgs,
    /// Folder for the results
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Calibrated model: the extended.toml of an earlier diagnosis of the same rig
    #[arg(long, value_name = "CALIBRATED.toml")]
    reference: Option<PathBuf>,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        let rig = self.input.load_rig()?;
        let reference =
            self.reference.as_deref().map(ExtendedFile::load).transpose().map_err(Failure::input)?;
        let loaded = self.input.load(&rig)?;
        let name = self.reference.as_deref().map(|p| p.display().to_string()).unwrap_or_default();
        let spinner = std::io::stderr().is_terminal().then(ProgressBar::new_spinner);
        let progress = |what: &str, _: u64| match (&spinner, what.is_empty()) {
            (Some(bar), true) => bar.tick(),
            (Some(bar), false) => bar.set_message(what.to_owned()),
            (None, false) => eprintln!("{what} ..."),
            (None, true) => {}
        };
        let pair = reference.as_ref().map(|file| (name.as_str(), file));
        let mut diagnosis = diagnose(&loaded.recording, &rig, pair, &progress).map_err(Failure::input)?;
        if let Some(bar) = &spinner {
            bar.finish_and_clear();
        }
        diagnosis.report.notes.extend(loaded.quality.sentences());
        output::folder(&self.out)?;
        let extended = toml::to_string(&diagnosis.extended).map_err(Failure::running)?;
        write::text_atomically(&self.out.join(EXTENDED_FILE), &extended)?;
        output::json(&self.out.join("report.json"), &diagnosis.report)?;
        let from = origin::origin();
        let footer = format!("{} | {} | {}", from.program, from.created, from.command);
        let html = page::page(&diagnosis, &footer).map_err(Failure::running)?;
        write::text_atomically(&self.out.join("report.html"), &html)?;
        println!("{}", diagnosis.report.sentence);
        if !diagnosis.report.causes.is_empty() {
            println!("\n{}", causes(&diagnosis.report));
        }
        println!("\n{}", self.out.join("report.html").display());
        Ok(())
    }
}

fn causes(report: &pneudrive_model::diagnosis::json::Report) -> String {
    let rows: Vec<Vec<String>> = report
        .causes
        .iter()
        .map(|cause| {
            let sizes: Vec<String> = cause
                .parameters
                .iter()
                .map(|(name, e)| match e.ci95 {
                    Some([low, high]) => format!("{name} {:.4} [{low:.4}, {high:.4}] {}", e.value, e.unit),
                    None => format!("{name} not identifiable here"),
                })
                .collect();
            let g = &cause.gain;
            vec![
                cause.effect.clone(),
                cause.channels.join(","),
                sizes.join("; "),
                format!("{:.2} -> {:.2}", g.test_rmse_before_kpa, g.test_rmse_after_kpa),
                format!("{:.0} % [{:.0}, {:.0}]", 100.0 * g.reduction, 100.0 * g.ci95[0], 100.0 * g.ci95[1]),
                if cause.equivalent.is_empty() { "-".to_owned() } else { cause.equivalent.join(",") },
            ]
        })
        .collect();
    Table::text(
        &["cause", "channels", "size [95 %]", "test error, kPa", "gain [95 %]", "fits as well"],
        &rows,
    )
}
