//! The air in front of the valve.

use std::f64::consts::TAU;

use pneudrive_model::model::psi_max;

use super::{assert_all_close, assert_close, choked, openings};
use crate::effects::bench::{Bench, Installed};

/// A port of a thousandth of a mm^2, through which the supply's pressure is seen and hardly changes
/// anything.
const PORT_MM2: f64 = 1e-3;

fn window(rows: usize) -> Bench {
    Bench::valve(PORT_MM2, 110e3, &vec![1.0; rows])
}

/// The supply's pressure in every row, from the choked flow through that port, Pa absolute.
fn supply(bench: &Bench, effects: Installed<'_>) -> Vec<f64> {
    bench.run(effects).iter().map(|s| s.draw / (PORT_MM2 * psi_max())).collect()
}

pub fn the_supply_falls_in_proportion_to_the_total_flow() {
    let (drop_kpa, tau) = (40.0, 0.05);
    // How many valves like this one are full open on other channels.
    let fall = |others: f64| {
        let mut bench = window(200);
        bench.inputs.others_draw = bench.every(others * PORT_MM2 * psi_max() * 650e3);
        supply(&bench, &[("supply_sag", &[drop_kpa, tau])]).iter().map(|p| 650e3 - p).collect::<Vec<_>>()
    };
    let [one, two, four] = [1.0, 2.0, 4.0].map(|others| fall(others)[199]);
    assert_close(four - two, 2.0 * (two - one), 1e-2);
    // The other valve and, at the pressure that is left, this one.
    assert_close(one, 1e3 * drop_kpa * (1.0 + (650e3 - one) / 650e3), 1e-3);
}

pub fn the_supply_swings_as_a_triangle() {
    let (amplitude_kpa, period, phase, rise) = (20.0, 1.0, 0.2, 0.3);
    let bench = window(300);
    let found = supply(&bench, &[("supply_ripple", &[amplitude_kpa, period, phase, rise])]);
    // From -1 at the start of a period up to 1 after its rising part.
    let wave = |k: i32| {
        let x = ((0.01 * f64::from(k) + 0.005) / period + phase).fract();
        if x < rise { 2.0 * x / rise - 1.0 } else { 1.0 - 2.0 * (x - rise) / (1.0 - rise) }
    };
    let expected: Vec<f64> = (0..300).map(|k| 650e3 + 1e3 * amplitude_kpa * wave(k)).collect();
    assert_all_close(&found, &expected, 1e-5);
}

pub fn the_inflow_swings_as_a_sine() {
    let (amplitude, period, phase) = (0.2, 0.8, 0.1);
    let bench = choked(&[0.5; 200]);
    let found = openings(&bench, &bench.run(&[("inflow_cycle", &[amplitude, period, phase])]));
    let wave = |k: i32| (TAU * ((0.01 * f64::from(k) + 0.005) / period + phase)).sin();
    let expected: Vec<f64> = (0..200).map(|k| 0.05 * (1.0 + amplitude * wave(k))).collect();
    assert_all_close(&found, &expected, 1e-6);
}

pub fn choked_inflow_is_proportional_to_the_supply() {
    let bench = choked(&[1.0; 20]);
    let rise = |level_kpa: f64| {
        let run = bench.run(&[("supply_level", &[level_kpa])]);
        run[19].reading_pa - run[0].reading_pa
    };
    assert_close(rise(-65.0) / rise(0.0), 0.9, 1e-9);
    assert_close(rise(130.0) / rise(0.0), 1.2, 1e-9);
}

pub fn choked_inflow_is_proportional_to_what_the_supply_is() {
    let bench = choked(&[1.0; 20]);
    let rise = |share: f64| {
        let run = bench.run(&[("supply_misstated", &[share])]);
        run[19].reading_pa - run[0].reading_pa
    };
    assert_close(rise(-0.05) / rise(0.0), 0.95, 1e-9);
    assert_close(rise(0.04) / rise(0.0), 1.04, 1e-9);
}
