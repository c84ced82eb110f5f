//! What the structural effects of the catalogue do.

use super::bench::{AMBIENT, channel, filled, flows, kpa, near, reading, rig, run, spool, supply_kpa};
use pneudrive_truth::{Effect, Plant, PlantParameters};

/// Asserts it of an effect of this group; `false` of another.
pub fn assert_direction(id: &str) -> bool {
    match id {
        "supply_sag" => supply_sag(),
        "supply_ripple" => supply_ripple(),
        "transport_delay" => {
            let mut plant = rig("transport_delay=0.012", 0.0);
            run(&mut plant, 1.0, 0.012);
            near(spool(&plant), 0.0, 0.0);
            run(&mut plant, 1.0, 50e-6);
            near(spool(&plant), 1.0, 0.0);
        }
        "valve_lag" => {
            let mut plant = rig("valve_lag=0.02", 0.0);
            run(&mut plant, 1.0, 0.02);
            near(spool(&plant), 1.0 - (-1.0_f64).exp(), 1e-9);
        }
        "valve_hysteresis" => {
            let mut plant = rig("valve_hysteresis=0.05", 0.0);
            for (drive, expected) in [(0.5, 0.45), (0.42, 0.45), (0.3, 0.35)] {
                run(&mut plant, drive, 0.001);
                near(spool(&plant), expected, 1e-12);
            }
        }
        "valve_stiction" => {
            let mut plant = rig("valve_stiction=0.06", 0.0);
            for (drive, expected) in [(0.05, 0.0), (0.07, 0.07), (0.12, 0.07)] {
                run(&mut plant, drive, 0.001);
                near(spool(&plant), expected, 1e-12);
            }
        }
        "drive_saturation" => {
            let mut plant = rig("drive_saturation=0.7", 0.0);
            run(&mut plant, 1.0, 0.001);
            near(spool(&plant), 0.7, 0.0);
            run(&mut plant, 0.6, 0.001);
            near(spool(&plant), 0.6, 0.0);
        }
        "valve_asymmetry" => {
            let [plain, with] = flows("valve_asymmetry=0.7", -1.0, 300.0);
            near(with / plain, 0.7, 0.001);
            let [plain, with] = flows("valve_asymmetry=0.7", 1.0, 0.0);
            near(with / plain, 1.0, 1e-12);
        }
        "vent_restriction" => {
            let [plain, with] = filled("vent_restriction=0.8", -1.0, 400.0, 0.6);
            assert!(with > plain + 20.0, "venting is not slower: {with} {plain}");
            let [plain, with] = filled("vent_restriction=0.8", 1.0, 0.0, 0.3);
            near(with, plain, 0.2);
        }
        "flow_function" => {
            let [plain, with] = flows("flow_function=0.2", 1.0, 0.0);
            near(with / plain, 1.0, 1e-12); // choked: no difference
            let [plain, with] = flows("flow_function=0.2", 1.0, 450.0);
            assert!(with > 1.05 * plain, "a higher critical ratio passes more below it");
            let [plain, with] =
                flows("flow_function:critical_ratio_change=0,exponent_change=0.1", 1.0, 450.0);
            assert!(with < 0.98 * plain, "a higher exponent passes less");
        }
        "heat_exchange" => heat_exchange(),
        "wall_compliance" => {
            let mut plant = rig("wall_compliance=0.8", 0.0);
            run(&mut plant, 1.0, 0.3);
            let volume = plant.truth(channel(0)).unwrap().volume_m3;
            near(
                volume / PlantParameters::default().chamber.resting_volume_m3(),
                1.0 + 0.8e-3 * kpa(&plant),
                1e-9,
            );
            let [plain, with] = filled("wall_compliance=0.8", 1.0, 0.0, 0.3);
            assert!(with < 0.95 * plain, "a growing chamber fills more slowly: {with} {plain}");
        }
        "wall_creep" => wall_creep(),
        "chamber_coupling" => chamber_coupling(),
        "line_restriction" => {
            let mut plant = rig("line_restriction=0.8", 0.0);
            run(&mut plant, 1.0, 0.1);
            let t = plant.truth(channel(0)).unwrap();
            assert!(t.port_pa > t.pressure_pa + 20e3, "the sensor runs ahead of the chamber: {t:?}");
            let port = 1e-3 * (t.port_pa - AMBIENT);
            near(reading(&mut plant, 0), port, 0.11);
        }
        "sensor_lag" => {
            // A ramp of 754 kPa/s is read 754 tau low.
            let mut plant = rig("sensor_lag=0.02", 0.0);
            run(&mut plant, 1.0, 0.12);
            let behind = kpa(&plant) - reading(&mut plant, 0);
            near(behind, 0.02 * 754.0, 0.5);
        }
        "sensor_nonlinearity" => {
            let x: f64 = 300.0 / 689.475_7;
            near(reading(&mut rig("sensor_nonlinearity=25", 300.0), 0), 300.0 + 100.0 * x * (1.0 - x), 0.11);
        }
        "sensor_drift" => {
            let mut plant = rig("sensor_drift:final_kpa=20,time_constant_s=2", 0.0);
            run(&mut plant, -1.0, 2.0);
            near(reading(&mut plant, 0), 20.0 * (1.0 - (-1.0_f64).exp()), 0.11);
        }
        "sensor_crosstalk" => {
            // Channel 0 at 300 kPa, the others empty: channel 1 follows it in the scan.
            let mut plant = rig("sensor_crosstalk=0.04", 0.0);
            run(&mut plant, 1.0, 0.42);
            let own = kpa(&plant);
            near(reading(&mut plant, 0), 0.96 * own, 0.2);
            // What the converter held of channel 0 shows up in channel 1, beside its own pressure
            // (it leaks up by 1 kPa).
            let other = |c| 1e-3 * (plant.truth(channel(c)).unwrap().pressure_pa - AMBIENT);
            let expected = [0.96 * other(1) + 0.04 * 0.96 * own, 0.96 * other(2)];
            near(reading(&mut plant, 1), expected[0], 0.2);
            near(reading(&mut plant, 2), expected[1], 0.8);
        }
        "valve_wear" => {
            let later = ["", "valve_wear:change_per_100_s=-0.15"].map(|effect| {
                let mut plant = rig(effect, 0.0);
                run(&mut plant, -1.0, 20.0);
                run(&mut plant, 1.0, 100e-6);
                plant.truth(channel(0)).unwrap().fill_kg_per_s
            });
            near(later[1] / later[0], 0.85_f64.powf(0.2), 1e-3);
        }
        "stale_samples" => stale_samples(),
        _ => return false,
    }
    true
}

/// One open valve into an empty chamber draws 2.3 g/s less the sag itself.
fn supply_sag() {
    let mut plant = rig("supply_sag:drop_kpa=40,lag_s=0.02", 0.0);
    near(supply_kpa(&plant), 550.0, 1e-6);
    run(&mut plant, 1.0, 0.12);
    let sag = 550.0 - supply_kpa(&plant);
    near(sag, 38.0, 1.0);
    // All four valves sag more, and it goes back when they shut.
    for other in 1..4 {
        plant.set_drive(channel(other), 1.0).unwrap();
    }
    run(&mut plant, 1.0, 0.1);
    assert!(550.0 - supply_kpa(&plant) > 2.5 * sag);
    for other in 1..4 {
        plant.set_drive(channel(other), -1.0).unwrap();
    }
    run(&mut plant, -1.0, 0.5);
    near(supply_kpa(&plant), 550.0, 1.0);
}

fn supply_ripple() {
    let mut plant = rig("supply_ripple:amplitude_kpa=20,period_s=2", 0.0);
    let x: Vec<f64> = (0..200)
        .map(|_| {
            run(&mut plant, 0.0, 0.01);
            supply_kpa(&plant)
        })
        .collect();
    let (low, high) = x.iter().fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
    near(low, 530.0, 0.6);
    near(high, 570.0, 1.4);
    let rising = x.windows(2).filter(|w| w[1] > w[0]).count();
    assert!((55..=65).contains(&rising), "rises for 30 % of the period: {rising}");
}

/// A fast filling heats the gas; with the valve shut it cools and the pressure falls.
fn heat_exchange() {
    let mut plant = rig("heat_exchange=0.5", 0.0);
    run(&mut plant, 1.0, 0.3);
    let hot = plant.truth(channel(0)).unwrap();
    assert!(hot.temperature_k > 293.15 + 20.0, "{hot:?}");
    let before = kpa(&plant);
    run(&mut plant, 0.0, 1.0);
    assert!(kpa(&plant) < before - 15.0, "{} {before}", kpa(&plant));
    // A slow wall stays hotter than a fast one.
    let temperature = |effect: &str| {
        let mut plant = rig(effect, 0.0);
        run(&mut plant, 1.0, 0.3);
        plant.truth(channel(0)).unwrap().temperature_k
    };
    assert!(
        temperature("heat_exchange=5") > hot.temperature_k
            && temperature("heat_exchange=0.05") < hot.temperature_k
    );
}

fn wall_creep() {
    let mut plant = rig("wall_creep:compliance_per_mpa=0.8,time_constant_s=1", 0.0);
    let resting = PlantParameters::default().chamber.resting_volume_m3();
    run(&mut plant, 1.0, 0.3);
    let early = plant.truth(channel(0)).unwrap().volume_m3 / resting;
    let before = kpa(&plant);
    run(&mut plant, 0.0, 3.0);
    let late = plant.truth(channel(0)).unwrap().volume_m3 / resting;
    assert!(early < 1.05 && late > 1.12, "{early} {late}");
    assert!(kpa(&plant) < before - 15.0, "a creeping wall lets the pressure down");
}

/// Filling channel 0 lengthens it and squeezes its partner, whose valve is shut; the other pair
/// does not notice.
fn chamber_coupling() {
    let mut plant = rig("chamber_coupling=1.5", 100.0);
    run(&mut plant, 1.0, 0.8);
    let [qu, qv] = plant.joint_angles(0).unwrap();
    assert!(qu > 0.3 && qv.abs() < 1e-9, "{qu} {qv}");
    let resting = PlantParameters::default().chamber.resting_volume_m3();
    let volume = |c| plant.truth(channel(c)).unwrap().volume_m3 / resting;
    assert!(volume(0) > 1.05 && volume(1) < 0.95);
    near(volume(2), 1.0, 1e-9);
    let pressure = |c| plant.truth(channel(c)).unwrap().pressure_pa;
    assert!(pressure(1) > pressure(2) + 5e3);
}

/// With coarse noise two fresh samples are hardly ever equal, so repeats are stale.
fn stale_samples() {
    let share = |effect: &str| {
        let mut p = PlantParameters { channels: 1, ..PlantParameters::default() };
        p.sensor.noise_kpa = 15.0;
        p.chamber.initial_kpa = 300.0;
        let effects: Vec<Effect> =
            (!effect.is_empty()).then(|| effect.parse().unwrap()).into_iter().collect();
        let mut plant = Plant::new(p, &effects, 1).unwrap();
        let mut last = 0;
        let mut repeats = 0;
        for k in 1..=20_000_u64 {
            plant.advance_to(k * 1_000_000);
            let now = plant.sample(0).unwrap()[0];
            repeats += u32::from(now == last);
            last = now;
        }
        f64::from(repeats) / 20_000.0
    };
    assert!(share("") < 0.01);
    // 20 s at a share of 0.3 are some 300 spells of 20 ms: 6 % standard error.
    near(share("stale_samples:share=0.3,spell_s=0.02"), 0.3, 0.06);
}
