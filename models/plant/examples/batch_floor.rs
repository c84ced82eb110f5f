//! How far batches are from what their square roots alone cost:
//! `cargo run --release -p pneudrive-plant --example batch_floor`
//!
//! A chamber needs ten roots a row: two for its valve's openings, and two at each of the four
//! stages of a Runge-Kutta step. The floor is ten times what a root takes in a loop that does
//! nothing else, on the same processor in the same run. One thread; the smallest of many times.

#![allow(clippy::unwrap_used)]

use std::hint::black_box;
use std::time::Instant;

use multiversion::multiversion;
use pneudrive_plant::model::{ATMOSPHERE_PA, Model, Nonlinear, column, nominal_values};
use pneudrive_plant::rollout::{
    BatchColumn, BatchInputs, BatchResults, BatchUnit, Chamber, Job, simulate_batch_into,
    simulate_batch_single_into,
};

const ROOTS_A_ROW: f64 = 10.0;
const ROOTS: usize = 2048;
const ROWS: usize = 500;
const KPA: BatchUnit = BatchUnit { zero_pa: ATMOSPHERE_PA, per_pa: 1e-3 };

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().unwrap();
    let repetitions: usize = std::env::args().nth(1).map_or(40, |text| text.parse().unwrap());
    // Of pressures' squares: whole roots might be found sooner.
    let squares: Vec<f64> = (0..ROOTS).map(|k| 1.3e10 + 1.7e7 * k as f64).collect();
    #[allow(clippy::cast_possible_truncation)] // to single precision, as it says
    let narrow: Vec<f32> = squares.iter().map(|square| *square as f32).collect();
    let (mut double, mut single) = (vec![0.0_f64; ROOTS], vec![0.0_f32; ROOTS]);
    let per_root = 1.0 / ROOTS as f64;
    let floors = [
        ROOTS_A_ROW
            * per_root
            * least_ns(100 * repetitions, || {
                roots_double(black_box(&squares), black_box(&mut double));
            }),
        ROOTS_A_ROW
            * per_root
            * least_ns(100 * repetitions, || {
                roots_single(black_box(&narrow), black_box(&mut single));
            }),
    ];
    println!(
        "floor, ns per chamber and row: {:.2} in double precision, {:.2} in single",
        floors[0], floors[1]
    );
    println!("| chambers | precision | ns per chamber and row | of the floor |\n| --- | --- | --- | --- |");
    for chambers in [64, 4096] {
        // Small batches more often: as much time each.
        let repetitions = repetitions * (4096 / chambers).min(16);
        let [double, single] = batches(chambers, repetitions);
        for (precision, ns, floor) in [("double", double, floors[0]), ("single", single, floors[1])] {
            println!("| {chambers} | {precision} | {ns:.2} | {:.2} |", ns / floor);
        }
    }
}

/// Nanoseconds that the fastest of several runs takes.
fn least_ns(repetitions: usize, mut run: impl FnMut()) -> f64 {
    let time = |_| {
        let began = Instant::now();
        run();
        began.elapsed().as_secs_f64() * 1e9
    };
    (0..repetitions).map(time).fold(f64::INFINITY, f64::min)
}

/// Nanoseconds per chamber and row in double and in single precision: each chamber with drives and
/// parameters of its own.
fn batches(chambers: usize, repetitions: usize) -> [f64; 2] {
    let chamber = Chamber::new(Nonlinear::default());
    let nominal = nominal_values(&chamber.model.parameters());
    let varied = |k: usize| nominal.iter().map(move |v| v * (1.0 + 1e-4 * (k % 100) as f64)).collect();
    let sets: Vec<Vec<f64>> = (0..chambers).map(varied).collect();
    let jobs: Vec<Job<'_>> = sets.iter().map(|parameters| Job { parameters, start: 2e5 }).collect();
    let drive: Vec<f64> = (0..chambers * ROWS).map(|k| 0.5 * (0.37 * (k / 20) as f64).sin()).collect();
    #[allow(clippy::cast_possible_truncation)] // to single precision, as it says
    let narrow: Vec<f32> = drive.iter().map(|u| *u as f32).collect();
    let values = (chambers * ROWS) as f64;
    let (mut outputs, mut narrow_outputs) = (vec![0.0; drive.len()], vec![0.0_f32; drive.len()]);

    let inputs = inputs(BatchColumn::per_job_and_row(&drive), chambers);
    let double = least_ns(repetitions, || {
        let results = BatchResults { outputs: black_box(&mut outputs), sensitivities: None, unit: KPA };
        simulate_batch_into(&chamber, &jobs, &inputs, 1, results).unwrap();
    });
    let inputs = self::inputs(BatchColumn::per_job_and_row(&narrow), chambers);
    let single = least_ns(repetitions, || {
        simulate_batch_single_into(&chamber, &jobs, &inputs, 1, black_box(&mut narrow_outputs), KPA).unwrap();
    });
    let apart = outputs.iter().zip(&narrow_outputs).map(|(a, b)| (a - f64::from(*b)).abs());
    assert!(apart.fold(0.0, f64::max) < 0.02, "the two precisions are not the same simulation");
    [double / values, single / values]
}

fn inputs(drive: BatchColumn<'_>, chambers: usize) -> BatchInputs<'_> {
    let mut columns = vec![BatchColumn::constant(0.0); column::COUNT];
    columns[column::INTERVAL_S] = BatchColumn::constant(0.01);
    columns[column::FILL] = drive.within([-1.0, 1.0]);
    columns[column::VENT] = drive.within([-1.0, 1.0]).scaled(-1.0, 0.0);
    columns[column::SUPPLY_PA] = BatchColumn::constant(6.5e5);
    columns[column::INVERSE_VOLUME_PER_M3] = BatchColumn::constant(1.0 / 3.6e-4);
    BatchInputs::new(columns, chambers, ROWS).unwrap()
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn roots_double(squares: &[f64], roots: &mut [f64]) {
    roots.iter_mut().zip(squares).for_each(|(root, square)| *root = square.sqrt());
}

#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn roots_single(squares: &[f32], roots: &mut [f32]) {
    roots.iter_mut().zip(squares).for_each(|(root, square)| *root = square.sqrt());
}
