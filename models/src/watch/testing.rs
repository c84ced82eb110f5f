//! A rig for tests: one valve and chamber, moved by random drives, measured with noise by its own
//! simulation.

use std::collections::BTreeMap;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::bank::Bank;
use super::observer::Observer;
use super::sample::{Columns, Reading, Sample};
use super::setup::{Prepared, prepare};
use super::window::{StepInputs, Window};
use crate::diagnosis::{EXTENDED_SCHEMA, ExtendedChannel, ExtendedFile};
use crate::effects::catalogue::index_of;
use crate::rig::Rig;

/// Channel b0c0, whose drive is recorded.
pub fn columns() -> Columns {
    let id = "b0c0".parse().expect("a channel");
    Columns { id, command: false, spool: true, separate: false, angle: false }
}

/// Its calibrated model.
pub fn calibrated() -> ExtendedFile {
    let rig = "[supply]\npressure_kpa = 550\n[chamber]\nvolume_m3 = 3e-4\n[valve]\ncritical_ratio = 0.3\n";
    let names = ["leak_in", "leak_out", "gain", "threshold_in", "threshold_out", "corner", "volume_weight"];
    let mut file = ExtendedFile {
        schema: EXTENDED_SCHEMA.to_owned(),
        model: "nonlinear".to_owned(),
        provenance: None,
        rig: Rig::parse("rig.toml", rig).expect("a rig file"),
        channels: BTreeMap::new(),
    };
    let values = [0.002, 0.002, 0.7, 0.02, -0.02, 0.02, 1.0];
    file.channels.insert(
        "b0c0".to_owned(),
        ExtendedChannel {
            drive: "spool".to_owned(),
            noise_kpa: 0.3,
            command_range_kpa: 300.0,
            parameters: names.map(str::to_owned).into_iter().zip(values).collect(),
            effects: BTreeMap::new(),
            correction: None,
            band: None,
        },
    );
    file
}

/// The channel as a watcher sets it up.
pub fn prepared() -> Prepared {
    let file = calibrated();
    prepare(("calibrated", &file), &file.channels["b0c0"], columns()).expect("a model of this channel")
}

/// Its observers.
pub fn bank() -> Bank {
    Bank::new(&prepared())
}

/// Rows of the rig from a time on (s), 100 a second, with an effect of the catalogue from another
/// time on.
pub fn rows(seconds: f64, effect: &'static str, size: f64, from_s: f64, seed: u64) -> Vec<Sample> {
    let Prepared { data, model, .. } = prepared();
    let mut window = Window::new(&data.inputs);
    let index = index_of(effect).expect("an effect of the catalogue");
    let changed = model.with(&data.plant, index, &[size]);
    let mut rig = Observer::new(&data.plant, &model, &window);
    let mut other = Observer::new(&data.plant, &changed, &window);
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let ambient_pa = data.inputs.ambient_pa;
    let (mut gauge_pa, mut drive, mut left) = (150e3, 0.0, 0);
    let mut samples = Vec::new();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a few thousand
    let count = (100.0 * seconds) as usize;
    for row in 0..count {
        let t_s = 0.01 * row as f64;
        if left == 0 {
            left = rng.random_range(5..80);
            let back = if gauge_pa > 300e3 {
                -1.0
            } else if gauge_pa < 60e3 {
                1.0
            } else {
                0.0
            };
            let any: f64 = rng.random_range(-0.5..0.5);
            drive = if back == 0.0 { any } else { back * any.abs() };
        }
        left -= 1;
        // Twelve even numbers have unit variance and nearly a normal distribution.
        let noise: f64 = (0..12).map(|_| rng.random_range(-0.5..0.5)).sum();
        let reading = Reading { pressure_kpa: 1e-3 * gauge_pa + 0.3 * noise, drive, ..Reading::default() };
        samples.push(Sample { t_s, supply_kpa: f64::NAN, channels: vec![reading] });
        let inputs = StepInputs {
            t_s,
            length_s: 0.01,
            drive: [drive, 0.0],
            command_pa: ambient_pa,
            supply_pa: data.inputs.supply_pa[0],
            volume_m3: data.inputs.volume_m3[0],
            volume_rate_m3_s: 0.0,
            measured_pa: [ambient_pa + gauge_pa; 2],
            opposite_pa: [f64::NAN; 2],
            sampled_before_pa: [f64::NAN; 2],
            others_draw: 0.0,
        };
        window.set(&inputs, row == 0);
        if row == 0 {
            rig.start(&data.plant, &window);
        }
        if (t_s - from_s).abs() < 0.005 {
            window.set(&inputs, true);
            other.start(&data.plant, &window);
        }
        let now = if t_s + 0.005 < from_s { &mut rig } else { &mut other };
        gauge_pa = now.advance(&data.plant, &window).0;
    }
    samples
}
