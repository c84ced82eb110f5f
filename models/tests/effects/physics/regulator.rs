//! Regulators with their own loop.

use pneudrive_model::model::ATMOSPHERE_PA;

use super::{assert_all_close, assert_close, last, readings};
use crate::effects::bench::Bench;

/// The pressure at which it starts and is first commanded, Pa absolute.
const START_PA: f64 = ATMOSPHERE_PA + 100e3;

/// A regulator with a time constant of 0.1 s, and a step of its command in row 5, Pa.
fn step(height_pa: f64, rows: usize) -> Bench {
    let command: Vec<f64> = (0..rows).map(|k| START_PA + if k < 5 { 0.0 } else { height_pa }).collect();
    Bench::regulator(10.0, START_PA, &command)
}

pub fn a_small_change_of_the_command_is_ignored_and_a_large_one_is_not() {
    // 0.05 of 300 kPa.
    let run = |height_pa: f64| readings(&step(height_pa, 100).run(&[("dead_band", &[0.05])]));
    for small in [14e3, -14e3] {
        assert_all_close(&run(small), &[START_PA; 100], 1e-12);
    }
    for large in [16e3, -16e3] {
        assert_eq!(run(large), readings(&step(large, 100).run(&[])));
    }
}

pub fn a_large_step_is_a_ramp_at_the_limit() {
    let limit_kpa_s = 200.0;
    let run = readings(&step(150e3, 200).run(&[("rate_limit", &[limit_kpa_s])]));
    // While more than the limit is asked for: alpha (command - p).
    for k in 5..50 {
        assert_close(run[k + 1] - run[k], 1e3 * limit_kpa_s * 0.01, 1e-9);
    }
    assert_close(run[199], START_PA + 150e3, 1e-3);
    // A small step is not limited.
    let small = step(15e3, 200);
    assert_eq!(readings(&small.run(&[("rate_limit", &[limit_kpa_s])])), readings(&small.run(&[])));
}

pub fn the_final_pressure_is_off_by_the_offset() {
    let end = |offset_kpa: f64| last(&step(50e3, 400).run(&[("offset", &[offset_kpa])]));
    for offset_kpa in [-3.0, 8.0] {
        assert_close(end(offset_kpa) - end(0.0), 1e3 * offset_kpa, 1e-9);
    }
}
