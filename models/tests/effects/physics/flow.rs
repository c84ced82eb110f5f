//! What flows through the ports.

use pneudrive_model::model::{ATMOSPHERE_PA, psi_max};

use super::{assert_all_close, assert_close, choked, openings};
use crate::effects::bench::{Bench, CRITICAL_RATIO};

/// Subsonic part of the flow function over its largest value, at a pressure ratio.
fn psi(ratio: f64, critical: f64, exponent: f64) -> f64 {
    let z = ((ratio - critical) / (1.0 - critical)).max(0.0);
    (1.0 - z * z).powf(exponent)
}

pub fn two_orifices_in_series_pass_the_flow_that_is_equal_in_both() {
    let (area_ratio, gain) = (0.5, 1.0);
    let mut bench = Bench::valve(gain, 600e3, &[-1.0; 12]);
    bench.plant.longest_step_s = 0.0005;
    let run = bench.run(&[("vent_restriction", &[area_ratio, 0.001])]);
    // The restriction is choked, the port is not; x is the pressure between them over the
    // chamber's.
    let excess = |x: f64| psi(x, CRITICAL_RATIO, 0.5) - area_ratio * x;
    let (mut low, mut high) = (CRITICAL_RATIO, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        (low, high) = if excess(middle) > 0.0 { (middle, high) } else { (low, middle) };
    }
    let (first, last) = (run[3].reading_pa, run[11].reading_pa);
    assert!(low * last > ATMOSPHERE_PA / CRITICAL_RATIO, "choked to the end");
    let expected = bench.choked_rate() * gain * area_ratio * low * 0.08;
    assert_close((first / last).ln(), expected, 2e-3);
    // Where the port is nearly closed the restriction is as good as not there.
    let nearly_closed = Bench::valve(gain, 600e3, &[-0.05; 12]);
    let fall = |run: Vec<crate::effects::bench::Sample>| (run[3].reading_pa / run[11].reading_pa).ln();
    let with = fall(nearly_closed.run(&[("vent_restriction", &[area_ratio, 0.001])]));
    assert_close(with, fall(nearly_closed.run(&[])), 1e-2);
}

pub fn the_flow_is_that_of_the_critical_ratio_and_exponent() {
    for (critical, exponent) in [(0.3, 0.5), (0.15, 0.5), (0.5, 0.5), (0.3, 0.8)] {
        for ratio in [0.1, 0.4, 0.6, 0.9] {
            let bench = Bench::valve(0.1, ratio * 650e3, &[1.0; 2]);
            let run = bench.run(&[("flow_function", &[critical, exponent])]);
            let expected = 0.1 * psi(ratio, critical, exponent) * psi_max() * 650e3;
            assert_close(run[0].draw, expected, 1e-6);
        }
    }
}

pub fn a_closed_chamber_decays_with_the_time_constant_of_choked_flow() {
    let area = 0.05;
    let bench = Bench::valve(1.0, 600e3, &[0.0; 200]);
    let run = bench.run(&[("exhaust_leak", &[area])]);
    assert!(run[199].reading_pa > ATMOSPHERE_PA / CRITICAL_RATIO, "choked to the end");
    let decay: Vec<f64> = run.iter().map(|s| (s.reading_pa / 600e3).ln()).collect();
    let expected: Vec<f64> = (0..200).map(|k| -bench.choked_rate() * area * 0.01 * f64::from(k)).collect();
    assert_all_close(&decay, &expected, 1e-6);
}

pub fn a_closed_chamber_rises_at_the_choked_rate() {
    let area = 0.01;
    let bench = choked(&[0.0; 100]);
    let run = bench.run(&[("fill_leak", &[area])]);
    let rise = bench.choked_rate() * area * 650e3 * 0.01;
    let found: Vec<f64> = run.iter().map(|s| s.reading_pa - 110e3).collect();
    assert_all_close(&found, &(0..100).map(|k| rise * f64::from(k)).collect::<Vec<_>>(), 1e-6);
    assert_all_close(&openings(&bench, &run), &[area; 100], 1e-6);
}
