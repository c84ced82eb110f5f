//! `pneudrive-model simulate`: with what `fit` saved, or with the extended model of a diagnosis.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use pneudrive_model::data::{ChannelId, Loaded, write};
use pneudrive_model::experiment::Score;
use pneudrive_model::report::number;
use pneudrive_model::simulation::{SimulatedModel, Simulation, SimulationSettings, simulate};
use serde::Serialize;

use super::input::{self, DataArgs};
use super::options::ControllerArg;
use super::print::outln;
use super::{Failure, output, target};

/// Simulate pressures from commands or drives alone, with saved parameters
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model simulate commands.csv --parameters nonlinear.toml --out predicted.csv\n  \
pneudrive-model simulate run.csv --parameters fitted.toml --controller on --out predicted.csv\n  \
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
    /// Rows per second to simulate [default: the rows of DATA; 100 where DATA has commands alone,
    /// and fewer rows than that]
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Simulate the board's loop [default: as fitted; on if the drive is not in DATA]
    #[arg(long, value_enum, default_value_t = ControllerArg::Auto)]
    controller: ControllerArg,
    /// Also write the 95 % band around each simulated pressure to this file: time, lowest and
    /// highest pressure of each channel. Models of `diagnose` have one
    #[arg(long, value_name = "FILE.csv")]
    band: Option<PathBuf>,
    /// Pressure to start from where DATA has no measured one, kPa gauge
    #[arg(long, value_name = "KPA", default_value_t = 0.0, allow_negative_numbers = true, value_parser = start_kpa)]
    start_kpa: f64,
}

/// From a vacuum to far above what any chamber holds, kPa gauge.
const START_KPA: std::ops::RangeInclusive<f64> = -101.0..=10_000.0;

fn start_kpa(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if START_KPA.contains(&value) => Ok(value),
        _ => Err(format!("expected a pressure of {} to {} kPa gauge", START_KPA.start(), START_KPA.end())),
    }
}

const SCHEMA: &str = "pneudrive-simulation/1";

#[derive(Serialize)]
struct Output<'a> {
    schema: &'static str,
    origin: pneudrive_model::experiment::Origin,
    data: &'a pneudrive_model::data::Source,
    parameters: String,
    rows: usize,
    channels: BTreeMap<ChannelId, ChannelOutput<'a>>,
}

#[derive(Serialize)]
struct ChannelOutput<'a> {
    setup: &'a SimulatedModel,
    score: Option<Score>,
    lowest_kpa: f64,
    highest_kpa: f64,
    /// Share of the measured pressures that the 95 % band holds.
    band_holds: Option<f64>,
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        self.check_out()?;
        let model = input::calibrated(&self.parameters)?;
        // The rig the parameters were fitted with, unless another is given on purpose.
        let given = self.input.rig.is_some().then(|| self.input.load_rig()).transpose()?;
        let rig = given.as_ref().unwrap_or(model.rig());
        let recording = self.at_rate(self.input.load(rig)?)?.recording;
        let controller = self.controller.into();
        let settings = SimulationSettings { rig: Some(rig), controller, start_kpa: self.start_kpa };
        let simulation = simulate(&model, &recording, &settings, &mut |_, _| {})?;

        let mut channels = BTreeMap::new();
        for channel in &simulation.channels {
            let (lowest_kpa, highest_kpa) = channel.range_kpa();
            let judged = channel.score.map_or_else(String::new, |s| {
                format!("; RMSE to the measured pressure {} kPa", number(s.rmse_kpa, 3))
            });
            let band_holds = channel.band.as_ref().and_then(|band| band.holds);
            let held = band_holds.map_or_else(String::new, |share| {
                format!("; its 95 % band holds {:.1} % of the measured pressures", 100.0 * share)
            });
            outln!(
                "{}: {}, {lowest_kpa:.2} to {highest_kpa:.2} kPa{judged}{held}",
                channel.id,
                channel.model.words()
            );
            let (setup, score) = (&channel.model, channel.score);
            channels.insert(channel.id, ChannelOutput { setup, score, lowest_kpa, highest_kpa, band_holds });
        }
        if let Some(path) = &self.band {
            let parameters = self.parameters.display();
            let band = band_csv(&simulation, &recording.time_s).ok_or_else(|| {
                Failure::input(format!(
                    "{parameters}: there is no band in it; extended.toml of `diagnose` has one"
                ))
            })?;
            write::text_atomically(path, &band)?;
            outln!("wrote {}", path.display());
        }
        write::recording(&self.out, &simulation.recording(&recording))?;
        let json = json_beside(&self.out);
        let parameters = self.parameters.display().to_string();
        let (schema, rows) = (SCHEMA, recording.rows());
        let origin = super::origin::origin();
        output::json(&json, &Output { schema, origin, data: &recording.source, parameters, rows, channels })?;
        outln!("wrote {} and {}", self.out.display(), json.display());
        Ok(())
    }

    /// The recording at the rate that is asked for. A file of set points has a row where they
    /// change: what happens between would not be seen.
    fn at_rate(&self, loaded: Loaded) -> Result<Loaded, Failure> {
        const USUAL_HZ: f64 = 100.0;
        let recording = &loaded.recording;
        let few = recording.is_commands_alone() && recording.rate_hz() < USUAL_HZ;
        match self.rate.or(few.then_some(USUAL_HZ)) {
            Some(rate) => loaded.resampled(rate).map_err(|error| Failure::input(format!("--rate: {error}"))),
            None => Ok(loaded),
        }
    }

    fn check_out(&self) -> Result<(), Failure> {
        let out = self.out.display();
        if self.band.as_ref() == Some(&self.out) {
            return Err(Failure::input(format!(
                "--band {out}: that is where --out goes; choose another name"
            )));
        }
        target::ending("--out", &self.out, "a recording is", &[".csv", ".csv.gz", ".csv.zst"])?;
        let mut inputs = self.input.files();
        inputs.push(&self.parameters);
        target::result("--out", &self.out, &json_beside(&self.out), SCHEMA, &inputs)?;
        self.band.iter().try_for_each(|band| target::file("--band", band, &inputs))
    }
}

/// Time, lowest and highest pressure of each channel that has a band. Nothing where none has.
fn band_csv(simulation: &Simulation, time_s: &[f64]) -> Option<String> {
    let banded = || simulation.channels.iter().filter_map(|c| Some((c, c.band.as_ref()?)));
    banded().next()?;
    let names = banded().map(|(c, _)| format!(",{0}_low_kpa,{0}_high_kpa", c.id));
    let mut text = format!("t_s{}\n", names.collect::<String>());
    for (row, t) in time_s.iter().enumerate() {
        text.push_str(&format!("{t:.6}"));
        for (channel, band) in banded() {
            let (kpa, half_kpa) = (channel.kpa[row], band.half_width_kpa[row]);
            text.push_str(&format!(",{:.4},{:.4}", kpa - half_kpa, kpa + half_kpa));
        }
        text.push('\n');
    }
    Some(text)
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
