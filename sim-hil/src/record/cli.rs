//! `pneudrive-sim record`: a recording from the command line.

use std::path::{Path, PathBuf};

use crate::plant::{Background, Effect, Nuisances, PlantParameters};

use super::{
    BoardKind, Columns, ControlSettings, Excitation, Loop, RecordError, Recorder, RecordingSettings,
    csv::write_csv_until, rig_toml,
};

/// Record the truth plant without a bus: the measured-data CSV a host would have written.
#[derive(Debug, Clone, clap::Args)]
pub struct RecordArgs {
    /// File to write: .csv, .csv.gz or .csv.zst
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Also write the nominal rig description (TOML) that goes with it
    #[arg(long, value_name = "FILE")]
    pub rig_out: Option<PathBuf>,
    /// Replace the files of --out and --rig-out if they exist
    #[arg(long)]
    pub overwrite: bool,
    /// Length, s
    #[arg(long, default_value_t = 220.0)]
    pub seconds: f64,
    /// Rows a second, 1 to 1000
    #[arg(long, default_value_t = 100.0)]
    pub rate: f64,
    /// How many channels, four to a board
    #[arg(long, value_name = "COUNT", default_value_t = 4)]
    pub channels: usize,
    /// What the set points do
    #[arg(long, value_enum, default_value = "mixed")]
    pub excitation: Excitation,
    /// Lowest and highest set point, kPa gauge
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"], default_values_t = [50.0, 300.0])]
    pub range: Vec<f64>,
    /// Switch an effect on: id, id=value or id:name=value,name=value, each with an optional @b0 or
    /// @b0c2; repeatable
    #[arg(long = "effect", value_name = "EFFECT")]
    pub effects: Vec<Effect>,
    /// Add small amounts of what every rig has; an --effect of the same name replaces its share
    #[arg(long)]
    pub realistic: bool,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Close the loop once a row and record the drive it holds until the next row, so that the
    /// plant alone can be simulated
    #[arg(long)]
    pub drive: bool,
    /// Leave the loop open: random drives up to this amplitude, recorded, and no set points
    #[arg(long, value_name = "AMPLITUDE", conflicts_with = "drive")]
    pub open_loop: Option<f64>,
    /// Who runs the control law when the loop is closed on the board
    #[arg(long, value_enum, default_value = "firmware")]
    pub board: BoardKind,
    /// Board loops a second
    #[arg(long, default_value_t = 1000.0)]
    pub loop_rate: f64,
    /// Proportional gain, drive counts per count
    #[arg(long, default_value_t = 10.0)]
    pub kp: f64,
    /// Damping, drive counts per count of change in one loop
    #[arg(long, default_value_t = 0.0)]
    pub kd: f64,
    /// Weight of the previous sample in the board's low-pass, 0 to 1 (the published PneuDrive:
    /// 0.8203125)
    #[arg(long, default_value_t = 0.0)]
    pub filter: f64,
    /// Free the joints and record their angles
    #[arg(long)]
    pub joints: bool,
    /// Record the supply pressure
    #[arg(long)]
    pub supply: bool,
    /// Laboratory nuisances: 1 % supply wander, 5 % spread between channels
    #[arg(long)]
    pub nuisances: bool,
    /// With what every real rig has and no textbook describes: valves' curves and flow functions a
    /// little off, tubes, gas between isothermal and adiabatic, two time scales of supply wander
    #[arg(long)]
    pub background: bool,
    /// Sensor noise before conversion, kPa RMS
    #[arg(long, value_name = "KPA", default_value_t = PlantParameters::default().sensor.noise_kpa)]
    pub noise: f64,
    /// Record the true pressures instead of the sensor's counts
    #[arg(long)]
    pub exact: bool,
}

impl RecordArgs {
    /// The recording the arguments describe.
    #[must_use]
    pub fn settings(&self) -> RecordingSettings {
        let mut plant = PlantParameters { channels: self.channels, ..PlantParameters::default() };
        plant.sensor.noise_kpa = self.noise;
        plant.joint.free = self.joints;
        if self.nuisances {
            plant.nuisances = Nuisances::laboratory();
        }
        if self.background {
            plant.nuisances.background = Background::typical();
        }
        let defaults = RecordingSettings::default();
        RecordingSettings {
            plant,
            effects: self.all_effects(),
            seed: self.seed,
            seconds: self.seconds,
            rate_hz: self.rate,
            excitation: self.excitation,
            range_kpa: [self.range[0], self.range[1]],
            control_loop: match self.open_loop {
                Some(amplitude) => Loop::Open { amplitude },
                None if self.drive => Loop::Row,
                None => defaults.control_loop,
            },
            board: self.board,
            control: ControlSettings {
                rate_hz: self.loop_rate,
                kp: self.kp,
                kd: self.kd,
                filter: self.filter,
                ..defaults.control
            },
            columns: Columns {
                command: self.open_loop.is_none(),
                drive: self.drive || self.open_loop.is_some(),
                joints: self.joints,
                supply: self.supply,
            },
            exact: self.exact,
        }
    }

    fn all_effects(&self) -> Vec<Effect> {
        let mut effects = self.effects.clone();
        if self.realistic {
            let given = |effect: &Effect| self.effects.iter().any(|own| own.id() == effect.id());
            effects.extend(Effect::realistic().into_iter().filter(|effect| !given(effect)));
        }
        effects
    }

    /// Makes the recording, unless `stop` says to give up; returns the number of rows.
    ///
    /// # Errors
    /// Unusable arguments, files that are there already or cannot be written, or it was given up.
    pub fn run(&self, stop: impl Fn() -> bool) -> Result<u64, RecordError> {
        self.check_files()?;
        let settings = self.settings();
        let recorder = Recorder::new(&settings)?;
        let rows = write_csv_until(&self.out, self.channels, settings.columns, recorder, stop)?;
        if let Some(path) = &self.rig_out {
            let text = rig_toml(&settings)?;
            std::fs::write(path, text).map_err(|source| RecordError::Write { path: path.clone(), source })?;
        }
        Ok(rows)
    }

    /// Refuses files before anything is computed for them.
    fn check_files(&self) -> Result<(), RecordError> {
        if let Some(rig) = &self.rig_out
            && place(rig) == place(&self.out)
        {
            return Err(RecordError::SameFile { path: rig.clone() });
        }
        for path in std::iter::once(&self.out).chain(&self.rig_out) {
            if path.exists() && !self.overwrite {
                return Err(RecordError::Exists { path: path.clone() });
            }
            let folder = folder(path);
            if !folder.is_dir() {
                let reason = "there is no such folder".to_owned();
                return Err(RecordError::NotCreated { path: path.clone(), reason });
            }
        }
        Ok(())
    }
}

/// Where it is, by whatever name: the file need not exist yet.
fn place(path: &Path) -> PathBuf {
    let of_folder =
        || folder(path).canonicalize().ok().zip(path.file_name()).map(|(folder, name)| folder.join(name));
    path.canonicalize().ok().or_else(of_folder).unwrap_or_else(|| path.to_owned())
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
