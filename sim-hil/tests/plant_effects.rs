//! Every effect by name: nothing when null, something when on, and the something is what its physics says.
use pneudrive_sim::plant::{ChannelId, Effect, GasModel, Plant, PlantParameters, catalogue, counts12_to_kpa};
use pneudrive_sim::record::{Recorder, RecordingSettings, Row};

const AMBIENT: f64 = 101_325.0;

fn channel(channel: u8) -> ChannelId {
    ChannelId { board: 0, channel }
}

/// A quiet rig of four channels at `initial_kpa` with one effect.
fn rig(effect: &str, initial_kpa: f64) -> Plant {
    let mut p = PlantParameters::default();
    p.sensor.noise_kpa = 0.0;
    p.chamber.initial_kpa = initial_kpa;
    let effects: Vec<Effect> = (!effect.is_empty()).then(|| effect.parse().unwrap()).into_iter().collect();
    Plant::new(p, &effects, 1).unwrap()
}

/// Drives channel 0 for a time from where the plant is.
fn run(plant: &mut Plant, drive: f64, seconds: f64) {
    plant.set_drive(channel(0), drive).unwrap();
    let now = plant.time_ns();
    plant.advance_to(now + (seconds * 1e9).round() as u64);
}

fn kpa(plant: &Plant) -> f64 {
    1e-3 * (plant.truth(channel(0)).unwrap().pressure_pa - AMBIENT)
}

fn spool(plant: &Plant) -> f64 {
    plant.truth(channel(0)).unwrap().spool
}

fn supply_kpa(plant: &Plant) -> f64 {
    1e-3 * (plant.supply_pressure_pa() - AMBIENT)
}

/// Reading of a channel, kPa, from one sample of the board.
fn reading(plant: &mut Plant, index: usize) -> f64 {
    counts12_to_kpa(f64::from(plant.sample(0).unwrap()[index]))
}

/// Pressure after filling from `initial` for a time, with and without the effect.
fn filled(effect: &str, drive: f64, initial: f64, seconds: f64) -> [f64; 2] {
    ["", effect].map(|effect| {
        let mut plant = rig(effect, initial);
        run(&mut plant, drive, seconds);
        kpa(&plant)
    })
}

/// Flow into channel 0 in the first step at a drive, kg/s, with and without the effect.
fn flows(effect: &str, drive: f64, initial: f64) -> [f64; 2] {
    ["", effect].map(|effect| {
        let mut plant = rig(effect, initial);
        run(&mut plant, drive, 50e-6);
        let t = plant.truth(channel(0)).unwrap();
        if drive > 0.0 { t.fill_kg_per_s } else { t.vent_kg_per_s }
    })
}

fn near(got: f64, want: f64, tolerance: f64) {
    assert!((got - want).abs() <= tolerance, "{got}, expected {want} +- {tolerance}");
}

/// What each effect does to the quiet rig. The list is complete: an effect without a line fails.
fn assert_direction(id: &str) {
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
            // What the converter held of channel 0 shows up in channel 1, beside its own pressure (it leaks up by 1 kPa).
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
        "supply_level" => near(supply_kpa(&rig("supply_level=-50", 0.0)), 500.0, 1e-9),
        "exhaust_leak" => {
            let mut plant = rig("exhaust_leak=0.02", 300.0);
            run(&mut plant, 0.0, 50e-6);
            let leak = plant.truth(channel(0)).unwrap().leak_kg_per_s;
            near(leak, 0.02 * 3e-9 * 1.185 * 401_325.0, 1e-9);
            let [plain, with] = filled("exhaust_leak=0.02", 0.0, 300.0, 0.5);
            assert!(with < plain - 3.0, "{with} {plain}");
        }
        "fill_leak" => {
            let [plain, with] = filled("fill_leak=0.02", 0.0, 100.0, 0.5);
            assert!(with > plain + 5.0, "{with} {plain}");
        }
        "valve_gain" => {
            for drive in [1.0, -1.0] {
                let [plain, with] = flows("valve_gain=0.8", drive, 300.0);
                near(with / plain, 0.8, 1e-3);
            }
        }
        "valve_centre" => {
            let [plain, with] = filled("valve_centre=0.06", 0.0, 200.0, 0.5);
            assert!(with > plain + 5.0, "{with} {plain}");
            let [plain, with] = filled("valve_centre=-0.06", 0.0, 200.0, 0.5);
            assert!(with < plain - 2.0, "{with} {plain}");
        }
        "chamber_volume" => {
            let [plain, with] = filled("chamber_volume=1.2", 1.0, 0.0, 0.1);
            near(plain / with, 1.2, 1e-4); // but for what leaks past the vent edge
        }
        "sensor_offset" => near(reading(&mut rig("sensor_offset=5", 200.0), 0), 205.0, 0.11),
        "sensor_gain" => near(reading(&mut rig("sensor_gain=1.04", 200.0), 0), 208.0, 0.11),
        "line_water" => line_water(),
        "chamber_burst" => {
            let leak = |initial: f64| {
                let mut plant = rig("chamber_burst:growth=1,threshold_kpa=180", initial);
                run(&mut plant, 0.05, 1.0);
                plant.truth(channel(0)).unwrap().leak_kg_per_s
            };
            near(leak(100.0), 0.0, 0.0);
            // About 100 kPa above for a second: a hundredth of the open valve.
            near(leak(280.0), 0.01 * 3e-9 * 1.185 * 381_000.0, 2e-6);
        }
        "supply_temperature" => {
            let flow = ["", "supply_temperature:amplitude_k=60,period_s=4"].map(|effect| {
                let mut plant = rig(effect, 0.0);
                run(&mut plant, -1.0, 1.0);
                run(&mut plant, 1.0, 50e-6);
                plant.truth(channel(0)).unwrap().fill_kg_per_s
            });
            near(flow[1] / flow[0], (293.15_f64 / 353.15).sqrt(), 1e-4);
        }
        "spool_stick" => {
            let mut plant = rig("spool_stick:tear_off=0.15,position=0.15", 0.0);
            for (drive, expected) in [(0.1, 0.1), (0.25, 0.15), (0.02, 0.15), (-0.1, -0.1)] {
                run(&mut plant, drive, 0.001);
                near(spool(&plant), expected, 1e-12);
            }
        }
        "drive_crosstalk" => {
            let mut plant = rig("drive_crosstalk=0.1", 0.0);
            plant.set_drive(channel(3), 1.0).unwrap();
            run(&mut plant, 0.2, 0.001);
            near(spool(&plant), 0.3, 1e-12);
        }
        "coil_heating" => {
            let flow = ["", "coil_heating:loss=0.5,time_constant_s=1"].map(|effect| {
                let mut plant = rig(effect, 0.0);
                run(&mut plant, -1.0, 1.0);
                run(&mut plant, 1.0, 50e-6);
                plant.truth(channel(0)).unwrap().fill_kg_per_s
            });
            near(flow[1] / flow[0], 1.0 - 0.5 * (1.0 - (-1.0_f64).exp()), 1e-3);
        }
        "sensor_hysteresis" => {
            let mut plant = rig("sensor_hysteresis=3", 200.0);
            near(reading(&mut plant, 0), 200.0, 0.11);
            // Filled and vented: read too low, then too high.
            for (drive, error) in [(1.0, -3.0), (-1.0, 3.0)] {
                run(&mut plant, drive, 0.03);
                let kpa = 1e-3 * (plant.truth(channel(0)).unwrap().port_pa - AMBIENT);
                near(reading(&mut plant, 0), kpa + error, 0.11);
            }
        }
        "driver_resolution" => {
            let mut plant = rig("driver_resolution=0.1", 0.0);
            for (drive, expected) in [(0.17, 0.2), (0.04, 0.0), (-0.99, -1.0)] {
                run(&mut plant, drive, 0.001);
                near(spool(&plant), expected, 1e-12);
            }
        }
        "regulator_backlash" => regulator_backlash(),
        _ => panic!("no direction is asserted for {id}"),
    }
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

/// Filling channel 0 lengthens it and squeezes its partner, whose valve is shut; the other pair does not notice.
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

fn line_water() {
    let mut plant = rig("line_water:depth=0.5,gap_s=0.5,slug_s=0.5", 0.0);
    let mut blocked = 0;
    for k in 1..=200_u32 {
        run(&mut plant, if k % 2 == 0 { 1.0 } else { -1.0 }, 0.05);
        let t = plant.truth(channel(0)).unwrap();
        let open = 3e-9 * 1.0001 * 1.185 * 651_325.0;
        assert!(t.fill_kg_per_s <= 1.0001 * open);
        blocked += u32::from(k % 2 == 0 && t.fill_kg_per_s < 0.6 * open);
    }
    assert!((15..85).contains(&blocked), "{blocked} of 100");
}

fn regulator_backlash() {
    let mut plant = rig("regulator_backlash:band_kpa=60,tank_l=1,refill=3", 0.0);
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for k in 0..100_u32 {
        // Fill and vent in turn: air is drawn all the time.
        run(&mut plant, if k % 2 == 0 { 1.0 } else { -1.0 }, 0.4);
        low = low.min(supply_kpa(&plant));
        high = high.max(supply_kpa(&plant));
    }
    assert!(low < 545.0 && low > 505.0, "{low}");
    assert!(high > 560.0 && high < 582.0, "{high}");
}

fn recording(effect: Option<Effect>, seconds: f64) -> Vec<Row> {
    let settings = RecordingSettings {
        effects: effect.into_iter().collect(),
        seconds,
        seed: 11,
        ..RecordingSettings::default()
    };
    Recorder::new(&settings).unwrap().collect()
}

#[test]
fn each_effect_does_what_its_physics_says() {
    for definition in catalogue() {
        println!("{}", definition.id);
        assert_direction(definition.id);
    }
}

#[test]
fn null_effects_change_no_bit() {
    let plain = recording(None, 1.5);
    for definition in catalogue() {
        let null = Effect::null(definition.id).unwrap();
        assert!(null.is_null());
        assert!(
            recording(Some(null), 1.5) == plain,
            "{} at its null value changes the recording",
            definition.id
        );
    }
}

/// In a recording of 6 s, read through a sensor with 0.36 kPa of noise, every moderate effect is there.
#[test]
fn moderate_effects_change_the_recording() {
    let plain = recording(None, 6.0);
    for definition in catalogue() {
        let effect = Effect::moderate(definition.id).unwrap();
        assert!(!effect.is_null(), "{}", definition.id);
        let with = recording(Some(effect), 6.0);
        let squares = plain
            .iter()
            .zip(&with)
            .flat_map(|(a, b)| a.pressure_kpa.iter().zip(&b.pressure_kpa).map(|(a, b)| (a - b) * (a - b)));
        let rms = (squares.sum::<f64>() / (4.0 * plain.len() as f64)).sqrt();
        println!("{:20} {rms:.3} kPa", definition.id);
        assert!(rms > 0.05, "{}: {rms} kPa RMS", definition.id);
        // The commands are the same: an effect must not disturb another thing's random numbers.
        assert!(plain.iter().zip(&with).all(|(a, b)| a.command_kpa == b.command_kpa), "{}", definition.id);
    }
}

/// Limited to one channel, an effect of the channel leaves the others' truth alone.
#[test]
fn scoped_effects_stay_in_their_place() {
    let run = |effect: &str| {
        let mut plant = rig(effect, 0.0);
        for c in 0..4 {
            plant.set_drive(channel(c), 0.5).unwrap();
        }
        plant.advance_to(200_000_000);
        (0..4).map(|c| plant.truth(channel(c)).unwrap().pressure_pa).collect::<Vec<_>>()
    };
    let (plain, with) = (run(""), run("valve_gain=0.8@b0c2"));
    assert!(with[2] < plain[2] - 5e3, "{with:?} {plain:?}");
    for c in [0, 1, 3] {
        assert_eq!(plain[c].to_bits(), with[c].to_bits());
    }
}

/// The energy balance can be the rig's own gas model too, and the effect is the same thing.
#[test]
fn heat_exchange_is_the_energy_balance() {
    let mut p = PlantParameters {
        gas: GasModel::EnergyBalance { wall_time_constant_s: 0.5 },
        ..PlantParameters::default()
    };
    p.sensor.noise_kpa = 0.0;
    let mut own = Plant::new(p, &[], 1).unwrap();
    let mut effect = rig("heat_exchange=0.5", 0.0);
    run(&mut own, 0.8, 0.2);
    run(&mut effect, 0.8, 0.2);
    assert_eq!(own.truth(channel(0)).unwrap(), effect.truth(channel(0)).unwrap());
}
