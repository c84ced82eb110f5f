//! One recording by the truth plant, with what is hidden in it.

use std::path::Path;

use pneudrive_sim::plant::{Background, Effect, Nuisances};
use pneudrive_sim::record::{Columns, Loop, Recorder, RecordingSettings, rig_toml, write_csv};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use system_tests::blind::plan::{Case, Hard, SHORT_CHANNELS, SHORT_S};

use super::Result;

/// How much is recorded of a round that is not hard.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Length, s.
    pub seconds: f64,
    /// Channels of the board.
    pub channels: usize,
}

impl Extent {
    /// As the table's.
    pub const SHORT: Self = Self { seconds: SHORT_S, channels: SHORT_CHANNELS };
}

impl Default for Extent {
    /// As the published rounds.
    fn default() -> Self {
        Self { seconds: 220.0, channels: RecordingSettings::default().plant.channels }
    }
}

/// Writes `run.csv`, `rig.toml` and `truth.json`, of a rig in a laboratory.
pub fn record(folder: &Path, case: &Case, extent: Extent) -> Result<()> {
    record_in(Nuisances::laboratory(), folder, case, extent)
}

/// The same of a rig with these imperfections.
pub fn record_in(nuisances: Nuisances, folder: &Path, case: &Case, extent: Extent) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    let defaults = RecordingSettings::default();
    let mut plant = defaults.plant.clone();
    plant.channels = extent.channels;
    plant.nuisances = nuisances;
    if case.hard.is_some() {
        plant.nuisances.background = Background::typical();
    }
    let (seconds, rate_hz) = case.hard.as_ref().map_or((extent.seconds, 100.0), |h| (h.seconds, h.rate_hz));
    let effects =
        case.arguments.iter().map(|text| text.parse()).collect::<std::result::Result<Vec<Effect>, _>>()?;
    let mut settings = RecordingSettings {
        plant,
        effects,
        seed: case.seed,
        seconds,
        rate_hz,
        control_loop: if case.drive { Loop::Row } else { defaults.control_loop },
        columns: Columns { drive: case.drive, ..Columns::default() },
        ..defaults
    };
    let mut clock = Pcg64Mcg::seed_from_u64(case.seed);
    let jitter_s = case.hard.as_ref().map_or(0.0, |hard| hard.jitter / hard.rate_hz);
    // A background's tubes can be too short for the usual step.
    let recorder = Recorder::new(&settings).or_else(|_| {
        settings.plant.step_ns /= 2;
        Recorder::new(&settings)
    })?;
    let rows = recorder.map(|mut row| {
        row.t_s += jitter_s * (2.0 * clock.random::<f64>() - 1.0);
        row
    });
    write_csv(&folder.join("run.csv"), settings.plant.channels, settings.columns, rows)?;
    std::fs::write(folder.join("rig.toml"), rig_toml(&case.hard.iter().fold(settings, stated))?)?;
    std::fs::write(folder.join("truth.json"), serde_json::to_string_pretty(case)?)?;
    Ok(())
}

/// What the rig's user believes.
fn stated(mut settings: RecordingSettings, hard: &Hard) -> RecordingSettings {
    settings.plant.chamber.radius_m *= hard.stated_volume.sqrt();
    settings.plant.supply.pressure_kpa *= hard.stated_supply;
    settings
}
