//! The plant against closed forms, conservation laws and an independent integration of the paper's
//! model.

mod integration;
mod joint;

use pneudrive_truth::{
    ANR_DENSITY_KG_PER_M3, ChannelId, Effect, GasModel, Plant, PlantParameters, kpa_to_volts,
};

const R: f64 = 287.05;
const T: f64 = 293.15;
const GAMMA: f64 = 1.4;
const AMBIENT: f64 = 101_325.0;
const SUPPLY: f64 = 651_325.0;
const C0: ChannelId = ChannelId { board: 0, channel: 0 };

/// One channel, no leakage, sharp corners, no noise: what the closed forms assume.
fn ideal(gas: GasModel) -> PlantParameters {
    let mut p = PlantParameters { channels: 1, gas, ..PlantParameters::default() };
    p.valve.leakage = 0.0;
    p.valve.corner = 1e-4;
    p.sensor.noise_kpa = 0.0;
    p
}

fn build(p: PlantParameters, effects: &[&str]) -> Plant {
    let effects: Vec<Effect> = effects.iter().map(|e| e.parse().unwrap()).collect();
    Plant::new(p, &effects, 1).unwrap()
}

fn ns(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

const ISOTHERMAL: GasModel = GasModel::FixedTemperature { polytropic_exponent: 1.0 };
const PAPER: GasModel = GasModel::FixedTemperature { polytropic_exponent: 1.4 };
const ADIABATIC: GasModel = GasModel::EnergyBalance { wall_time_constant_s: f64::INFINITY };

/// While the fill edge is choked the pressure rises in a straight line:
/// `p_0 + n R T C rho_0 p_s / V t`.
#[test]
fn choked_filling_is_a_straight_line() {
    for (gas, n) in [(ISOTHERMAL, 1.0), (PAPER, 1.4), (ADIABATIC, 1.4)] {
        let p = ideal(gas);
        let volume = p.chamber.resting_volume_m3();
        let rate = n * R * T * 3.0e-9 * ANR_DENSITY_KG_PER_M3 * SUPPLY / volume;
        let mut plant = build(p, &[]);
        plant.set_drive(C0, 1.0).unwrap();
        plant.advance_to(ns(0.1));
        let got = plant.truth(C0).unwrap().pressure_pa - AMBIENT;
        assert!(got < 0.3 * SUPPLY - AMBIENT, "left the choked range: {got}");
        assert!((got / (0.1 * rate) - 1.0).abs() < 1e-6, "n = {n}: {got} for {}", 0.1 * rate);
    }
}

/// Filling an adiabatic chamber: `m = m_0 + m' t`, `T = p V / (m R)` with `V dp = gamma R T_0 dm`,
/// so `T = T_0 (p / p_0) / (1 + (p / p_0 - 1) / gamma)`, through a tube (which holds the air at
/// ambient temperature) or not.
#[test]
fn adiabatic_filling_heats_the_gas() {
    for effects in [&[][..], &["line_restriction:restriction=0.3,volume_ml=15"]] {
        let mut plant = build(ideal(ADIABATIC), effects);
        plant.set_drive(C0, 1.0).unwrap();
        plant.advance_to(ns(0.1));
        let truth = plant.truth(C0).unwrap();
        let ratio = truth.pressure_pa / AMBIENT;
        let expected = T * ratio / (1.0 + (ratio - 1.0) / GAMMA);
        assert!((truth.temperature_k - expected).abs() < 1e-3, "{} for {expected}", truth.temperature_k);
        assert!(expected > T + 25.0);
    }
}

/// Venting without heat is an isentropic expansion of what stays:
/// `T = T_0 (p / p_0)^((gamma - 1) / gamma)`, through a tube or not.
#[test]
fn adiabatic_venting_is_isentropic() {
    for effects in [&[][..], &["line_restriction:restriction=0.3,volume_ml=15"]] {
        let mut p = ideal(ADIABATIC);
        p.chamber.initial_kpa = 400.0;
        let p0 = AMBIENT + 400e3;
        let mut plant = build(p, effects);
        plant.set_drive(C0, -1.0).unwrap();
        plant.advance_to(ns(0.6));
        let truth = plant.truth(C0).unwrap();
        let expected = T * (truth.pressure_pa / p0).powf((GAMMA - 1.0) / GAMMA);
        assert!(truth.pressure_pa < 0.6 * p0);
        assert!((truth.temperature_k - expected).abs() < 1e-3, "{} for {expected}", truth.temperature_k);
    }
}

/// A shut chamber of hot gas cools exponentially with `m c_v / K`: the stated time constant, times
/// its mass over the mass at 250 kPa absolute and ambient temperature.
#[test]
fn shut_gas_cools_with_the_time_constant_of_the_wall() {
    let tau = 0.4;
    let p = ideal(GasModel::EnergyBalance { wall_time_constant_s: tau });
    let reference_kg = 250e3 * p.chamber.resting_volume_m3() / (R * T);
    let mut plant = build(p, &[]);
    plant.set_drive(C0, 1.0).unwrap();
    plant.advance_to(ns(0.2));
    plant.set_drive(C0, 0.0).unwrap();
    let hot = plant.truth(C0).unwrap();
    plant.advance_to(ns(0.5));
    let cooler = plant.truth(C0).unwrap();
    assert!((cooler.mass_kg / hot.mass_kg - 1.0).abs() < 1e-6 && hot.temperature_k > T + 15.0);
    let expected = (hot.temperature_k - T) * (-0.3 / (tau * hot.mass_kg / reference_kg)).exp();
    assert!(
        (cooler.temperature_k - T - expected).abs() < 1e-3,
        "{} for {expected}",
        cooler.temperature_k - T
    );
}

/// A wall much faster than the flow keeps the gas at its temperature: the balance becomes the
/// isothermal one, to first order in the time constant.
#[test]
fn a_fast_wall_is_the_isothermal_limit() {
    let after = |gas| {
        let mut plant = build(ideal(gas), &[]);
        plant.set_drive(C0, 0.3).unwrap();
        plant.advance_to(ns(0.5));
        plant.truth(C0).unwrap().pressure_pa
    };
    let isothermal = after(ISOTHERMAL);
    let off = |tau| after(GasModel::EnergyBalance { wall_time_constant_s: tau }) - isothermal;
    let (slow, fast) = (off(0.02), off(0.005));
    assert!(fast > 0.0 && fast < 500.0, "{fast}");
    assert!((slow / fast - 4.0).abs() < 0.4, "not first order: {slow} {fast}");
}

/// What the chamber, the tube and the muffler hold changes by what flowed, with every volume
/// switched on.
#[test]
fn mass_balance_closes() {
    let p = ideal(GasModel::EnergyBalance { wall_time_constant_s: 0.5 });
    let line_m3 = 15e-6;
    let mut plant = build(
        p,
        &[
            "line_restriction:restriction=0.8,volume_ml=15",
            "vent_restriction=0.8",
            "exhaust_leak=0.03",
            "wall_compliance=0.5",
        ],
    );
    let held = |plant: &Plant| {
        let t = plant.truth(C0).unwrap();
        t.mass_kg + t.port_pa * line_m3 / (R * T)
    };
    let net = |plant: &Plant| {
        let t = plant.truth(C0).unwrap();
        t.fill_kg_per_s - t.vent_kg_per_s - t.leak_kg_per_s
    };
    let start = held(&plant);
    let (mut flowed, mut gross) = (0.0, 0.0);
    for (drive, until) in [(0.8, 4000_u64), (-0.5, 7000), (0.3, 12_000)] {
        plant.set_drive(C0, drive).unwrap();
        let mut steps = plant.time_ns() / 50_000;
        // The new drive acts from the next step on: one step forward before the first sum.
        let mut before = None;
        while steps < until {
            steps += 1;
            plant.advance_to(steps * 50_000);
            let now = net(&plant);
            flowed += 50e-6 * before.map_or(now, |b| 0.5 * (b + now));
            gross += 50e-6 * now.abs();
            before = Some(now);
        }
    }
    let gained = held(&plant) - start;
    assert!(gross > 5e-4, "too little flowed to tell: {gross}");
    assert!((gained - flowed).abs() < 1e-4 * gross, "gained {gained}, flowed {flowed} of {gross} kg");
}

/// The isothermal limit conserves mass; the paper's limit moves the pressure 1.4 times as much for
/// the same flows.
#[test]
fn only_the_isothermal_fixed_temperature_conserves_mass() {
    for (gas, excess) in [(ISOTHERMAL, 1.0), (PAPER, 1.4)] {
        let mut plant = build(ideal(gas), &[]);
        let start = plant.truth(C0).unwrap().mass_kg;
        plant.set_drive(C0, 0.7).unwrap();
        let mut flowed = 0.0;
        for step in 1..=8000_u64 {
            let before = plant.truth(C0).unwrap();
            plant.advance_to(step * 50_000);
            let after = plant.truth(C0).unwrap();
            let net = |t: &pneudrive_truth::ChannelTruth| t.fill_kg_per_s - t.vent_kg_per_s;
            let first = if step == 1 { net(&after) } else { net(&before) };
            flowed += 25e-6 * (first + net(&after));
        }
        let gained = plant.truth(C0).unwrap().mass_kg - start;
        assert!((gained / flowed - excess).abs() < 1e-4, "{} for {excess}", gained / flowed);
    }
}

#[test]
fn filling_takes_some_tenths_of_a_second() {
    let mut plant = build(PlantParameters::default(), &[]);
    plant.set_drive(C0, 1.0).unwrap();
    let mut k = 0_u64;
    while plant.truth(C0).unwrap().pressure_pa - AMBIENT < 300e3 {
        k += 1;
        plant.advance_to(k * 1_000_000);
    }
    assert!((405..=412).contains(&k), "{k} ms");
}

#[test]
fn requests_for_what_is_not_there_are_refused() {
    let mut plant = build(PlantParameters { channels: 6, ..PlantParameters::default() }, &[]);
    assert_eq!((plant.boards(), plant.channels()), (2, 6));
    let gone = ChannelId { board: 1, channel: 2 };
    let text = plant.set_drive(gone, 0.0).unwrap_err().to_string();
    assert!(text.contains("no channel b1c2") && text.contains("6 channels"), "{text}");
    assert!(plant.truth(ChannelId { board: 0, channel: 4 }).is_err());
    assert!(plant.sample(2).unwrap_err().to_string().contains("no board 2"));
    assert!(plant.set_drive(C0, 1.01).unwrap_err().to_string().contains("1.01"));
    assert!(plant.set_drive(C0, f64::NAN).is_err());
    // Missing channels of a board that is there read 0 kPa.
    let counts = plant.sample(1).unwrap();
    assert_eq!(counts[2], (kpa_to_volts(0.0) / 5.0 * 4096.0).round() as u16);
}

#[test]
fn volumes_too_fast_for_the_step_are_refused() {
    let effect: Effect = "line_restriction:restriction=0.01,volume_ml=2".parse().unwrap();
    let text = Plant::new(PlantParameters::default(), &[effect], 1).unwrap_err().to_string();
    assert!(text.contains("the tube of b0c0") && text.contains("step_ns"), "{text}");
    let effect: Effect = "heat_exchange=0.00001".parse().unwrap();
    let text = Plant::new(PlantParameters::default(), &[effect], 1).unwrap_err().to_string();
    assert!(text.contains("gas temperature"), "{text}");
    let missing: Effect = "valve_lag=0.1@b1".parse().unwrap();
    let text = Plant::new(PlantParameters::default(), &[missing], 1).unwrap_err().to_string();
    assert!(text.contains("no b1 in a plant of 4 channels"), "{text}");
    let twice: Vec<Effect> =
        ["valve_lag=0.1", "valve_lag=0.2@b0c1"].iter().map(|e| e.parse().unwrap()).collect();
    let text = Plant::new(PlantParameters::default(), &twice, 1).unwrap_err().to_string();
    assert!(text.contains("valve_lag is given twice for b0c1"), "{text}");
}
