//! A virtual rig with a laboratory's imperfections: its rows, and what `fit` makes of its first
//! minutes.

use std::path::Path;

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::diagnosis::ExtendedFile;
use pneudrive_model::experiment::{FitSettings, fit_channels};
use pneudrive_model::fit::Control;
use pneudrive_model::rig::Rig;
use pneudrive_model::store::ParameterFile;
use pneudrive_model::watch::{Columns, Reading, Sample, WatchEvent, WatchSettings, Watcher};
use pneudrive_sim::plant::{Background, Effect, Nuisances, PlantParameters};
use pneudrive_sim::record::{Loop, Recorder, RecordingSettings, Row, rig_toml, write_csv};

/// Length of the recording that the model is calibrated on, s.
const CALIBRATION_S: f64 = 120.0;
/// Starts of each fit.
const STARTS: usize = 4;
/// Integration step of the plant, ns: a little longer than usual, since days are simulated.
pub const STEP_NS: u64 = 62_500;
/// The same for a narrow tube, or one through which gas flows faster: they are quicker than that.
pub const TUBE_STEP_NS: u64 = 12_500;

/// What rigs are like and how they are recorded.
#[derive(Clone, Copy)]
pub struct Kind {
    /// Channels.
    pub channels: usize,
    /// Rows a second, Hz.
    pub rate_hz: f64,
    /// Is the drive recorded? Else the board's loop is simulated from commands.
    pub drive: bool,
    /// Integration step of the plant where drives are recorded, ns.
    pub step_ns: u64,
}

impl Kind {
    fn settings(self, seed: u64, seconds: f64) -> RecordingSettings {
        let mut plant = PlantParameters { channels: self.channels, ..PlantParameters::default() };
        plant.nuisances = Nuisances::laboratory();
        plant.nuisances.background = Background::typical();
        let mut settings =
            RecordingSettings { plant, seed, seconds, rate_hz: self.rate_hz, ..RecordingSettings::default() };
        if self.drive {
            settings.plant.step_ns = self.step_ns;
            settings.control_loop = Loop::Row;
            settings.columns.drive = true;
        }
        settings
    }

    /// The rows of a rig, with faults of it if there are any.
    pub fn rows(self, seed: u64, seconds: f64, faults: &[Effect]) -> Recorder {
        let mut settings = self.settings(seed, seconds);
        settings.effects = faults.to_vec();
        Recorder::new(&settings).expect("settings of this program")
    }

    /// What `fit` makes of the rig's first minutes.
    pub fn calibrated(self, seed: u64, folder: &Path) -> ExtendedFile {
        let settings = self.settings(seed, CALIBRATION_S);
        let nominal = Rig::parse("rig.toml", &rig_toml(&settings).expect("a rig")).expect("a rig file");
        let csv = folder.join(format!("{seed}.csv"));
        let recorder = Recorder::new(&settings).expect("settings of this program");
        write_csv(&csv, self.channels, settings.columns, recorder).expect("the folder can be written");
        let limits = |channel| nominal.sensor_limits(channel);
        let recording = load(&csv, LoadOptions { limits: Some(&limits), ..LoadOptions::default() })
            .expect("a recording")
            .recording;
        let mut how = FitSettings::default();
        how.fit.starts = STARTS;
        let fitted = fit_channels(&recording, &nominal, &how, Control::none()).expect("a fit");
        let parameters = ParameterFile::of(&recording, &nominal, &how, &fitted).expect("of this recording");
        let toml = folder.join(format!("{seed}.toml"));
        parameters.save(&toml).expect("the folder can be written");
        ExtendedFile::load(&toml).expect("what was just written")
    }

    /// A watcher of such a rig.
    pub fn watcher(self, model: &ExtendedFile, settings: WatchSettings) -> Watcher {
        let one = |id: &String| Columns {
            id: id.parse().expect("a channel"),
            command: true,
            spool: self.drive,
            separate: false,
            angle: false,
        };
        let columns = model.channels.keys().map(one).collect();
        Watcher::new(("calibrated", model), columns, settings).expect("a model of these channels")
    }

    /// A row as a watcher takes it.
    pub fn sample(self, row: &Row) -> Sample {
        let channel = |k: usize| Reading {
            pressure_kpa: row.pressure_kpa[k],
            command_kpa: row.command_kpa[k],
            drive: if self.drive { row.drive[k] } else { f64::NAN },
            ..Reading::default()
        };
        Sample { t_s: row.t_s, supply_kpa: f64::NAN, channels: (0..self.channels).map(channel).collect() }
    }
}

/// Shows rows to a watcher until it says that something has changed, at the longest to the end.
pub fn first_change(
    kind: Kind,
    watcher: &mut Watcher,
    rows: impl Iterator<Item = Row>,
) -> Option<pneudrive_model::watch::Change> {
    for row in rows {
        let mut change = None;
        watcher.take(kind.sample(&row), &mut |event| {
            if let WatchEvent::Changed(found) = event {
                change.get_or_insert(found);
            }
        });
        if change.is_some() {
            return change;
        }
    }
    None
}
