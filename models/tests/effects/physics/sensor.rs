//! What the sensor makes of the pressure.

use pneudrive_model::model::ATMOSPHERE_PA;

use super::{assert_all_close, assert_close, choked, readings};
use crate::effects::bench::{Bench, Installed, catalogue};

/// A chamber that keeps its gauge pressure, Pa.
fn still(gauge_pa: f64, rows: usize) -> Bench {
    Bench::valve(1.0, gauge_pa + ATMOSPHERE_PA, &vec![0.0; rows])
}

/// A chamber that is filled and vented.
fn moving() -> Bench {
    let drive: Vec<f64> = (0..100).map(|k| 0.5 * (0.2 * f64::from(k)).sin()).collect();
    let mut bench = Bench::valve(1.0, 250e3, &drive);
    let repeats = |k: usize| if k % 5 == 4 { k - 1 } else { k };
    bench.inputs.measured_pa = (0..100).map(|k| 250e3 + 100.0 * repeats(k) as f64).collect();
    bench.inputs.sampled_before_pa = bench.every(50e3);
    bench
}

/// Gauge readings with an effect, behind the start, which is measured as it is.
fn gauge(bench: &Bench, effects: Installed<'_>) -> Vec<f64> {
    readings(&bench.run(effects)).iter().skip(1).map(|p| p - ATMOSPHERE_PA).collect()
}

pub fn a_ramp_is_read_late_by_the_time_constant() {
    let tau = 0.05;
    let bench = choked(&[0.5; 100]);
    let rate = bench.choked_rate() * 0.05 * 650e3;
    let (with, without) = (gauge(&bench, &[("sensor_lag", &[tau])]), gauge(&bench, &[]));
    // After ten time constants.
    for row in 50..99 {
        assert_close(without[row] - with[row], rate * tau, 1e-3);
    }
    // At first it is not.
    assert!(without[0] - with[0] < 0.5 * rate * tau);
}

pub fn the_bow_is_in_the_middle_and_nothing_at_the_ends() {
    const RANGE_PA: f64 = 689_475.7;
    let error = |gauge_pa: f64| gauge(&still(gauge_pa, 2), &[("sensor_nonlinearity", &[6.0])])[0] - gauge_pa;
    assert!(error(0.0).abs() < 1.0 && error(RANGE_PA).abs() < 1.0, "{} {}", error(0.0), error(RANGE_PA));
    assert_close(error(0.5 * RANGE_PA), 6e3, 1e-4);
    assert_close(error(0.25 * RANGE_PA), 0.75 * 6e3, 1e-4);
}

pub fn the_zero_drifts_exponentially_to_its_change() {
    let (change_kpa, tau) = (4.0, 20.0);
    let mut bench = still(200e3, 100);
    bench.inputs.interval_s = bench.every(1.0);
    bench.inputs.time_s = (0..100).map(f64::from).collect();
    let found: Vec<f64> =
        gauge(&bench, &[("sensor_drift", &[change_kpa, tau])]).iter().map(|p| p - 200e3).collect();
    let expected: Vec<f64> =
        (1..100).map(|k| 1e3 * change_kpa * (1.0 - (-f64::from(k) / tau).exp())).collect();
    assert_all_close(&found, &expected, 1e-3);
}

pub fn the_reading_is_pulled_to_the_sample_before_by_the_share() {
    let mut bench = still(200e3, 10);
    bench.inputs.sampled_before_pa = bench.every(80e3);
    let found = gauge(&bench, &[("sensor_crosstalk", &[0.1])]);
    assert_all_close(&found, &[0.9 * 200e3 + 0.1 * 80e3; 9], 1e-6);
}

pub fn an_old_sample_is_held_by_its_share_where_rows_repeat() {
    let bench = moving();
    let (fresh, half, whole) = (
        gauge(&bench, &[]),
        gauge(&bench, &[("stale_samples", &[0.5])]),
        gauge(&bench, &[("stale_samples", &[1.0])]),
    );
    let mut held = 0;
    for k in 1..99 {
        // Row k + 1 of the recording. What moves by no more than the noise may repeat by chance.
        let stale = (k + 1) % 5 == 4 && (fresh[k] - fresh[k - 1]).abs() > 4.0 * 100.0;
        if stale {
            held += 1;
            assert_eq!(whole[k], fresh[k - 1], "row {k}");
            assert_close(half[k], 0.5 * (fresh[k] + fresh[k - 1]), 1e-9);
        } else {
            assert_eq!((half[k], whole[k]), (fresh[k], fresh[k]), "row {k}");
        }
    }
    assert!(held > 10, "{held}");
}

pub fn every_reading_is_off_by_the_offset() {
    let bench = moving();
    let expected: Vec<f64> = gauge(&bench, &[]).iter().map(|p| p - 3e3).collect();
    assert_all_close(&gauge(&bench, &[("sensor_offset", &[-3.0])]), &expected, 1e-12);
}

pub fn every_reading_is_off_by_the_factor() {
    let bench = moving();
    let expected: Vec<f64> = gauge(&bench, &[]).iter().map(|p| 1.03 * p).collect();
    assert_all_close(&gauge(&bench, &[("sensor_gain", &[1.03])]), &expected, 1e-12);
}

/// With the drive recorded, the chamber does not know what the sensor says of it.
#[test]
fn what_is_wrong_with_a_sensor_acts_on_the_reading_only() {
    let bench = moving();
    let without = bench.run(&[]);
    let mut tried = 0;
    for info in catalogue().iter().filter(|i| i.id.starts_with("sensor_") || i.id == "stale_samples") {
        let values = info.probes[info.probes.len() - 1];
        let with = bench.run(&[(info.id, values)]);
        assert_ne!(readings(&with), readings(&without), "{}", info.id);
        for (a, b) in with.iter().zip(&without) {
            assert_eq!((a.drive, a.draw), (b.drive, b.draw), "{}", info.id);
        }
        tried += 1;
    }
    assert!(tried >= 7, "{tried}");
}
