//! One recording by the truth plant, with what is hidden in it.

use std::path::Path;

use pneudrive_sim::plant::{Effect, Nuisances};
use pneudrive_sim::record::{Columns, Loop, Recorder, RecordingSettings, rig_toml, write_csv};
use system_tests::blind::plan::Case;

use super::Result;

/// How much is recorded.
#[derive(Debug, Clone, Copy)]
pub struct Extent {
    /// Length, s.
    pub seconds: f64,
    /// Channels of the board.
    pub channels: usize,
}

impl Default for Extent {
    /// As the published rounds.
    fn default() -> Self {
        Self { seconds: 220.0, channels: RecordingSettings::default().plant.channels }
    }
}

/// Writes `run.csv`, `rig.toml` and `truth.json`.
pub fn record(folder: &Path, case: &Case, extent: Extent) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    let defaults = RecordingSettings::default();
    let mut plant = defaults.plant.clone();
    plant.channels = extent.channels;
    plant.nuisances = Nuisances::laboratory();
    let effects =
        case.arguments.iter().map(|text| text.parse()).collect::<std::result::Result<Vec<Effect>, _>>()?;
    let settings = RecordingSettings {
        plant,
        effects,
        seed: case.seed,
        seconds: extent.seconds,
        rate_hz: 100.0,
        control_loop: if case.drive { Loop::Row } else { defaults.control_loop },
        columns: Columns { drive: case.drive, ..Columns::default() },
        ..defaults
    };
    write_csv(&folder.join("run.csv"), settings.plant.channels, settings.columns, Recorder::new(&settings)?)?;
    std::fs::write(folder.join("rig.toml"), rig_toml(&settings)?)?;
    std::fs::write(folder.join("truth.json"), serde_json::to_string_pretty(case)?)?;
    Ok(())
}
