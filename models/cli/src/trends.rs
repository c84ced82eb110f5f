//! `pneudrive-model trends`

use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use pneudrive_model::data::{ChannelId, LoadOptions, Recording, Source, created_utc, load, rig_copy, write};
use pneudrive_model::experiment::{FitSettings, ModelKind, fit_channels};
use pneudrive_model::fit::{Control, FitOptions};
use pneudrive_model::rig::Rig;
use pneudrive_model::store::ParameterFile;
use pneudrive_model::trends::{Calibration, TimeScale, Trend, changes, conclusion, trends, trends_page};
use serde::Serialize;

use super::options::ModelArg;
use super::print::{errln, outln};
use super::progress::FitBar;
use super::{Failure, interrupt, origin, output, target};

/// Show each calibrated parameter over a folder of recordings, and where it has changed
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
pneudrive-model trends recordings/\n  \
pneudrive-model trends recordings/ --rig rig.toml --channels b0c0,b0c1 --out pages/trends\n\n\
Fits every recording of FOLDER (.csv, .csv.gz, .csv.zst, .mcap) and writes trends.html, trends.json, and the parameter files of the fits; \
those are kept, and only new recordings are fitted next time. A recording that cannot be fitted is left out, and the page says why.")]
pub struct Args {
    /// Folder with recordings
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Where to write [default: FOLDER/trends]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Rig description (TOML) of all recordings [default: the copy that each carries]
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// Model
    #[arg(long, value_enum, default_value_t = ModelArg(ModelKind::Nonlinear))]
    model: ModelArg,
    /// Channels to use, as in b0c0,b0c1 [default: all]
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    channels: Vec<ChannelId>,
    /// Number of starts of each fit
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    starts: u32,
}

/// A recording of the folder.
#[derive(Serialize)]
struct Used {
    file: String,
    sha256: String,
    recorded: String,
    /// Where the day comes from: the recording itself, or the file's last change.
    dated_by: &'static str,
    parameters: String,
}

#[derive(Serialize)]
struct Output<'a> {
    schema: &'static str,
    recordings: &'a [Used],
    left_out: &'a [String],
    trends: &'a [Trend],
}

impl Args {
    pub fn run(self) -> Result<(), Failure> {
        let rig = self.rig.as_deref().map(Rig::load).transpose()?;
        let files = recordings(&self.folder)?;
        let out = self.out.clone().unwrap_or_else(|| self.folder.join("trends"));
        let fits = out.join("fits");
        target::folder("--out", &fits, &[], &[])?;
        output::folder(&fits)?;
        let cancel = interrupt::watch()?;
        let (mut calibrations, mut used, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
        for file in &files {
            match self.calibration(file, rig.as_ref(), &fits, cancel) {
                Ok((calibration, about)) => {
                    calibrations.push(calibration);
                    used.push(about);
                }
                Err(why) => {
                    // Messages of readers begin with the file's name.
                    let name = file.display().to_string();
                    let text = why.to_string();
                    let text = if text.starts_with(&name) { text } else { format!("{name}: {text}") };
                    errln!("left out: {text}");
                    left_out.push(text);
                }
            }
            interrupt::check("the parameter files so far")?;
        }
        if calibrations.is_empty() {
            return Err(Failure::input(format!(
                "none of the {} recordings in {} could be fitted; the reasons are above",
                files.len(),
                self.folder.display()
            )));
        }
        let found = trends(&calibrations);
        let from = origin::origin();
        let footer = format!("{} | {} | {}", from.program, from.created, from.command);
        let title = format!("Trends of {}", self.folder.display());
        let (html, json) = (out.join("trends.html"), out.join("trends.json"));
        write::text_atomically(&html, &trends_page(&title, &found, &left_out, &footer)?)?;
        let content =
            Output { schema: "pneudrive-trends/1", recordings: &used, left_out: &left_out, trends: &found };
        output::json(&json, &content)?;
        changes(&found).iter().for_each(|sentence| outln!("{sentence}"));
        outln!("{}\nwrote {} and {}", conclusion(&found), html.display(), json.display());
        Ok(())
    }

    /// What was fitted to a recording, now or in an earlier run.
    fn calibration(
        &self,
        path: &Path,
        rig: Option<&Rig>,
        fits: &Path,
        cancel: &'static std::sync::atomic::AtomicBool,
    ) -> Result<(Calibration, Used), Failure> {
        let rig = match (rig, rig_copy(path)?) {
            (Some(rig), _) => rig.clone(),
            (None, Some(text)) => {
                Rig::parse(&format!("{}, its copy of the rig file", path.display()), &text)?
            }
            (None, None) => Rig::default(),
        };
        let limits = |channel| rig.sensor_limits(channel);
        let channels = (!self.channels.is_empty()).then_some(&self.channels[..]);
        let options = LoadOptions { channels, limits: Some(&limits), ..LoadOptions::default() };
        let recording = load(path, options)?.recording;
        let (unix_s, dated_by) = recorded(path)?;
        let kept = fits.join(format!("{}.toml", &recording.source.sha256[..16]));
        let parameters = match ParameterFile::load(&kept) {
            Ok(file) if self.is_fit_of(&file, &recording, &rig) => file,
            _ => self.fitted(&recording, &rig, cancel)?,
        };
        parameters.save(&kept)?;
        let Source { file, sha256, .. } = recording.source;
        let used = Used {
            file,
            sha256,
            recorded: TimeScale::Days.said(unix_s),
            dated_by,
            parameters: kept.display().to_string(),
        };
        Ok((Calibration { unix_s, parameters }, used))
    }

    fn settings(&self) -> FitSettings {
        FitSettings {
            model: self.model.0,
            fit: FitOptions { starts: self.starts as usize, ..FitOptions::default() },
            ..FitSettings::default()
        }
    }

    /// Whether a parameter file holds what would be fitted.
    fn is_fit_of(&self, file: &ParameterFile, recording: &Recording, rig: &Rig) -> bool {
        let channels = recording.channels.iter().map(|channel| channel.id);
        !file.settings.stopped
            && file.provenance.data.sha256 == recording.source.sha256
            && file.settings.starts == self.starts as usize
            && file.rig == *rig
            && file.channels.keys().copied().eq(channels)
            && file.channels.values().all(|channel| channel.setup.model == self.model.0)
    }

    fn fitted(
        &self,
        recording: &Recording,
        rig: &Rig,
        cancel: &'static std::sync::atomic::AtomicBool,
    ) -> Result<ParameterFile, Failure> {
        let settings = self.settings();
        let name = &recording.source.file;
        let bar = FitBar::new(format!("{name}: fitting {} channel(s)", recording.channels.len()));
        let progress = |p| bar.set(p);
        let fitted = fit_channels(recording, rig, &settings, Control { progress: &progress, cancel });
        bar.finish();
        let fitted = fitted?;
        let mut file = ParameterFile::of(recording, rig, &settings, &fitted)?;
        file.provenance = origin::provenance(&recording.source, self.rig.as_deref());
        file.settings.stopped = cancel.load(std::sync::atomic::Ordering::SeqCst);
        Ok(file)
    }
}

/// The recordings of a folder, in the order of their names.
fn recordings(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    const ENDINGS: [&str; 4] = [".csv", ".csv.gz", ".csv.zst", ".mcap"];
    let failed = |error: std::io::Error| Failure::input(format!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        // A bag may be a folder with one file of its name.
        let within = path.join(&name);
        let file = if path.is_dir() && within.is_file() { within } else { path };
        if file.is_file() && ENDINGS.iter().any(|ending| name.ends_with(ending)) {
            files.push(file);
        }
    }
    files.sort();
    if files.is_empty() {
        return Err(Failure::input(format!(
            "{}: no recordings in it: expected files that end in {}",
            folder.display(),
            ENDINGS.join(", ")
        )));
    }
    Ok(files)
}

/// When a recording was made, s since 1970, and how that is known.
fn recorded(path: &Path) -> Result<(f64, &'static str), Failure> {
    let says = created_utc(path)?.and_then(|text| humantime::parse_rfc3339_weak(&text).ok());
    let (time, by) = match says {
        Some(time) => (time, "recording"),
        None => {
            let changed = std::fs::metadata(path).and_then(|about| about.modified());
            let failed = |error| Failure::input(format!("{}: its date: {error}", path.display()));
            (changed.map_err(failed)?, "file")
        }
    };
    Ok((time.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64(), by))
}
