//! For tests: a channel, twenty seconds of steps, measured by its own simulation; causes, reports.

use std::collections::BTreeMap;

use rand::RngExt;

use crate::board::Law;
use crate::data::ChannelId;
use crate::diagnosis::channel::{ChannelData, Extended, compared_rows, split};
use crate::diagnosis::estimation::{ChannelStage, refit};
use crate::diagnosis::json::{Cause, Estimate, Gain, Report, SCHEMA, Verdict};
use crate::diagnosis::likelihood::Whitening;
use crate::diagnosis::resampling::generator;
use crate::diagnosis::screening::Asked;
use crate::effects::catalogue::index_of;
use crate::effects::{BoardLoop, ChannelInputs, DriveInput, Plant, Question, Series};
use crate::model::{BaseModel, Nonlinear};

const AMBIENT_PA: f64 = 101_325.0;
const ROWS: usize = 2000;

/// What is missing, of the whole catalogue.
pub const STRUCTURE: Asked<'_> = Asked { question: Question::Structure, only: &[] };

/// Base parameters of its valve: leaks, gain, edges, corner, weight of the volume's rate.
const BASE: [f64; 7] = [0.002, 0.002, 0.7, 0.02, -0.02, 0.02, 1.0];

/// Behind a valve whose drive was recorded, or behind a board that follows commands; the simulation
/// of the base model is what was measured.
pub fn channel(in_loop: bool) -> (ChannelData, Extended) {
    channel_of(ROWS, in_loop)
}

/// The same of so many rows, a hundred a second.
pub fn channel_of(rows: usize, in_loop: bool) -> (ChannelData, Extended) {
    let every = |value: f64| -> Series { vec![value; rows].into() };
    let command = |row: usize| [150e3, 240e3, 90e3, 200e3][row / 170 % 4] + AMBIENT_PA;
    let drive = |row: usize| [0.3, -0.2, 0.05, 0.5, -0.6][row / 40 % 5] + 0.1 * (0.05 * row as f64).sin();
    let inputs = ChannelInputs {
        time_s: (0..rows).map(|k| 0.01 * k as f64).collect(),
        interval_s: every(0.01),
        duration_s: 0.01 * (rows - 1) as f64,
        starts: [0].into(),
        anchors: [].into(),
        drive: if in_loop {
            DriveInput::Controlled
        } else {
            DriveInput::Spool((0..rows).map(drive).collect())
        },
        command_pa: (0..rows).map(command).collect(),
        supply_pa: every(650e3),
        volume_m3: every(3e-4),
        volume_rate_m3_s: every(0.0),
        measured_pa: every(150e3 + AMBIENT_PA),
        usable: vec![true; rows].into(),
        opposite_pa: (0..rows).map(|k| 1e4 * (0.03 * k as f64).sin()).collect(),
        sampled_before_pa: (0..rows).map(|k| 2e4 * (0.02 * k as f64).cos()).collect(),
        neighbour_drive: (0..rows).map(|k| 0.5 * (0.07 * k as f64).sin()).collect(),
        others_draw: (0..rows).map(|k| 1e4 * (1.0 + (0.05 * k as f64).sin())).collect(),
        noise_pa: 300.0,
        ambient_pa: AMBIENT_PA,
    };
    let plant = Plant {
        model: BaseModel::Nonlinear(Nonlinear::default()),
        board: Some(BoardLoop {
            rate_hz: 1000.0,
            law: Law { gain: 3e-5, damping: 6e-5, weight: 0.8 },
            lowest_pa: -86e3,
            highest_pa: 775e3,
            rounding_pa: 240.0,
            loops_per_step: 2,
            noise_draw: 0,
        }),
        longest_step_s: 0.01,
        command_range_pa: 3e5,
    };
    let blocks = split(&inputs);
    let (rows, spans) = compared_rows(&inputs, &blocks);
    let mut data = ChannelData {
        id: ChannelId { board: 0, channel: 0 },
        plant,
        inputs,
        blocks,
        rows,
        spans,
        measured_kpa: Series::default(),
        noise_kpa: 0.3,
    };
    let model = Extended::base(BASE.to_vec());
    data.measured_kpa = data.readings(&model).into();
    (data, model)
}

/// The model with an effect of the catalogue.
pub fn with(data: &ChannelData, model: &Extended, id: &str, values: &[f64]) -> Extended {
    model.with(&data.plant, index_of(id).unwrap(), values)
}

/// The channel as if a model had been measured, with noise of the size that the channel is said to
/// have.
pub fn measured(mut data: ChannelData, model: &Extended, seed: u64) -> ChannelData {
    let noise = normals(seed, data.rows.len());
    let readings = data.readings(model);
    data.measured_kpa = readings.iter().zip(noise).map(|(y, n)| y + data.noise_kpa * n).collect();
    data
}

/// The channel with readings of which every fifth repeats the one before it, up and down a ramp:
/// rows that show stale samples, whatever the simulation says.
pub fn with_repeated_readings(mut data: ChannelData) -> ChannelData {
    let ramp = |row: usize| 2e3 * (row % 200).abs_diff(100) as f64 + AMBIENT_PA;
    let last_sampled = |row: usize| if row % 5 == 4 { row - 1 } else { row };
    data.inputs.measured_pa = (0..data.inputs.rows()).map(|row| ramp(last_sampled(row))).collect();
    data
}

/// A base model fitted to what was measured, from where it stands.
pub fn fitted(data: &ChannelData, base: &Extended) -> ChannelStage {
    let free: Vec<usize> = (0..base.values.len()).collect();
    let whitening = Whitening::new(data, &data.disturbances(base));
    let (model, _) = refit(data, &whitening, base, &free, 40);
    ChannelStage::new(data, model, free)
}

/// Standard normal numbers, by Box and Muller.
pub fn normals(seed: u64, count: usize) -> Vec<f64> {
    let mut rng = generator(1000 + seed);
    let normal = |_| {
        let (a, b): (f64, f64) = (rng.random(), rng.random());
        (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    };
    (0..count).map(normal).collect()
}

/// A cause on one channel that takes this part of an error of 2 kPa, without sizes and without a
/// probability.
pub fn cause(effect: &str, gain: f64) -> Cause {
    Cause {
        effect: effect.to_owned(),
        channels: vec!["b0c0".to_owned()],
        equivalent: Vec::new(),
        parameters: BTreeMap::new(),
        by_channel: BTreeMap::new(),
        p_value: 0.001,
        probability: None,
        gain: Gain {
            test_rmse_before_kpa: 2.0,
            test_rmse_after_kpa: 2.0 * (1.0 - gain),
            reduction: gain,
            ci95: [gain - 0.2, gain + 0.2],
            weighted_ci95: [0.0; 2],
        },
    }
}

/// A report without causes, with the errors on the test blocks of the base model and of the
/// extended one, kPa, where the noise is 0.3 kPa and what is allowed 0.5.
pub fn report(verdict: Verdict, [before, after]: [f64; 2]) -> Report {
    let value = serde_json::json!({
        "schema": SCHEMA,
        "data": { "file": "run.csv", "rows": 6000, "rate_hz": 100.0, "seconds": 60.0 },
        "verdict": verdict,
        "sentence": "",
        "baseline": { "model": "valve", "test_rmse_kpa": before, "noise_floor_kpa": 0.3, "channels": {} },
        "symptoms": [],
        "causes": [],
        "unexplained": { "share": 0.0, "test_rmse_kpa": after, "depends_on": [], "correction": null },
        "next_experiment": null,
        "extended_model": null,
        "notes": [],
        "checks": {
            "allowed_rmse_kpa": 0.5, "halved_step_rms_kpa": 0.0, "blocks": [6, 3, 3], "block_s": 5.0
        },
    });
    serde_json::from_value(value).expect("it is a whole report")
}

/// A cause with a size and its interval, in the middle of which the size is.
pub fn sized(effect: &str, parameter: &str, ci95: [f64; 2]) -> Cause {
    let estimate = Estimate {
        value: 0.5 * (ci95[0] + ci95[1]),
        ci95: Some(ci95),
        unit: "1".to_owned(),
        state: "identified".to_owned(),
    };
    Cause { parameters: [(parameter.to_owned(), estimate)].into(), ..cause(effect, 0.5) }
}
