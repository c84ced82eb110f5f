//! `pneudrive-model diagnose`

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use indicatif::ProgressBar;
use pneudrive_model::data::{ChannelId, Recording, each_once, half_drives, write};
use pneudrive_model::diagnosis::machine::{MachineRequest, diagnose_machine};
use pneudrive_model::diagnosis::{
    AS_REGULATORS, Diagnosis, EXTENDED_FILE, Progress, Request, TRAJECTORY_FILE, diagnose, page, tables,
};
use pneudrive_model::effects::catalogue::nameable;
use pneudrive_model::rig::Rig;

use super::output::{PAGE, REPORT};
use super::print::{errln, outln};
use super::{Failure, input, interrupt, machine, origin, output, target};

/// Say what the simulation gets wrong, why, and what modelling it gains
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model diagnose run.csv --rig rig.toml --out diagnosis/\n  \
pneudrive-model diagnose run.csv --rig rig.toml --out now/ --reference before/extended.toml\n  \
pneudrive-model diagnose run.csv next.csv --rig rig.toml --out both/\n  \
pneudrive-model diagnose arm1.csv arm2.csv arm3.csv --rig rig.toml --loads differ --out machine/\n  \
pneudrive-model diagnose arm4.csv --rig rig.toml --machine machine/extended-arm1.toml --out arm4/\n  \
pneudrive-model diagnose run.csv --rig rig.toml --only line_restriction,supply_sag --out tube/\n  \
pneudrive-model diagnose regulator.csv --out diagnosis/\n\n\
DIR receives report.html, report.json and extended.toml, and next_experiment.csv where another recording would tell more: play it \
with `pneudrive-host --trajectory DIR/next_experiment.csv --record next.csv`, then diagnose both recordings together. Without --reference the question is which physical effect the model \
lacks; with it, which calibrated parameter has moved. The exit status is 0 whatever the verdict.")]
pub struct Args {
    /// Recordings of one rig: CSV, plain or compressed with gzip or zstd. Several are diagnosed
    /// together
    #[arg(value_name = "DATA", required = true)]
    data: Vec<PathBuf>,
    /// Rig description (TOML) [default: the copy that DATA carries, the same in all; without either
    /// channels are taken for regulators]
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// Channels to use, as in b0c0,b0c1 [default: all]
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    channels: Vec<ChannelId>,
    /// Folder for the results
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Calibrated model of the same rig: extended.toml of an earlier diagnosis, or the parameter
    /// file that `fit` wrote
    #[arg(long, value_name = "CALIBRATED.toml")]
    reference: Option<PathBuf>,
    /// Do the recordings have different loads (volumes, tubes, walls) on the same valves?
    /// Regulators have no load of their own
    #[arg(long, value_name = "WHICH", value_enum, default_value_t = Loads::Auto, conflicts_with = "reference")]
    loads: Loads,
    /// Calibrated model of the same machine with another load: valves, supply and sensor are taken
    /// from it, and only the load is fitted
    #[arg(long, value_name = "CALIBRATED.toml", conflicts_with_all = ["reference", "loads"])]
    machine: Option<PathBuf>,
    /// Effects that it may be, as in supply_sag,valve_lag, where you know that it can be nothing
    /// else [default: all that `pneudrive-model effects` lists]
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',', value_parser = nameable)]
    only: Vec<usize>,
    /// Highest pressure that a suggested next experiment may command, kPa gauge [default: the
    /// highest in DATA]
    #[arg(long, value_name = "KPA", value_parser = pressure)]
    highest_kpa: Option<f64>,
}

/// Whether several recordings have the same load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Loads {
    /// Find out
    Auto,
    /// One load: the recordings are diagnosed as one
    Same,
    /// Each recording has its own
    Differ,
}

fn pressure(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a pressure above 0 kPa gauge".to_owned()),
    }
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        self.check_out()?;
        interrupt::end_at_once()?;
        let files: Vec<&Path> = self.data.iter().map(PathBuf::as_path).collect();
        let rig = input::shared_rig(self.rig.as_deref(), &files)?;
        let reference = self.reference.as_deref().map(input::extended).transpose()?;
        let (recordings, remarks) = self.load(&rig)?;
        let name = self.reference.as_deref().map(|p| p.display().to_string()).unwrap_or_default();
        let spinner = std::io::stderr().is_terminal().then(ProgressBar::new_spinner);
        let progress = |what: &str, _: u64| match (&spinner, what.is_empty()) {
            (Some(bar), true) => bar.tick(),
            (Some(bar), false) => bar.set_message(what.to_owned()),
            (None, false) => errln!("{what} ..."),
            (None, true) => {}
        };
        if self.is_machine() {
            let found = self.machine(&recordings, &rig, &progress)?;
            if let Some(mut found) = found {
                if let Some(bar) = &spinner {
                    bar.finish_and_clear();
                }
                tell_taken(&found.report.notes);
                found.report.notes.extend(remarks);
                let sources: Vec<_> = recordings.iter().map(|r| r.source.clone()).collect();
                return machine::write(&found, &self.out, &sources, self.rig.as_deref());
            }
        }
        let recording = joined(recordings)?;
        let pair = reference.as_ref().map(|file| (name.as_str(), file));
        let request = Request { reference: pair, highest_kpa: self.highest_kpa, only: &self.only };
        let mut diagnosis = diagnose(&recording, &rig, request, &progress).map_err(Failure::input)?;
        if let Some(bar) = &spinner {
            bar.finish_and_clear();
        }
        tell_taken(&diagnosis.report.notes);
        diagnosis.report.notes.extend(remarks);
        diagnosis.extended.provenance = Some(origin::provenance(&recording.source, self.rig.as_deref()));
        output::folder(&self.out)?;
        let replaced = self.out.join(PAGE).exists();
        diagnosis.extended.save(&self.out.join(EXTENDED_FILE))?;
        output::json(&self.out.join(REPORT), &diagnosis.report)?;
        let from = origin::origin();
        let footer = format!("{} | {} | {}", from.program, from.created, from.command);
        let html = page::page(&diagnosis, &footer).map_err(Failure::running)?;
        write::text_atomically(&self.out.join(PAGE), &html)?;
        outln!("{}", diagnosis.report.sentence);
        for table in tables::text(&diagnosis.report, false) {
            outln!("\n{table}");
        }
        self.next_experiment(&diagnosis)?;
        outln!("\n{}", output::wrote_page(&self.out.join(PAGE), replaced));
        Ok(())
    }

    fn check_out(&self) -> Result<(), Failure> {
        let options = self.rig.iter().chain(&self.reference).chain(&self.machine);
        let inputs: Vec<&Path> = self.data.iter().chain(options).map(PathBuf::as_path).collect();
        let mut names: Vec<String> =
            [REPORT, PAGE, EXTENDED_FILE, TRAJECTORY_FILE].map(str::to_owned).to_vec();
        if self.is_machine() {
            // Each recording's model has a name of its own, which may be that of a calibrated one.
            let calibrated = self.machine.iter().filter_map(|path| path.file_name());
            names.extend(calibrated.map(|name| name.to_string_lossy().into_owned()));
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        target::folder("--out", &self.out, &names, &inputs)
    }

    /// Writes the commands of the next experiment and says what it is for; takes away those of an
    /// earlier diagnosis.
    fn next_experiment(&self, diagnosis: &Diagnosis) -> Result<(), Failure> {
        let path = self.out.join(TRAJECTORY_FILE);
        let Some(plan) = &diagnosis.plan else {
            return match std::fs::remove_file(&path) {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                    Err(Failure::running(format!("{}: cannot be removed: {e}", path.display())))
                }
                _ => Ok(()),
            };
        };
        write::text_atomically(&path, &plan.trajectory)?;
        outln!("\nNext experiment: {}\n{}", plan.experiment.reason, plan.experiment.instruction);
        Ok(())
    }

    /// Is a machine asked for: a known one, or several recordings whose loads may differ?
    fn is_machine(&self) -> bool {
        let several = self.data.len() > 1 && self.reference.is_none() && self.loads != Loads::Same;
        self.machine.is_some() || several || self.loads == Loads::Differ
    }

    fn machine(
        &self,
        recordings: &[Recording],
        rig: &Rig,
        progress: &Progress<'_>,
    ) -> Result<Option<pneudrive_model::diagnosis::machine::MachineDiagnosis>, Failure> {
        if self.machine.is_none() && recordings.len() < 2 {
            return Err(Failure::input(
                "--loads differ needs several recordings of one machine, or --machine with a calibrated model of it",
            ));
        }
        let known = self.machine.as_deref().map(input::extended).transpose()?;
        let name = self.machine.as_deref().map(|p| p.display().to_string()).unwrap_or_default();
        let request = MachineRequest {
            machine: known.as_ref().map(|file| (name.as_str(), file)),
            loads_differ: match self.loads {
                Loads::Auto => None,
                Loads::Same => Some(false),
                Loads::Differ => Some(true),
            },
            only: &self.only,
        };
        diagnose_machine(recordings, rig, request, progress).map_err(Failure::input)
    }

    /// The recordings, and what was noticed about their quality.
    fn load(&self, rig: &Rig) -> Result<(Vec<Recording>, Vec<String>), Failure> {
        let (mut recordings, mut remarks) = (Vec::new(), Vec::new());
        for path in &self.data {
            let loaded = input::recording(path, &self.channels, rig)?;
            let of = |sentence: String| match self.data.len() {
                1 => sentence,
                _ => format!("{}: {sentence}", path.display()),
            };
            remarks.extend(loaded.quality.sentences().into_iter().map(of));
            recordings.push(loaded.recording);
        }
        each_once(&recordings).map_err(Failure::input)?;
        let half = half_drives(&recordings);
        half.iter().for_each(|sentence| errln!("{sentence}"));
        remarks.extend(half);
        Ok((recordings, remarks))
    }
}

/// All recordings as one.
fn joined(recordings: Vec<Recording>) -> Result<Recording, Failure> {
    let mut joined: Option<Recording> = None;
    for next in recordings {
        joined = Some(match joined {
            None => next,
            Some(first) => first.followed_by(next).map_err(Failure::input)?,
        });
    }
    // The arguments ask for one file at least.
    joined.ok_or_else(|| Failure::input("no recording is given"))
}

/// What an answer does not hold for, or takes for granted, must not be seen in the report alone.
fn tell_taken(notes: &[String]) {
    let told = |note: &&String| ["Left out: ", AS_REGULATORS].iter().any(|part| note.contains(part));
    notes.iter().filter(told).for_each(|note| errln!("{note}"));
}
