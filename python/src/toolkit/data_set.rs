//! Data sets of the truth plant: `pneudrive_py.sim.record`.

use super::work::{self, Watch};
use crate::errors::{self, FileError};
use clap::ValueEnum;
use pneudrive_sim::plant::{Effect, PlantParameters};
use pneudrive_sim::record::{BoardKind, Excitation, RecordArgs, RecordError};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

/// Writes a recording of the truth plant and the rig's description; returns the number of rows. See
/// ``pneudrive_py.sim.record``.
#[pyfunction]
#[pyo3(name = "_record", signature = (out, rig_out, *, seconds, rate_hz, channels, excitation, range_kpa, effects, realistic, drive, open_loop, joints, supply, seed))]
#[allow(clippy::too_many_arguments)] // keywords of the Python function
pub fn record_data_set(
    py: Python<'_>,
    out: PathBuf,
    rig_out: PathBuf,
    seconds: f64,
    rate_hz: f64,
    channels: usize,
    excitation: &str,
    range_kpa: (f64, f64),
    effects: Vec<String>,
    realistic: bool,
    drive: bool,
    open_loop: Option<f64>,
    joints: bool,
    supply: bool,
    seed: u64,
) -> PyResult<u64> {
    let excitation = Excitation::from_str(excitation, false).map_err(|_| {
        let words = Excitation::value_variants().iter().filter_map(|one| one.to_possible_value());
        let words: Vec<String> = words.map(|word| format!("{:?}", word.get_name())).collect();
        errors::unusable(format!("excitation is {excitation:?}; it must be {}", words.join(" or ")))
    })?;
    if drive && open_loop.is_some() {
        return Err(errors::unusable("give drive or open_loop, not both"));
    }
    let effects = effects
        .iter()
        .map(|text| text.parse::<Effect>().map_err(|error| errors::unusable(format!("effects: {error}"))));
    let usual = pneudrive_sim::record::ControlSettings::default();
    let arguments = RecordArgs {
        out,
        rig_out: Some(rig_out),
        // As everything that Python writes.
        overwrite: true,
        seconds,
        rate: rate_hz,
        channels,
        excitation,
        range: vec![range_kpa.0, range_kpa.1],
        effects: effects.collect::<PyResult<_>>()?,
        realistic,
        seed,
        drive,
        open_loop,
        board: BoardKind::Firmware,
        loop_rate: usual.rate_hz,
        kp: usual.kp,
        kd: usual.kd,
        filter: usual.filter,
        joints,
        supply,
        nuisances: false,
        background: false,
        noise: PlantParameters::default().sensor.noise_kpa,
        exact: false,
    };
    let work = move |watch: &Watch| {
        watch.begin("recording");
        arguments.run(|| watch.cancel().load(Ordering::SeqCst))
    };
    work::run(py, None, work)?.map_err(|error| match &error {
        RecordError::Write { .. } | RecordError::NotCreated { .. } => FileError::new_err(error.to_string()),
        _ => errors::unusable(error),
    })
}
