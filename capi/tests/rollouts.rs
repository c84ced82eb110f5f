//! Rollouts of an extended model from inputs in memory: the numbers of `pneudrive-model simulate`,
//! and their derivatives.

use crate::support::{Driven, Neighbours, STEP_S, extended, generator, recording, row_inputs};
use pneudrive_capi::{Control, Inputs};
use pneudrive_model::data::Recording;
use pneudrive_model::diagnosis::{ExtendedFile, ExtendedRollouts};
use pneudrive_model::effects::catalogue::CATALOGUE;
use pneudrive_model::model::column;
use pneudrive_model::rollout::{BatchColumn, BatchError, BatchInputs, BatchResults, BatchUnit, Job};
use pneudrive_model::simulation::{CalibratedModel, SimulationSettings, simulate};

const ROWS: usize = 250;
const START_KPA: f64 = 50.0;
/// Rounding, kPa.
const MOST: f64 = 1e-6;

/// A recording whose pressure begins at [`START_KPA`] and never repeats itself.
fn recorded(seed: u64, driven: Driven, jointed: bool) -> Recording {
    let mut recording = recording(&mut generator(seed), (driven, 1, ROWS), false, jointed);
    recording.channels[0].pressure_kpa = Some((0..ROWS).map(|k| START_KPA as f32 + k as f32).collect());
    recording
}

/// Columns of the inputs, `[column][rollout][row]`.
fn columns(file: &ExtendedFile, recordings: &[Recording]) -> Vec<Vec<f64>> {
    let mut plain = file.clone();
    // Nominal inputs are the same, and no single steps are made with a correction.
    plain.channels.values_mut().for_each(|channel| channel.correction = None);
    let model = CalibratedModel::from(plain);
    let ambient_pa = file.rig.ambient_or_standard().pressure_kpa_abs * 1e3;
    let mut columns = vec![Vec::new(); column::COUNT];
    for recording in recordings {
        let of = &recording.channels[0];
        let nominal =
            *pneudrive_capi::Channel::of(&model, "b0c0", STEP_S, Control::AsCalibrated).unwrap().nominal();
        let supply = |supply: &[f32], row: usize| f64::from(supply[row]);
        for row in 0..ROWS {
            let i: Inputs =
                row_inputs(&nominal, (&file.rig, recording), of, &supply, &Neighbours::default(), row);
            let mut put = |column: usize, value: f64| columns[column].push(value);
            put(column::INTERVAL_S, STEP_S);
            put(column::FILL, i.fill);
            put(column::VENT, i.vent);
            put(column::COMMAND_PA, ambient_pa + 1e3 * i.set_point_kpa);
            put(column::SUPPLY_PA, ambient_pa + 1e3 * i.supply_kpa);
            put(column::INVERSE_VOLUME_PER_M3, i.volume_m3.recip());
            put(column::VOLUME_RATE_M3_S, i.volume_rate_m3_s);
        }
    }
    columns[column::TIME_S] = vec![0.0; columns[column::FILL].len()];
    columns
}

fn inputs(columns: &[Vec<f64>]) -> BatchInputs<'_> {
    let jobs = columns[column::FILL].len() / ROWS;
    BatchInputs::new(columns.iter().map(BatchColumn::per_job_and_row).collect(), jobs, ROWS).unwrap()
}

/// Pressures in kPa gauge, and if asked for their derivatives.
fn rolled_out(
    file: &ExtendedFile,
    rollouts: &ExtendedRollouts,
    columns: &[Vec<f64>],
    (values, start_kpa): (&[f64], f64),
    sensitivities: bool,
) -> (Vec<f64>, Vec<f64>) {
    let ambient_pa = file.rig.ambient_or_standard().pressure_kpa_abs * 1e3;
    let inputs = inputs(columns);
    let jobs = vec![Job { parameters: values, start: ambient_pa + 1e3 * start_kpa }; inputs.jobs()];
    let mut outputs = vec![0.0; jobs.len() * ROWS];
    let mut slopes = vec![0.0; if sensitivities { outputs.len() * values.len() } else { 0 }];
    let results = BatchResults {
        outputs: &mut outputs,
        sensitivities: sensitivities.then_some(&mut slopes),
        unit: BatchUnit { zero_pa: ambient_pa, per_pa: 1e-3 },
    };
    rollouts.simulate(&jobs, &inputs, results).unwrap();
    (outputs, slopes)
}

fn set_up(file: &ExtendedFile) -> ExtendedRollouts {
    ExtendedRollouts::new("extended model", file, "b0c0".parse().unwrap(), None).unwrap()
}

fn largest_difference(file: &ExtendedFile, recordings: &[Recording]) -> f64 {
    let model = CalibratedModel::from(file.clone());
    let rollouts = set_up(file);
    let columns = columns(file, recordings);
    let (found, _) = rolled_out(file, &rollouts, &columns, (rollouts.values(), START_KPA), false);
    let mut largest = 0.0_f64;
    for (recording, found) in recordings.iter().zip(found.chunks(ROWS)) {
        let whole = simulate(&model, recording, &SimulationSettings::default(), &mut |_, _| {}).unwrap();
        let kpa = &whole.channels[0].kpa;
        assert!(kpa.iter().any(|p| (p - kpa[0]).abs() > 1.0), "nothing moves");
        assert_eq!((kpa.len(), found.len()), (ROWS, ROWS));
        largest = kpa.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(largest, f64::max);
    }
    largest
}

#[test]
fn every_effect_is_rolled_out_as_it_is_simulated() {
    let (mut tried, mut worst) = (0, 0.0_f64);
    for (number, info) in CATALOGUE.iter().enumerate() {
        for driven in Driven::ALL.into_iter().filter(|driven| driven.has(info)) {
            for jointed in [false, true] {
                let seed = 1000 * number as u64 + 10 * driven as u64 + u64::from(jointed);
                let file = extended(&mut generator(seed), driven, 1, &[info.id]);
                let recordings = [recorded(seed + 1, driven, jointed), recorded(seed + 2, driven, jointed)];
                let largest = largest_difference(&file, &recordings);
                assert!(largest < MOST, "{} {driven:?} {jointed}: {largest} kPa", info.id);
                (tried, worst) = (tried + 1, worst.max(largest));
            }
        }
    }
    println!("{tried} simulations, at most {worst:.1e} kPa apart");
    assert!(tried > 150, "{tried} of them");
}

/// Effects with states of several kinds, smooth in their parameters.
const SMOOTH: [&str; 5] = ["valve_lag", "vent_restriction", "wall_creep", "line_restriction", "sensor_lag"];

#[test]
fn derivatives_are_those_of_differences() {
    for driven in [Driven::Spool, Driven::Separate] {
        let mut file = extended(&mut generator(31 + driven as u64), driven, 1, &SMOOTH);
        for (id, values) in &mut file.channels.get_mut("b0c0").unwrap().effects {
            // Sizes at which each does something.
            let info = CATALOGUE.iter().find(|info| info.id == id).unwrap();
            let probe = info.probes.last().unwrap();
            *values = info.parameters.iter().zip(*probe).map(|(p, v)| (p.name.to_owned(), *v)).collect();
        }
        let rollouts = set_up(&file);
        let columns = columns(&file, &[recorded(5, driven, true), recorded(6, driven, true)]);
        let values = rollouts.values().to_vec();
        let width = values.len();
        assert!(width > 8, "{width} parameters take one pass: nothing is tried of the second");
        let at =
            |values: &[f64], start: f64| rolled_out(&file, &rollouts, &columns, (values, start), false).0;
        let (pressures, slopes) = rolled_out(&file, &rollouts, &columns, (&values, START_KPA), true);
        assert_eq!(pressures, at(&values, START_KPA));
        let weights: Vec<f64> = (0..pressures.len()).map(|k| (0.7 * k as f64).sin()).collect();
        let ambient_pa = file.rig.ambient_or_standard().pressure_kpa_abs * 1e3;
        let jobs = vec![Job { parameters: &values, start: ambient_pa + 1e3 * START_KPA }; 2];
        let gradient = rollouts.gradient(&jobs, &inputs(&columns), &weights).unwrap();
        for (i, parameter) in rollouts.parameters().iter().enumerate() {
            let step = 1e-5 * values[i].abs().max(1e-3);
            let moved = |sign: f64| {
                let mut values = values.clone();
                values[i] += sign * step;
                at(&values, START_KPA)
            };
            let difference: Vec<f64> =
                moved(1.0).iter().zip(moved(-1.0)).map(|(a, b)| (a - b) / (2.0 * step)).collect();
            let exact: Vec<f64> = slopes.iter().skip(i).step_by(width).copied().collect();
            compare(&parameter.name, &exact, &difference);
            for (job, found) in gradient.parameters.iter().skip(i).step_by(width).enumerate() {
                let rows = job * ROWS..(job + 1) * ROWS;
                let sum: f64 = weights[rows.clone()].iter().zip(&exact[rows]).map(|(w, s)| 1e3 * w * s).sum();
                let size: f64 = exact.iter().map(|s| 1e3 * s.abs()).sum();
                assert!((found - sum).abs() <= 1e-9 * size, "{}: {found} {sum}", parameter.name);
            }
        }
        let difference: Vec<f64> = at(&values, START_KPA + 0.01)
            .iter()
            .zip(at(&values, START_KPA - 0.01))
            .map(|(a, b)| (a - b) / 0.02)
            .collect();
        for (job, found) in gradient.start.iter().enumerate() {
            let rows = job * ROWS..(job + 1) * ROWS;
            let sum: f64 = weights[rows.clone()].iter().zip(&difference[rows]).map(|(w, s)| w * s).sum();
            assert!((found - sum).abs() < 2e-3 * sum.abs().max(1.0), "start of {job}: {found} {sum}");
        }
    }
}

fn compare(name: &str, exact: &[f64], difference: &[f64]) {
    let size = exact.iter().chain(difference).fold(0.0_f64, |most, s| most.max(s.abs()));
    assert!(size > 0.0, "{name} does nothing");
    // At kinks (ports that close, flows that choke) they differ.
    let far = exact.iter().zip(difference).filter(|(a, b)| (*a - *b).abs() > 1e-3 * size).count();
    assert!(far * 20 < exact.len(), "{name}: {far} of {} are apart", exact.len());
}

#[test]
fn what_cannot_be_rolled_out_is_refused_in_words() {
    let mut file = extended(&mut generator(3), Driven::Command, 1, &[]);
    let id = "b0c0".parse().unwrap();
    let refused = |file: &ExtendedFile, set_point| {
        ExtendedRollouts::new("robot.toml", file, id, set_point).map(|_| ()).unwrap_err().to_string()
    };
    let words = refused(&file, Some(false));
    assert!(words.contains("robot.toml") && words.contains("has no drive"), "{words}");
    file.channels.clear();
    assert!(refused(&file, None).contains("no channel b0c0"));

    let mut file = extended(&mut generator(3), Driven::Spool, 1, &["valve_lag"]);
    let corrected = |variable: &str| {
        let text = format!(
            "variable = \"{variable}\"\nknots = [-1.0, -0.5, -0.1, 0.1, 0.5, 1.0]\nheights = [9.0, 9.0, 9.0, 9.0, 9.0, 9.0]"
        );
        Some(toml::from_str(&text).unwrap())
    };
    file.channels.get_mut("b0c0").unwrap().correction = corrected("others_draw");
    assert!(refused(&file, None).contains("what the other channels draw"));
    // A correction of the drive is simulated as everywhere, and has no derivatives.
    file.channels.get_mut("b0c0").unwrap().correction = corrected("drive");
    let recordings = [recorded(8, Driven::Spool, false)];
    assert!(largest_difference(&file, &recordings) < MOST);
    let (rollouts, columns) = (set_up(&file), columns(&file, &recordings));
    let jobs = [Job { parameters: rollouts.values(), start: 1.5e5 }];
    let found = rollouts.gradient(&jobs, &inputs(&columns), &[1.0; ROWS]);
    assert_eq!(found, Err(BatchError::Correction));
}
