//! `pneudrive-model fit`

use std::collections::BTreeMap;
use std::path::PathBuf;

use pneudrive_model::data::{Channel, ChannelId, Recording};
use pneudrive_model::experiment::{Prepared, Score, Setup, Split, channels_at_once, prepare, score};
use pneudrive_model::fit::{Control, Fit};
use pneudrive_model::report::{Table, number, significant};
use pneudrive_model::rig::Rig;
use pneudrive_model::rollout::Start;
use pneudrive_model::store::{ChannelParameters, ParameterFile, Settings};
use serde::Serialize;

use super::input::DataArgs;
use super::options::{FitArgs, ModelArg, ObjectiveArg, SetupArgs, SplitArgs};
use super::progress::FitBar;
use super::{Failure, interrupt, origin, output};

/// Fit one model to a recording and save its parameters
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model fit run.csv --rig rig.toml --out nonlinear.toml\n  \
pneudrive-model fit run.csv.gz --rig rig.toml --model parametric --fit-seconds 200 --channels b0c0,b0c1 --out p.toml\n  \
pneudrive-model fit regulator.csv --model linear --out linear.toml\n\n\
Writes the parameters with provenance and covariance as TOML, and the whole result as JSON beside it.")]
pub struct Args {
    #[command(flatten)]
    input: DataArgs,
    /// Model
    #[arg(long, value_enum, default_value_t = ModelArg::Nonlinear)]
    model: ModelArg,
    /// Parameter file to write; the JSON has the same name with .json
    #[arg(long, value_name = "FILE.toml")]
    out: PathBuf,
    #[command(flatten)]
    split: SplitArgs,
    #[command(flatten)]
    setup: SetupArgs,
    #[command(flatten)]
    fit: FitArgs,
    /// Compute profile-likelihood intervals too (slower)
    #[arg(long)]
    profiles: bool,
}

/// The JSON beside the parameter file.
#[derive(Serialize)]
struct Output<'a> {
    schema: &'static str,
    parameters: &'a ParameterFile,
    quality: &'a pneudrive_model::data::QualityReport,
    channels: BTreeMap<ChannelId, ChannelOutput>,
    fit_s: f64,
}

#[derive(Serialize)]
struct ChannelOutput {
    fit: Fit,
    fitted: Option<Score>,
    held_out: Option<Score>,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        let rig = self.input.load_rig()?;
        let loaded = self.input.load(&rig)?;
        let recording = &loaded.recording;
        let ranges = match self.split.split() {
            Some(split) => split.rows(recording)?.to_vec(),
            None => {
                let whole = 0..recording.rows();
                if whole.len() < Split::LEAST_ROWS {
                    let (file, rows) = (self.input.data.display(), whole.len());
                    let least = Split::LEAST_ROWS;
                    return Err(Failure::input(format!(
                        "{file}: {rows} rows are too few to fit; {least} at least"
                    )));
                }
                vec![whole]
            }
        };
        let cancel = interrupt::watch()?;
        let model = pneudrive_model::experiment::ModelKind::from(self.model);
        let bar = FitBar::new(format!(
            "fitting the {} model to {} channel(s)",
            model.name(),
            recording.channels.len()
        ));
        let progress = |p| bar.set(p);
        let control = Control { progress: &progress, cancel };
        let began = origin::seconds();
        let mut outputs = BTreeMap::new();
        let mut stored = BTreeMap::new();
        for part in recording.channels.chunks(channels_at_once(recording)) {
            let channels = self.prepare(recording, part, &rig, &ranges)?;
            self.check_objective(&channels)?;
            for (index, fit) in self.fit_all(&channels, control)? {
                let (channel, prepared) = &channels[index];
                stored.insert(channel.id, ChannelParameters::of(prepared.setup, &fit));
                outputs.insert(channel.id, judged(prepared, fit));
            }
        }
        bar.finish();
        let fit_s = origin::seconds() - began;
        let rows = &ranges[0];
        let file = ParameterFile {
            schema: ParameterFile::SCHEMA.to_owned(),
            provenance: origin::provenance(&recording.source, self.input.rig.as_deref()),
            settings: Settings {
                objective: if self.fit.objective == ObjectiveArg::Rollout { "rollout" } else { "rate" }
                    .to_owned(),
                starts: self.fit.starts as usize,
                seed: self.fit.seed,
                fit_seconds: recording.time_s[rows.end - 1] - recording.time_s[rows.start],
                printed_flow: self.setup.form() == pneudrive_model::model::FlowForm::Printed,
                stopped: cancel.load(std::sync::atomic::Ordering::SeqCst),
            },
            rig,
            channels: stored,
        };
        print(&outputs);
        file.save(&self.out)?;
        let json = self.out.with_extension("json");
        let schema = "pneudrive-fit/1";
        output::json(
            &json,
            &Output { schema, parameters: &file, quality: &loaded.quality, channels: outputs, fit_s },
        )?;
        println!("\nwrote {} and {}", self.out.display(), json.display());
        interrupt::check("these files")
    }

    fn prepare<'r>(
        &self,
        recording: &'r Recording,
        part: &'r [Channel],
        rig: &Rig,
        ranges: &[std::ops::Range<usize>],
    ) -> Result<Vec<(&'r Channel, Prepared)>, Failure> {
        let (controller, drive) = (self.setup.controller.into(), self.setup.drive.into());
        let one = |channel: &'r Channel| {
            let setup = Setup::resolve(self.model.into(), controller, drive, recording, channel, rig)?;
            Ok((channel, prepare(setup, recording, channel, rig, self.setup.form(), ranges)?))
        };
        part.iter().map(one).collect()
    }

    fn check_objective(&self, channels: &[(&Channel, Prepared)]) -> Result<(), Failure> {
        if self.fit.objective == ObjectiveArg::Rate && channels.iter().any(|(_, p)| !p.subject.has_rates()) {
            return Err(Failure::input(
                "--objective rate needs a recorded drive: with the board's loop simulated only rollouts can be fitted",
            ));
        }
        Ok(())
    }

    /// Fits these channels, those with one setup together; returns (index, fit).
    fn fit_all(
        &self,
        channels: &[(&Channel, Prepared)],
        control: Control<'_>,
    ) -> Result<Vec<(usize, Fit)>, Failure> {
        let options = self.fit.options(self.profiles);
        let mut fits = Vec::new();
        let mut setups: Vec<Setup> = Vec::new();
        for (_, prepared) in channels {
            if setups.contains(&prepared.setup) {
                continue;
            }
            setups.push(prepared.setup);
            let group: Vec<usize> =
                (0..channels.len()).filter(|&k| channels[k].1.setup == prepared.setup).collect();
            let series: Vec<_> = group.iter().map(|&k| &channels[k].1.series[0]).collect();
            let outcomes = prepared.subject.fit(&series, self.fit.objective(), &options, control);
            for (index, outcome) in group.into_iter().zip(outcomes) {
                let id = channels[index].0.id;
                let fit = outcome.map_err(|e| Failure::running(format!("channel {id}: {e}")))?;
                fits.push((index, fit));
            }
        }
        Ok(fits)
    }
}

fn judged(prepared: &Prepared, fit: Fit) -> ChannelOutput {
    let (subject, values) = (&prepared.subject, fit.values());
    let starts = fit.starts::<1>();
    let start = if starts.is_empty() { Start::Measured } else { Start::Given(&starts) };
    let simulate = |series, start| score(series, &subject.simulate(&values, series, start, fit.substeps));
    let fitted = simulate(&prepared.series[0], start);
    let held_out = prepared.series.get(1).and_then(|series| simulate(series, Start::Measured));
    ChannelOutput { fit, fitted, held_out }
}

fn print(outputs: &BTreeMap<ChannelId, ChannelOutput>) {
    for (id, output) in outputs {
        let fit = &output.fit;
        let rmse = |score: &Option<Score>| score.map_or_else(|| "n/a".to_owned(), |s| number(s.rmse_kpa, 3));
        println!(
            "\n{id}: rollout RMSE {} kPa on the fitted part{}; {} of {} starts agree; condition number {}",
            rmse(&output.fitted),
            output
                .held_out
                .map_or_else(String::new, |_| format!(", {} kPa on the rest", rmse(&output.held_out))),
            fit.agreeing_starts,
            fit.starts.len(),
            significant(fit.condition, 2)
        );
        let rows: Vec<Vec<String>> = fit
            .parameters
            .iter()
            .map(|p| {
                let interval = p.ci95.map_or_else(
                    || "-".to_owned(),
                    |[a, b]| format!("{} to {}", significant(a, 4), significant(b, 4)),
                );
                let mark = match (p.at_bound, fit.undetermined.iter().any(|u| u.name == p.name)) {
                    (Some(_), _) => "at its bound",
                    (None, true) => "not determined",
                    (None, false) if p.fixed => "fixed: the volume does not change",
                    (None, false) => "",
                };
                vec![p.name.clone(), significant(p.value, 5), p.unit.to_owned(), interval, mark.to_owned()]
            })
            .collect();
        println!("{}", Table::text(&["parameter", "value", "unit", "95 % interval", ""], &rows));
    }
}
