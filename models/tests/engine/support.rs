//! Recordings made up for tests: excitation, joint motion, and measurement noise. The pressures
//! come from the crate's own rollouts, which the rollout oracle checks against an independent
//! integrator.

use std::f64::consts::TAU;

use pneudrive_model::model::{ATMOSPHERE_PA, Joint, column};
use pneudrive_model::rollout::{Series, Start, System, simulate};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Parameters of [`Nonlinear`](pneudrive_model::model::Nonlinear) with a spool: leaks, gain,
/// thresholds, corner, volume weight.
pub const TRUTH: [f64; 7] = [0.03, 0.05, 4.0, 0.12, -0.09, 0.15, 1.0];

/// The joint of the design's rig file.
pub const JOINT: Joint = Joint { radius_m: 0.024, length_m: 0.2, offset_m: 0.045 };

/// A source of random numbers that is the same on every machine.
pub fn random(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// A standard normal number, by Box and Muller.
pub fn normal(random: &mut impl Rng) -> f64 {
    let (a, b): (f64, f64) = (random.random(), random.random());
    (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos()
}

/// Inputs of a chamber at 100 Hz: a spool drive that steps every 50 to 500 ms, commands that step
/// every 1 to 3 s, a joint that swings slowly. Row by row in the layout of [`column`].
pub fn inputs(rows: usize, seed: u64) -> Vec<f64> {
    const INTERVAL_S: f64 = 0.01;
    let mut random = random(seed);
    let (mut drive, mut drive_left) = (0.0, 0);
    let (mut command, mut command_left) = (0.0, 0);
    let volume = |k: usize| {
        let t = k as f64 * INTERVAL_S;
        JOINT.volume_m3(0, 0.6 * (0.7 * t).sin() + 0.2 * (2.3 * t).sin(), 0.0)
    };
    let mut table = Vec::with_capacity(rows * column::COUNT);
    for k in 0..rows {
        if drive_left == 0 {
            drive = random.random_range(-0.6..0.6);
            drive_left = random.random_range(5..50);
        }
        if command_left == 0 {
            command = random.random_range(0.0..450e3);
            command_left = random.random_range(100..300);
        }
        drive_left -= 1;
        command_left -= 1;
        let mut row = [0.0; column::COUNT];
        row[column::TIME_S] = k as f64 * INTERVAL_S;
        row[column::INTERVAL_S] = INTERVAL_S;
        row[column::FILL] = drive;
        row[column::VENT] = -drive;
        row[column::COMMAND_PA] = ATMOSPHERE_PA + command;
        row[column::SUPPLY_PA] = ATMOSPHERE_PA + 550e3;
        row[column::INVERSE_VOLUME_PER_M3] = 2.0 / (volume(k) + volume(k + 1));
        row[column::VOLUME_RATE_M3_S] = (volume(k + 1) - volume(k)) / INTERVAL_S;
        table.extend(row);
    }
    table
}

/// A series without noise in equally long segments, starting at 200 kPa absolute.
pub fn clean(system: &dyn System, truth: &[f64], rows: usize, segments: usize, seed: u64) -> Series {
    let inputs = inputs(rows, seed);
    let cut = |i: usize| rows * i / segments;
    let ranges: Vec<_> = (0..segments).map(|i| cut(i)..cut(i + 1)).collect();
    let blank =
        Series::new(column::COUNT, inputs.clone(), vec![200e3; rows], vec![1.0; rows], ranges.clone())
            .unwrap();
    let pressures = simulate(system, truth, &blank, Start::Measured, 4);
    Series::new(column::COUNT, inputs, pressures, vec![1.0; rows], ranges).unwrap()
}

/// The same series with white noise of the given standard deviation.
pub fn noisy(series: &Series, sigma_pa: f64, seed: u64) -> Series {
    let mut random = random(seed);
    let measured = series.measured().iter().map(|p| p + sigma_pa * normal(&mut random)).collect();
    let rows = series.inputs(0..series.len()).to_vec();
    Series::new(series.width(), rows, measured, series.weights().to_vec(), series.segments().to_vec())
        .unwrap()
}
