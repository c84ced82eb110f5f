//! The gas and the walls around it.

use pneudrive_model::model::{ATMOSPHERE_PA, GAMMA};

use super::{assert_all_close, assert_close, last, readings};
use crate::effects::bench::{Bench, Sample};

/// Full drive for some rows, then closed.
fn pulse(open: usize, rows: usize) -> Vec<f64> {
    (0..rows).map(|k| if k < open { 1.0 } else { 0.0 }).collect()
}

/// By how much the pressure would rise by what was let in, if nothing but the gas in the chamber
/// were warmed by it: the adiabatic change.
fn let_in(bench: &Bench, run: &[Sample]) -> f64 {
    let drawn: f64 = run.iter().map(|s| s.draw * 0.01).sum();
    bench.conductance() / bench.inputs.volume_m3[0] * drawn
}

pub fn filling_lies_between_isothermal_and_adiabatic() {
    // From row 0 to the end of the filling, while the wall warms and cools.
    let share = |tau: f64| {
        let bench = Bench::valve(0.5, 110e3, &[1.0; 31]);
        let run = bench.run(&[("heat_exchange", &[tau])]);
        (last(&run) - 110e3) / let_in(&bench, &run[..30])
    };
    let shares = [0.004, 0.05, 0.2, 1.0, 40.0].map(share);
    assert_close(shares[0], 1.0 / GAMMA, 2e-2);
    assert_close(shares[4], 1.0, 1e-2);
    assert!(shares.windows(2).all(|pair| pair[0] < pair[1]), "{shares:?}");
    assert!(shares[0] >= 1.0 / GAMMA && shares[4] <= 1.0, "{shares:?}");
}

/// What is let in warms the gas behind the tube; in the end it has the walls' temperature, and only
/// what was let in counts.
pub fn gas_behind_a_tube_is_warmed_and_cools_again() {
    let (heat, volume_ratio) = (("heat_exchange", &[0.3][..]), 0.05);
    let tube = ("line_restriction", &[0.1, volume_ratio, 0.0][..]);
    let mut bench = Bench::valve(0.5, 110e3, &pulse(20, 600));
    bench.plant.longest_step_s = 0.0005;
    let run = bench.run(&[heat, tube]);
    let rise = GAMMA * (1.0 + volume_ratio) * (last(&run) - 110e3);
    assert_close(rise, let_in(&bench, &run), 2e-3);
    // 50 ms after the valve has closed the pressures are equal, and the gas is still warm.
    assert!(run[25].reading_pa > last(&run) + 5e3, "{} {}", run[25].reading_pa, last(&run));
    // Emptied through the tube, it cools and is warmed again.
    let mut bench = Bench::valve(0.5, 400e3, &pulse(20, 600).iter().map(|u| -u).collect::<Vec<_>>());
    bench.plant.longest_step_s = 0.0005;
    let run = bench.run(&[heat, tube]);
    let (lowest, end) = (run[25..].iter().map(|s| s.reading_pa).fold(f64::MAX, f64::min), last(&run));
    assert!(end > lowest + 5e3, "{lowest} {end}");
}

/// A tube that hardly resists belongs to the chamber, but that what flows back is warmed in it:
/// while the chamber is filled it changes nothing.
pub fn behind_a_wide_tube_gas_is_warmed_as_without_one() {
    let drive: Vec<f64> = (0..400).map(|k| 0.3 * (0.05 * f64::from(k)).sin().max(0.0)).collect();
    for tau in [0.01, 0.3, 5.0] {
        let heat = ("heat_exchange", &[tau][..]);
        let mut bench = Bench::valve(0.5, 250e3, &drive);
        bench.plant.longest_step_s = 0.002;
        let tube = readings(&bench.run(&[heat, ("line_restriction", &[0.001, 0.003, 0.0])]));
        let none = readings(&bench.run(&[heat]));
        let range = none.iter().fold(0.0, |most: f64, p| most.max((p - 250e3).abs()));
        assert!(range > 50e3, "{range}");
        for (with, without) in tube.iter().zip(&none) {
            // A hundredth: the tube's volume and that it is isothermal.
            assert!((with - without).abs() < 0.01 * range, "{tau} s: {with} and {without}");
        }
    }
}

/// Where no heat is exchanged, a wall gives way as it does without a temperature.
pub fn a_wall_gives_way_to_gas_that_has_a_temperature() {
    let drive: Vec<f64> = (0..200).map(|k| if k % 100 < 50 { 0.5 } else { 0.0 }).collect();
    let mut bench = Bench::valve(0.5, 150e3, &drive);
    bench.plant.longest_step_s = 0.001;
    for (wall, most) in [(("wall_compliance", &[0.2][..]), 0.4), (("wall_creep", &[0.2, 0.3]), 0.2)] {
        let none = readings(&bench.run(&[wall]));
        let heat = readings(&bench.run(&[wall, ("heat_exchange", &[40.0])]));
        let rise = last(&bench.run(&[])) - 150e3;
        let slowed = 1.0 - (none[199] - 150e3) / rise;
        assert!(slowed > most, "{slowed}");
        for (with, without) in heat.iter().zip(&none) {
            // What is exchanged in two seconds of 40.
            assert!((with - without).abs() < 0.02 * rise, "{wall:?}: {with} and {without}");
        }
    }
}

pub fn a_wall_that_gives_way_slows_the_rise_by_volume_and_growth() {
    let compliance = 0.2;
    for start in [110e3, 150e3, 190e3] {
        let rise = |c: f64| {
            let run = Bench::valve(0.01, start, &[1.0; 2]).run(&[("wall_compliance", &[c])]);
            run[1].reading_pa - start
        };
        // V p' + gamma p V' with V = V_0 (1 + c (p - p_ambient)).
        let per_pa = compliance * 1e-5;
        let expected = 1.0 + per_pa * (start - ATMOSPHERE_PA) + GAMMA * start * per_pa;
        assert_close(rise(0.0) / rise(compliance), expected, 1e-3);
    }
}

pub fn a_closed_chamber_creeps_along_the_adiabat_to_its_final_volume() {
    let (compliance, tau) = (0.1, 0.5);
    // Filled in 20 ms, far less than the time constant, then held for ten of them.
    let mut bench = Bench::valve(2.0, 200e3, &pulse(2, 600));
    bench.plant.longest_step_s = 0.001;
    let run = bench.run(&[("wall_creep", &[compliance, tau])]);
    let growth = |p: f64| compliance * (p - ATMOSPHERE_PA) * 1e-5;
    let (before, after) = (run[2].reading_pa, last(&run));
    // The wall crept a little while the chamber was filled: half of the time at half of the rise.
    let crept = growth(200e3) + (growth(before) - growth(200e3)) * 0.5 * 0.02 / tau;
    let invariant = |p: f64, growth: f64| p * (1.0 + growth).powf(GAMMA);
    let (left, right) = (invariant(after, growth(after)), invariant(before, crept));
    assert!(before - after > 1e3, "it creeps: {before} {after}");
    // A hundredth of what creeping changes.
    assert_close(left, right, 0.01 * (before - after) / before);
    // In the first time constant more than half of it, not all of it.
    let part = (before - run[52].reading_pa) / (before - after);
    assert!((0.55..0.75).contains(&part), "{part}");
}

pub fn what_is_let_in_is_in_the_tube_or_in_the_chamber() {
    for (time_constant_s, volume_ratio, laminar_kpa) in
        [(0.04, 0.02, 0.0), (0.3, 0.1, 0.0), (0.1, 0.05, 20.0)]
    {
        let mut bench = Bench::valve(0.5, 110e3, &pulse(20, 200));
        bench.plant.longest_step_s = 0.0005;
        let run = bench.run(&[("line_restriction", &[time_constant_s, volume_ratio, laminar_kpa])]);
        // In the end both have the same pressure.
        assert_close(run[198].reading_pa, last(&run), 1e-9);
        let rise = (1.0 + volume_ratio) * (last(&run) - 110e3);
        assert_close(rise, let_in(&bench, &run), 2e-3);
        // While it flows, the tube's pressure, which the sensor sees, is above the chamber's.
        assert!(run[20].reading_pa > last(&run) + 500.0, "{} {}", run[20].reading_pa, last(&run));
    }
}

pub fn a_fall_of_the_pressure_opposite_lengthens_a_closed_chamber() {
    let (coupling, rows) = (0.1, 400);
    let mut bench = Bench::valve(1.0, 250e3, &vec![0.0; rows]);
    // Gauge; from 250 kPa absolute to 150 kPa in half a second.
    let opposite = |k: usize| 250e3 - ATMOSPHERE_PA - 100e3 * (k as f64 / 50.0).min(1.0);
    bench.inputs.opposite_pa = (0..rows).map(opposite).collect();
    bench.plant.longest_step_s = 0.001;
    let run = bench.run(&[("chamber_coupling", &[coupling, 3.0, 0.7])]);
    // In balance at the start; at the end V = V_0 (1 + coupling (p - p_opposite)), along the
    // adiabat.
    let end = last(&run);
    let growth = coupling * (end - 150e3) * 1e-5;
    assert!(250e3 - end > 10e3, "{end}");
    assert_close(end * (1.0 + growth).powf(GAMMA), 250e3, 0.01 * (250e3 - end) / 250e3);
}

pub fn a_bent_sensor_bends_what_is_read_of_the_chamber_opposite_as_well() {
    let (bow_kpa, rows) = (40.0, 300);
    // 4 kPa of 100 kPa and the like: y = p + 4 bow x (1 - x), x = p / 100 psi.
    let bent = |gauge_pa: f64| {
        let x = gauge_pa / 689_475.7;
        gauge_pa + 4e3 * bow_kpa * x * (1.0 - x)
    };
    let drive: Vec<f64> = (0..rows).map(|k| 0.4 * (0.1 * k as f64).sin()).collect();
    let coupling: (&str, &[f64]) = ("chamber_coupling", &[0.1, 3.0, 0.7]);
    let opposite = |k: usize| 80e3 + 60e3 * (0.05 * k as f64).sin();
    let mut bench = Bench::valve(2.0, 250e3, &drive);
    bench.inputs.opposite_pa = (0..rows).map(opposite).collect();
    let straight = readings(&bench.run(&[coupling]));
    bench.inputs.opposite_pa = (0..rows).map(|k| bent(opposite(k))).collect();
    let run = readings(&bench.run(&[coupling, ("sensor_nonlinearity", &[bow_kpa])]));
    let expected = straight.iter().map(|p| bent(p - ATMOSPHERE_PA) + ATMOSPHERE_PA);
    // The first row is read before anything moves, as it was measured. Between two rows pressures
    // are interpolated before they are straightened.
    assert_all_close(&run[1..], &expected.skip(1).collect::<Vec<_>>(), 1e-6);
    bench.inputs.opposite_pa = (0..rows).map(opposite).collect();
    let unbent = readings(&bench.run(&[coupling, ("sensor_nonlinearity", &[bow_kpa])]));
    let apart = run.iter().zip(&unbent).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart > 500.0, "{apart}");
}

pub fn a_larger_chamber_does_the_same_more_slowly() {
    let drive: Vec<f64> = (0..40).map(|k| 0.6 * (0.5 * f64::from(k)).sin()).collect();
    let small = Bench::valve(2.0, 250e3, &drive);
    let mut large = small.clone();
    large.inputs.interval_s = large.every(0.025);
    large.inputs.time_s = (0..40).map(|k| 0.025 * f64::from(k)).collect();
    large.plant.longest_step_s = 0.025;
    assert_all_close(&readings(&large.run(&[("chamber_volume", &[2.5])])), &readings(&small.run(&[])), 1e-12);
}
