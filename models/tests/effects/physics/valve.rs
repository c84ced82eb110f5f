//! What moves the spool, and how far the ports open.

use super::{GAIN_MM2, assert_all_close, assert_close, choked, openings, readings};
use crate::effects::bench::Bench;

/// A step to full drive in row 5.
fn step(rows: usize) -> Vec<f64> {
    (0..rows).map(|k| if k < 5 { 0.0 } else { 1.0 }).collect()
}

/// What the spool's position must be for these openings.
fn positions(drive: &[f64], id: &str, values: &[f64]) -> Vec<f64> {
    let bench = choked(drive);
    openings(&bench, &bench.run(&[(id, values)])).iter().map(|area| area / GAIN_MM2).collect()
}

pub fn beyond_the_limit_more_drive_changes_nothing() {
    let run = |drive: f64, limit: f64| choked(&[drive; 20]).run(&[("drive_saturation", &[limit])]);
    assert_eq!(readings(&run(0.5, 0.5)), readings(&run(0.8, 0.5)));
    assert_eq!(readings(&run(0.4, 0.5)), readings(&run(0.4, 1.0)));
    assert_ne!(readings(&run(0.8, 0.5)), readings(&run(0.8, 1.0)));
}

pub fn a_closed_valve_opens_by_the_share_of_the_drive_beside_it() {
    let beside = step(40);
    let mut bench = choked(&[0.2; 40]);
    bench.inputs.neighbour_drive = beside.clone().into();
    let found = openings(&bench, &bench.run(&[("drive_crosstalk", &[0.05])]));
    let expected: Vec<f64> = beside.iter().map(|u| GAIN_MM2 * (0.2 + 0.05 * u)).collect();
    assert_all_close(&found, &expected, 1e-9);
}

pub fn the_spool_falls_back_as_the_coil_warms_up_and_returns_as_it_cools() {
    // Half drive for ten time constants, a tenth of it for as long.
    let (tau, rise, h) = (0.2, 0.4, 0.01);
    let rows = 400;
    let drive: Vec<f64> = (0..rows).map(|k| if k < rows / 2 { 0.5 } else { 0.05 }).collect();
    let found = positions(&drive, "coil_heating", &[rise, tau]);
    let hot = |k: usize| {
        let t = h * k as f64;
        match t - 10.0 * tau {
            cooling if cooling > 0.0 => 0.0025 + (0.25 - 0.0025) * (-cooling / tau).exp(),
            _ => 0.25 * (1.0 - (-t / tau).exp()),
        }
    };
    // In a row, the mean of its ends.
    let mean = |k: usize| 0.5 * (hot(k) + hot(k + 1));
    let expected: Vec<f64> = (0..rows).map(|k| drive[k] / (1.0 + rise * mean(k))).collect();
    assert_all_close(&found, &expected, 1e-5);
    // Warm, copper passes less: a tenth here.
    assert_close(found[rows / 2 - 1], 0.5 / 1.1, 1e-4);
    assert_close(found[rows - 1], 0.05, 2e-3);
}

pub fn a_dead_time_of_some_rows_shifts_the_response_by_these_rows() {
    let drive: Vec<f64> = (0..60).map(|k| 0.5 * (0.4 * f64::from(k)).sin()).collect();
    // A valve that is driven as in row 0 before it.
    let held = |rows: usize| [&vec![drive[0]; rows][..], &drive[..60 - rows]].concat();
    for rows in [1, 3, 25] {
        let late = Bench::valve(2.0, 250e3, &drive).run(&[("transport_delay", &[0.01 * rows as f64])]);
        let shifted = Bench::valve(2.0, 250e3, &held(rows)).run(&[]);
        assert_all_close(&readings(&late), &readings(&shifted), 1e-12);
    }
    a_dead_time_is_a_time_whatever_the_rows_are();
}

/// Rows of a real recording are not of one length, and longer ones are simulated in more steps.
fn a_dead_time_is_a_time_whatever_the_rows_are() {
    let delay = 0.017;
    let mut bench = choked(&step(40));
    let lengths: Vec<f64> = (0..40).map(|k| [0.008, 0.013, 0.0101][k % 3]).collect();
    let times: Vec<f64> = (0..40).map(|k| lengths[..k].iter().sum()).collect();
    let opens = times[5] + delay;
    let open = |k: usize| ((times[k] + lengths[k] - opens) / lengths[k]).clamp(0.0, 1.0);
    let expected: Vec<f64> = (0..40).map(open).collect();
    (bench.inputs.time_s, bench.inputs.interval_s) = (times.clone().into(), lengths.clone().into());
    let found = openings(&bench, &bench.run(&[("transport_delay", &[delay])]));
    assert_all_close(&found.iter().map(|area| area / GAIN_MM2).collect::<Vec<_>>(), &expected, 1e-6);
}

pub fn a_step_of_the_drive_opens_the_port_exponentially() {
    let (tau, h) = (0.03, 0.01);
    let found = positions(&step(40), "valve_lag", &[tau]);
    // Mean of 1 - exp(-t / tau) over each interval.
    let mean = |k: usize| match k.checked_sub(5) {
        Some(after) => 1.0 - tau / h * (-(after as f64) * h / tau).exp() * (1.0 - (-h / tau).exp()),
        None => 0.0,
    };
    assert_all_close(&found, &(0..40).map(mean).collect::<Vec<_>>(), 1e-6);
}

pub fn the_spool_stands_half_the_gap_behind_on_either_way() {
    let half = 0.1;
    let up = (0..30).map(|k| 0.02 * f64::from(k));
    let down = (0..20).map(|k| 0.58 - 0.02 * f64::from(k));
    let drive: Vec<f64> = up.chain(down).collect();
    let found = positions(&drive, "valve_hysteresis", &[half]);
    let expected: Vec<f64> = (0..50)
        .map(|k| match k {
            0..30 => (drive[k] - half).max(0.0),
            // The gap is crossed first.
            _ => (drive[k] + half).min(0.58 - half),
        })
        .collect();
    assert_all_close(&found, &expected, 1e-6);
    assert!(expected[49] > drive[49] && expected[29] < drive[29]);
}

pub fn a_slow_ramp_becomes_stairs_of_the_height_of_the_threshold() {
    let drive: Vec<f64> = (0..50).map(|k| 0.01 * f64::from(k)).collect();
    // Every fifth row is far enough from where the spool stands.
    let expected: Vec<f64> = (0..50).map(|k: usize| 0.05 * (k / 5) as f64).collect();
    assert_all_close(&positions(&drive, "valve_stiction", &[0.045]), &expected, 1e-6);
}

#[test]
fn behind_a_lag_the_spool_jumps_by_the_threshold_and_not_as_far_as_a_step_takes_the_force() {
    let (threshold, drive) = (0.12, [0.5; 60]);
    let bench = choked(&drive);
    let run = bench.run(&[("valve_lag", &[0.03]), ("valve_stiction", &[threshold])]);
    let found: Vec<f64> = openings(&bench, &run).iter().map(|area| area / GAIN_MM2).collect();
    let whole: Vec<f64> = found.iter().map(|at| (at / threshold).round() * threshold).collect();
    assert_all_close(&found, &whole, 1e-6);
    // Steps of 10 ms, in the first of which the force goes further than a threshold.
    assert!(found.windows(2).all(|pair| pair[0] <= pair[1] + 1e-9));
    assert_close(found[59], 0.48, 1e-6);
}

pub fn venting_is_slower_by_the_ratio_and_filling_is_not() {
    let fall = |ratio: f64| {
        let run = Bench::valve(0.5, 600e3, &[-1.0; 10]).run(&[("valve_asymmetry", &[ratio])]);
        (run[0].reading_pa / run[9].reading_pa).ln()
    };
    // Choked: the rate is proportional to pressure and area.
    assert_close(fall(0.4) / fall(1.0), 0.4, 1e-6);
    let fill = |ratio: f64| readings(&choked(&[1.0; 10]).run(&[("valve_asymmetry", &[ratio])]));
    assert_eq!(fill(0.4), fill(1.0));
}

pub fn the_opening_changes_exponentially_with_time() {
    let rate_per_min = -1.5;
    let found = positions(&[1.0; 150], "valve_wear", &[rate_per_min]);
    let expected: Vec<f64> =
        (0..150).map(|k| (rate_per_min / 60.0 * (0.01 * f64::from(k) + 0.005)).exp()).collect();
    assert_all_close(&found, &expected, 1e-7);
}

pub fn the_opening_is_multiplied() {
    assert_all_close(&positions(&[0.4; 10], "valve_gain", &[2.5]), &[1.0; 10], 1e-6);
    let fall = |ratio: f64| {
        let run = Bench::valve(0.2, 600e3, &[-1.0; 10]).run(&[("valve_gain", &[ratio])]);
        (run[0].reading_pa / run[9].reading_pa).ln()
    };
    assert_close(fall(2.5) / fall(1.0), 2.5, 1e-6);
}

pub fn a_shift_of_the_spool_is_a_shift_of_the_drive() {
    let drive: Vec<f64> = (0..40).map(|k| 0.5 * (0.3 * f64::from(k)).sin()).collect();
    let moved: Vec<f64> = drive.iter().map(|u| u + 0.07).collect();
    let shifted = Bench::valve(2.0, 250e3, &drive).run(&[("valve_centre", &[0.07])]);
    assert_all_close(&readings(&shifted), &readings(&Bench::valve(2.0, 250e3, &moved).run(&[])), 1e-12);
}
