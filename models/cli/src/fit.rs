//! `pneudrive-model fit`

use std::collections::BTreeMap;
use std::path::PathBuf;

use pneudrive_model::data::ChannelId;
use pneudrive_model::experiment::{FitSettings, FittedChannel, ModelKind, Score, fit_channels};
use pneudrive_model::fit::{Control, Ending, Fit};
use pneudrive_model::report::{Table, number, significant};
use pneudrive_model::store::ParameterFile;
use serde::Serialize;

use super::input::DataArgs;
use super::options::{FitArgs, ModelArg, SetupArgs, SplitArgs};
use super::print::{errln, outln};
use super::progress::FitBar;
use super::{Failure, interrupt, origin, output, target};

/// Fit one model to a recording and save its parameters
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model fit run.csv --rig rig.toml --out nonlinear.toml\n  \
pneudrive-model fit run.csv.gz --rig rig.toml --model parametric --channels b0c0,b0c1 --out p.toml\n  \
pneudrive-model fit regulator.csv --model linear --out linear.toml\n\n\
Writes the parameters with provenance and covariance as TOML, and the whole result as JSON beside it.")]
pub struct Args {
    #[command(flatten)]
    input: DataArgs,
    /// Model
    #[arg(long, value_enum, default_value_t = ModelArg(ModelKind::Nonlinear))]
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

/// A recording that is shorter hardly tells the parameters, s: eight blocks, that a diagnosis is
/// made of at the least, are not much longer.
const SHORT_S: f64 = 20.0;

/// The JSON beside the parameter file.
const SCHEMA: &str = "pneudrive-fit/1";

#[derive(Serialize)]
struct Output<'a> {
    schema: &'static str,
    parameters: &'a ParameterFile,
    quality: &'a pneudrive_model::data::QualityReport,
    channels: BTreeMap<ChannelId, FittedChannel>,
    fit_s: f64,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        self.check_out()?;
        let rig = self.input.load_rig()?;
        let loaded = self.input.load(&rig)?;
        let recording = &loaded.recording;
        let model = self.model.0;
        let settings = FitSettings {
            model,
            split: self.split.split(),
            objective: self.fit.objective(),
            controller: self.setup.controller.into(),
            drive: self.setup.drive.into(),
            form: self.setup.form(),
            fit: self.fit.options(self.profiles),
        };
        // Before the progress bar: what cannot be divided is said at once.
        let rows = &settings.ranges(recording)?[0];
        let fitted_s = recording.time_s[rows.end - 1] - recording.time_s[rows.start];
        if fitted_s < SHORT_S {
            errln!(
                "warning: {fitted_s:.1} s are fitted; what they do not show is not known (a minute at least is better, and diagnose refuses less than {SHORT_S:.0} s)"
            );
        }
        let cancel = interrupt::watch()?;
        let bar = FitBar::new(format!(
            "fitting the {} model to {} channel(s)",
            model.name(),
            recording.channels.len()
        ));
        let progress = |p| bar.set(p);
        let control = Control { progress: &progress, cancel };
        let began = origin::seconds();
        let fitted = fit_channels(recording, &rig, &settings, control)?;
        bar.finish();
        let fit_s = origin::seconds() - began;
        let stopped = cancel.load(std::sync::atomic::Ordering::SeqCst);
        let mut file = ParameterFile::of(recording, &rig, &settings, &fitted)?;
        file.provenance = origin::provenance(&recording.source, self.input.rig.as_deref());
        file.settings.stopped = stopped;
        let outputs: BTreeMap<ChannelId, FittedChannel> =
            fitted.into_iter().map(|f| (f.channel, f)).collect();
        print(&outputs);
        file.save(&self.out)?;
        let json = self.out.with_extension("json");
        output::json(
            &json,
            &Output { schema: SCHEMA, parameters: &file, quality: &loaded.quality, channels: outputs, fit_s },
        )?;
        outln!("\nwrote {} and {}", self.out.display(), json.display());
        interrupt::check("these files")
    }

    fn check_out(&self) -> Result<(), Failure> {
        let inputs = self.input.files();
        target::result("--out", &self.out, &self.out.with_extension("json"), SCHEMA, &inputs)?;
        target::ending("--out", &self.out, "parameters (and JSON beside them) are", &[".toml"])
    }
}

/// How the values were found. Those of a search that was stopped are no minimum.
fn searched(fit: &Fit) -> String {
    match fit.ending {
        Ending::Cancelled if fit.starts.iter().all(|start| start.evaluations <= 1) => {
            "not begun when it was stopped: these are starting values".to_owned()
        }
        Ending::Cancelled => "stopped on the way to a minimum, so without intervals".to_owned(),
        _ => format!("{} of {} starts agree", fit.agreeing_starts, fit.starts.len()),
    }
}

fn print(outputs: &BTreeMap<ChannelId, FittedChannel>) {
    for (id, output) in outputs {
        let fit = &output.fit;
        let rmse = |score: &Option<Score>| score.map_or_else(|| "n/a".to_owned(), |s| number(s.rmse_kpa, 3));
        outln!(
            "\n{id}: rollout RMSE {} kPa on the fitted part{}; {}; condition number {}",
            rmse(&output.fitted),
            output
                .held_out
                .map_or_else(String::new, |_| format!(", {} kPa on the rest", rmse(&output.held_out))),
            searched(fit),
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
        outln!("{}", Table::text(&["parameter", "value", "unit", "95 % interval", ""], &rows));
    }
}
