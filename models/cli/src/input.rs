//! Arguments that name the recording and the rig, and loading both.

use std::path::{Path, PathBuf};

use pneudrive_model::data::{ChannelId, LoadOptions, Loaded, load, rig_copy};
use pneudrive_model::diagnosis::ExtendedFile;
use pneudrive_model::rig::Rig;
use pneudrive_model::simulation::CalibratedModel;

use super::Failure;
use super::file_kind::FileKind;
use super::print::errln;
use super::progress::LoadingBar;

/// The recording and the rig it was made with.
#[derive(Debug, clap::Args)]
pub struct DataArgs {
    /// Recording: CSV, plain or compressed with gzip or zstd, or MCAP (a ROS 2 bag)
    #[arg(value_name = "DATA")]
    pub data: PathBuf,
    /// Rig description (TOML) [default: the copy that DATA carries; without either only the linear
    /// model can be used]
    #[arg(long, value_name = "RIG.toml")]
    pub rig: Option<PathBuf>,
    /// Channels to use, as in b0c0,b0c1 [default: all]
    #[arg(long, value_name = "CHANNELS", value_delimiter = ',')]
    pub channels: Vec<ChannelId>,
}

impl DataArgs {
    /// Files that are read.
    pub fn files(&self) -> Vec<&Path> {
        std::iter::once(&self.data).chain(&self.rig).map(PathBuf::as_path).collect()
    }

    /// The rig, or an empty description.
    pub fn load_rig(&self) -> Result<Rig, Failure> {
        rig(self.rig.as_deref(), &self.data)
    }

    /// Reads and checks the recording, and says on standard error what was found in it.
    pub fn load(&self, rig: &Rig) -> Result<Loaded, Failure> {
        recording(&self.data, &self.channels, rig)
    }
}

/// The rig: that of the file at `path`, else that of which the recording carries a copy, else an
/// empty description.
pub fn rig(path: Option<&Path>, recording: &Path) -> Result<Rig, Failure> {
    shared_rig(path, &[recording])
}

/// The rig of several recordings: that of the file at `path`, else that of which they carry copies,
/// which have to agree, else an empty description.
pub fn shared_rig(path: Option<&Path>, recordings: &[&Path]) -> Result<Rig, Failure> {
    if let Some(path) = path {
        return Rig::load(path).map_err(|error| FileKind::Rig.refused(path, error));
    }
    let mut first: Option<(&Path, Rig)> = None;
    for &recording in recordings {
        let Some(text) = rig_copy(recording)? else { continue };
        let own = Rig::parse(&format!("{}, its copy of the rig file", recording.display()), &text)?;
        match &first {
            None => first = Some((recording, own)),
            Some((from, rig)) => {
                let differences = rig.differences(&own).join(", ");
                if !differences.is_empty() {
                    return Err(Failure::input(format!(
                        "{} and {} were recorded with rig files that say different things: {differences}; say with --rig what holds for all recordings, or take each alone",
                        from.display(),
                        recording.display(),
                    )));
                }
            }
        }
    }
    let Some((from, rig)) = first else { return Ok(Rig::default()) };
    errln!("{}: taken with its copy of the rig file (--rig takes another)", from.display());
    Ok(rig)
}

/// Reads and checks a recording, and says on standard error what was found in it. No `channels`
/// means all.
pub fn recording(data: &Path, channels: &[ChannelId], rig: &Rig) -> Result<Loaded, Failure> {
    let bar = LoadingBar::new(data);
    let mut progress = |done: u64, size: u64| bar.set(done, size);
    let channels = (!channels.is_empty()).then_some(channels);
    let limits = |channel| rig.sensor_limits(channel);
    let loaded = load(
        data,
        LoadOptions {
            channels,
            limits: Some(&limits),
            supply_kpa: rig.supply_kpa(),
            progress: Some(&mut progress),
        },
    )
    .map_err(|error| FileKind::Recording.refused(data, error))?;
    bar.finish();
    errln!(
        "{}: {} rows, {:.2} s, {} channel(s)",
        data.display(),
        loaded.recording.rows(),
        loaded.recording.duration_s(),
        loaded.recording.channels.len()
    );
    for sentence in loaded.quality.sentences() {
        errln!("  {sentence}");
    }
    Ok(loaded)
}

/// What `fit` or `diagnose` saved.
pub fn calibrated(path: &Path) -> Result<CalibratedModel, Failure> {
    let model = CalibratedModel::load(path).map_err(|error| FileKind::Parameters.refused(path, error))?;
    warn_of_stopped_fit(path);
    Ok(model)
}

/// What `diagnose` saved.
pub fn extended(path: &Path) -> Result<ExtendedFile, Failure> {
    let file = ExtendedFile::load(path)
        .map_err(|error| FileKind::Parameters.refused(path, Failure::input(error)))?;
    warn_of_stopped_fit(path);
    Ok(file)
}

/// Says of a parameter file that its fit was stopped before it ended: nothing else in its use would
/// show that. Whether the file can be used is said by who loads it.
fn warn_of_stopped_fit(file: &Path) {
    let table = std::fs::read_to_string(file).ok().and_then(|text| text.parse::<toml::Table>().ok());
    let stopped = table.and_then(|table| table.get("settings")?.get("stopped")?.as_bool());
    if stopped == Some(true) {
        errln!("warning: {}: its fit was stopped before it ended; parameters may be far off", file.display());
    }
}
