//! `pneudrive-model simulate`: with what `fit` saved, or with the extended model of a diagnosis.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use pneudrive_model::data::{Channel, ChannelId, Flags, Loaded, Recording, write};
use pneudrive_model::diagnosis::{
    EXTENDED_SCHEMA, ExtendedFile, Purpose, SimulatedChannel, simulate_extended,
};
use pneudrive_model::experiment::{ControllerUse, Score, Setup, score, score_rows, simulation};
use pneudrive_model::report::number;
use pneudrive_model::rig::Rig;
use pneudrive_model::rollout::Start;
use pneudrive_model::store::ParameterFile;
use serde::Serialize;

use super::input::DataArgs;
use super::options::ControllerArg;
use super::{Failure, output};

/// Simulate pressures from commands or drives alone, with saved parameters
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model simulate commands.csv --parameters nonlinear.toml --out predicted.csv\n  \
pneudrive-model simulate run.csv --parameters nonlinear.toml --controller on --out predicted.csv.gz\n  \
pneudrive-model simulate commands.csv --parameters diagnosis/extended.toml --out predicted.csv\n\n\
DATA needs commands (linear model, or the board's loop simulated) or drives; measured pressures are not used, except for \
the first of each stretch to start from, and to judge the simulation by. The output has the format of a recording, with \
the simulated pressures in place of measured ones, and JSON beside it.")]
pub struct Args {
    #[command(flatten)]
    input: DataArgs,
    /// Parameter file that `fit` wrote, or extended.toml that `diagnose` wrote
    #[arg(long, value_name = "FILE.toml")]
    parameters: PathBuf,
    /// Recording to write (.csv, .csv.gz or .csv.zst); the JSON has the same name with .json
    #[arg(long, value_name = "FILE.csv")]
    out: PathBuf,
    /// Simulate the board's loop [default: as fitted; on if the drive is not in DATA]
    #[arg(long, value_enum, default_value_t = ControllerArg::Auto)]
    controller: ControllerArg,
    /// Pressure to start from where DATA has no measured one, kPa gauge
    #[arg(long, value_name = "KPA", default_value_t = 0.0, allow_negative_numbers = true)]
    start_kpa: f64,
}

#[derive(Serialize)]
struct Output<'a> {
    schema: &'static str,
    origin: pneudrive_model::experiment::Origin,
    data: &'a pneudrive_model::data::Source,
    parameters: String,
    rows: usize,
    channels: BTreeMap<ChannelId, ChannelOutput>,
}

#[derive(Serialize)]
struct ChannelOutput {
    setup: Simulated,
    score: Option<Score>,
    lowest_kpa: f64,
    highest_kpa: f64,
}

/// What was simulated.
#[derive(Serialize)]
#[serde(untagged)]
enum Simulated {
    Fitted(Setup),
    Extended { model: String, driven_by: &'static str, effects: Vec<String>, correction: bool },
}

impl Simulated {
    fn words(&self) -> String {
        match self {
            Self::Fitted(setup) => format!("{} model", setup.model.name()),
            Self::Extended { model, effects, correction, .. } => {
                let parts: Vec<&str> =
                    effects.iter().map(String::as_str).chain(correction.then_some("a correction")).collect();
                if parts.is_empty() {
                    format!("{model} model")
                } else {
                    format!("{model} model with {}", parts.join(", "))
                }
            }
        }
    }
}

/// The results of all channels.
type Results = Vec<(Channel, ChannelOutput)>;

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        // The rig the parameters were fitted with, unless another is given on purpose.
        let given = self.input.rig.is_some().then(|| self.input.load_rig()).transpose()?;
        let (recording, results) = if is_extended(&self.parameters) {
            let file = ExtendedFile::load(&self.parameters).map_err(Failure::input)?;
            let rig = given.unwrap_or_else(|| file.rig.clone());
            let Loaded { recording, .. } = self.input.load(&rig)?;
            let results = self.extended(&file, &recording, &rig)?;
            (recording, results)
        } else {
            let file = ParameterFile::load(&self.parameters)?;
            let rig = given.unwrap_or_else(|| file.rig.clone());
            let Loaded { recording, .. } = self.input.load(&rig)?;
            let one = |channel| self.channel(&file, &recording, channel, &rig);
            let results = recording.channels.iter().map(one).collect::<Result<Results, Failure>>()?;
            (recording, results)
        };
        let mut simulated = Recording { channels: Vec::new(), ..recording.clone() };
        let mut channels = BTreeMap::new();
        for (channel, output) in results {
            channels.insert(channel.id, output);
            simulated.channels.push(channel);
        }
        for (id, output) in &channels {
            let judged = output.score.map_or_else(String::new, |s| {
                format!("; RMSE to the measured pressure {} kPa", number(s.rmse_kpa, 3))
            });
            println!(
                "{id}: {}, {:.2} to {:.2} kPa{judged}",
                output.setup.words(),
                output.lowest_kpa,
                output.highest_kpa
            );
        }
        write::recording(&self.out, &simulated)?;
        let json = json_beside(&self.out);
        let parameters = self.parameters.display().to_string();
        let (schema, rows) = ("pneudrive-simulation/1", recording.rows());
        let origin = super::origin::origin();
        output::json(&json, &Output { schema, origin, data: &recording.source, parameters, rows, channels })?;
        println!("wrote {} and {}", self.out.display(), json.display());
        Ok(())
    }

    fn channel(
        &self,
        file: &ParameterFile,
        recording: &Recording,
        channel: &Channel,
        rig: &Rig,
    ) -> Result<(Channel, ChannelOutput), Failure> {
        let name = self.parameters.display().to_string();
        let stored = file.channel(&name, channel.id)?;
        let controller = match self.controller {
            ControllerArg::Auto if stored.setup.controller => ControllerUse::On,
            other => other.into(),
        };
        let drive = stored.setup.drive.unwrap_or_default();
        let setup = Setup::resolve(stored.setup.model, controller, drive, recording, channel, rig)?;
        let prepared = simulation(setup, recording, channel, rig, file.flow_form(), self.start_kpa)?;
        let values = file.values(&name, channel.id, &*prepared.subject)?;
        let series = &prepared.series[0];
        let absolute = prepared.subject.simulate(&values, series, Start::Measured, stored.substeps);
        let ambient_kpa = rig.ambient_or_standard().pressure_kpa_abs;
        // Single precision: as measured pressures are kept.
        let gauge: Vec<f32> = absolute.iter().map(|pa| (pa * 1e-3 - ambient_kpa) as f32).collect();
        let finite = || gauge.iter().copied().filter(|p| p.is_finite());
        let covered = series.segments().iter().map(std::ops::Range::len).sum::<usize>();
        if finite().count() < covered {
            let id = channel.id;
            return Err(Failure::running(format!(
                "channel {id}: the simulation runs away; the inputs or the rig are not what the parameters were fitted with"
            )));
        }
        let output = ChannelOutput {
            setup: Simulated::Fitted(setup),
            score: (channel.usable_samples() > 0).then(|| score(series, &absolute)).flatten(),
            lowest_kpa: f64::from(finite().fold(f32::INFINITY, f32::min)),
            highest_kpa: f64::from(finite().fold(f32::NEG_INFINITY, f32::max)),
        };
        let flags = vec![Flags::NONE; gauge.len()];
        Ok((Channel { pressure_kpa: Some(gauge), flags, ..channel.clone() }, output))
    }
}

impl Args {
    /// All channels with the extended model of a diagnosis.
    fn extended(&self, file: &ExtendedFile, recording: &Recording, rig: &Rig) -> Result<Results, Failure> {
        let controller = match self.controller {
            ControllerArg::On => true,
            ControllerArg::Off => false,
            ControllerArg::Auto => file.channels.values().any(|c| c.drive == "board"),
        };
        let purpose = Purpose::Simulate { start_kpa: self.start_kpa, controller };
        let name = self.parameters.display().to_string();
        let simulated = simulate_extended(&name, file, recording, rig, purpose).map_err(Failure::input)?;
        simulated.into_iter().map(|s| extended_output(file, recording, s)).collect()
    }
}

fn extended_output(
    file: &ExtendedFile,
    recording: &Recording,
    simulated: SimulatedChannel,
) -> Result<(Channel, ChannelOutput), Failure> {
    let id = simulated.id;
    if !simulated.kpa.iter().all(|p| p.is_finite()) {
        return Err(Failure::running(format!(
            "channel {id}: the simulation runs away; the inputs or the rig are not what the model was fitted with"
        )));
    }
    let channel = recording.channel(id)?;
    let score = score_rows(recording, channel, &simulated.kpa, &simulated.usable);
    let stored = file.channels.get(&id.to_string());
    let output = ChannelOutput {
        setup: Simulated::Extended {
            model: file.model.clone(),
            driven_by: simulated.driven_by,
            effects: stored.map(|c| c.effects.keys().cloned().collect()).unwrap_or_default(),
            correction: stored.is_some_and(|c| c.correction.is_some()),
        },
        score,
        lowest_kpa: simulated.kpa.iter().copied().fold(f64::INFINITY, f64::min),
        highest_kpa: simulated.kpa.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    };
    // Single precision: as measured pressures are kept.
    let kpa: Vec<f32> = simulated.kpa.iter().map(|p| *p as f32).collect();
    let flags = vec![Flags::NONE; kpa.len()];
    Ok((Channel { pressure_kpa: Some(kpa), flags, ..channel.clone() }, output))
}

/// Does the file say that it is the extended model of a diagnosis? What cannot be read says nothing; loading it then says why.
fn is_extended(path: &Path) -> bool {
    let table = std::fs::read_to_string(path).ok().and_then(|text| text.parse::<toml::Table>().ok());
    table.is_some_and(|t| t.get("schema").and_then(toml::Value::as_str) == Some(EXTENDED_SCHEMA))
}

/// `a.csv.gz` becomes `a.json`.
fn json_beside(path: &Path) -> PathBuf {
    let compressed = path.extension().is_some_and(|e| e == "gz" || e == "zst");
    let plain = if compressed { path.with_extension("") } else { path.to_path_buf() };
    plain.with_extension("json")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_json_lies_beside_a_compressed_file_too() {
        assert_eq!(json_beside(Path::new("d/a.csv.gz")), Path::new("d/a.json"));
        assert_eq!(json_beside(Path::new("a.csv")), Path::new("a.json"));
    }
}
