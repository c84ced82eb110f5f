//! The plant against closed forms, conservation laws and an independent integration of the paper's model.
use pneudrive_sim::plant::{
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

/// While the fill edge is choked the pressure rises in a straight line: `p_0 + n R T C rho_0 p_s / V t`.
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

/// Filling an adiabatic chamber: `m = m_0 + m' t`, `T = p V / (m R)` with `V dp = gamma R T_0 dm`, so
/// `T = T_0 (p / p_0) / (1 + (p / p_0 - 1) / gamma)`, through a tube (which holds the air at ambient temperature) or not.
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

/// Venting without heat is an isentropic expansion of what stays: `T = T_0 (p / p_0)^((gamma - 1) / gamma)`, through a tube or not.
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

/// A shut chamber of hot gas cools exponentially with `m c_v / K`: the stated time constant, times its mass over the mass at 250 kPa
/// absolute and ambient temperature.
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

/// A wall much faster than the flow keeps the gas at its temperature: the balance becomes the isothermal one, to first
/// order in the time constant.
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

/// What the chamber, the tube and the muffler hold changes by what flowed, with every volume switched on.
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

/// The isothermal limit conserves mass; the paper's limit moves the pressure 1.4 times as much for the same flows.
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
            let net = |t: &pneudrive_sim::plant::ChannelTruth| t.fill_kg_per_s - t.vent_kg_per_s;
            let first = if step == 1 { net(&after) } else { net(&before) };
            flowed += 25e-6 * (first + net(&after));
        }
        let gained = plant.truth(C0).unwrap().mass_kg - start;
        assert!((gained / flowed - excess).abs() < 1e-4, "{} for {excess}", gained / flowed);
    }
}

/// At rest the two edges pass the same flow, from either side. The pressure is found here by bisection on the ISO 6358 formula.
#[test]
fn steady_state_balances_the_edges() {
    let mut p = PlantParameters { channels: 1, ..PlantParameters::default() };
    p.valve.leakage = 0.02;
    p.valve.corner = 0.05;
    p.chamber.radius_m = 0.008; // settles nine times as fast
    let edge = |y: f64| 0.02 + 0.5 * ((y - 0.02) + ((y - 0.02_f64).powi(2) + 0.05_f64.powi(2)).sqrt());
    let drive = -0.01;
    let (fill, vent) = (edge((drive - 0.05) / 0.95), edge((-0.05 - drive) / 0.95));
    let phi = |r: f64| {
        let x = ((r - 0.3) / 0.7).max(0.0);
        (1.0 - x * x).sqrt()
    };
    let (mut low, mut high) = (AMBIENT, SUPPLY);
    for _ in 0..60 {
        let mid = 0.5 * (low + high);
        let net = fill * SUPPLY * phi(mid / SUPPLY) - vent * mid * phi(AMBIENT / mid);
        if net > 0.0 { low = mid } else { high = mid }
    }
    assert!(low > AMBIENT + 100e3 && low < SUPPLY - 50e3, "{low}");
    for initial in [0.0, 540.0] {
        let mut p = p.clone();
        p.chamber.initial_kpa = initial;
        let mut plant = build(p, &[]);
        plant.set_drive(C0, drive).unwrap();
        plant.advance_to(ns(120.0));
        let got = plant.truth(C0).unwrap().pressure_pa;
        assert!((got - low).abs() < 1.0, "from {initial} kPa: {got} for {low}");
    }
}

/// The paper's model, written down again with areas, `psi` and a fixed temperature, and integrated at 100 kHz.
#[test]
fn with_everything_off_the_plant_is_the_papers_model() {
    let drives = [0.6, -0.25, 0.12, 1.0, -1.0, 0.055, -0.04, 0.3];
    let mut plant = build(PlantParameters { channels: 1, ..PlantParameters::default() }, &[]);

    let psi_max = (2.0 / (GAMMA + 1.0)).powf(1.0 / (GAMMA - 1.0)) * (GAMMA / (GAMMA + 1.0)).sqrt();
    let per_area = psi_max * (2.0 / (R * T)).sqrt();
    // A C_d of a conductance of 3e-9 m^3/(s Pa): about 1.5 mm^2.
    let area = 3.0e-9 * ANR_DENSITY_KG_PER_M3 / per_area;
    assert!((area - 1.506e-6).abs() < 1e-9, "{area}");
    let volume = core::f64::consts::PI * 0.024 * 0.024 * 0.2;
    let (leak, corner, slope) = (0.002 * area, 0.02 * area, area / 0.95);
    let smax = |x: f64| 0.5 * (x + (x * x + corner * corner).sqrt());
    let psi = |r: f64| {
        let ellipse = |r: f64| (1.0 - ((r - 0.3) / 0.7_f64).powi(2)).sqrt();
        if r <= 0.3 {
            1.0
        } else if r < 0.999 {
            ellipse(r)
        } else {
            ellipse(0.999) * (1.0 - r) / 0.001
        }
    };
    let rate = |p: f64, u: f64| {
        let fill = leak + smax(slope * (u - 0.05) - leak);
        let vent = leak + smax(slope * (-0.05 - u) - leak);
        GAMMA * R * T / volume * per_area * (fill * SUPPLY * psi(p / SUPPLY) - vent * p * psi(AMBIENT / p))
    };
    let mut p = AMBIENT;
    let mut worst = 0.0_f64;
    for (k, u) in drives.into_iter().enumerate() {
        plant.set_drive(C0, u).unwrap();
        for piece in 1..=10 {
            for _ in 0..2500 {
                let h = 1e-5;
                let k1 = rate(p, u);
                let k2 = rate(p + 0.5 * h * k1, u);
                let k3 = rate(p + 0.5 * h * k2, u);
                let k4 = rate(p + h * k3, u);
                p += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            }
            plant.advance_to(ns(0.25 * k as f64 + 0.025 * f64::from(piece)));
            worst = worst.max((plant.truth(C0).unwrap().pressure_pa - p).abs());
        }
    }
    assert!(worst < 0.05, "worst difference {worst} Pa");
}

/// Halving the step changes nothing that matters, with every volume, lag and the joint switched on.
#[test]
fn halving_the_step_changes_little() {
    let effects = [
        "supply_sag=40",
        "valve_lag=0.01",
        "transport_delay=0.01",
        "heat_exchange=0.3",
        "line_restriction=0.8",
        "vent_restriction=0.8",
        "wall_compliance=0.5",
        "wall_creep=0.5",
        "chamber_coupling=1.5",
        "sensor_lag=0.01",
    ];
    let run = |step_ns: u64| {
        let mut plant = build(PlantParameters { step_ns, ..PlantParameters::default() }, &effects);
        let mut out = Vec::new();
        for (k, drive) in [0.9, -0.3, 0.15, -1.0, 0.4, 1.0].into_iter().enumerate() {
            for channel in 0..4 {
                let sign = if channel % 2 == 0 { 1.0 } else { -0.6 };
                plant.set_drive(ChannelId { board: 0, channel }, sign * drive).unwrap();
            }
            for piece in 1..=5 {
                plant.advance_to(ns(0.2 * k as f64 + 0.04 * f64::from(piece)));
                for channel in 0..4 {
                    out.push(plant.truth(ChannelId { board: 0, channel }).unwrap().pressure_pa);
                }
            }
        }
        out
    };
    let worst = |a: &[f64], b: &[f64]| a.iter().zip(b).fold(0.0_f64, |w, (a, b)| w.max((a - b).abs()));
    let (coarse, usual, fine) = (run(100_000), run(50_000), run(25_000));
    let (at_100, at_50) = (worst(&coarse, &fine), worst(&usual, &fine));
    assert!(at_50 < 5.0, "50 us against 25 us: {at_50} Pa");
    assert!(at_100 > at_50, "{at_100} {at_50}");
}

/// Where nothing kinks (choked filling, a lagging spool past its corner) the error falls with the fourth power of the step.
#[test]
fn the_error_falls_with_the_fourth_power() {
    let run = |step_ns: u64| {
        let mut p = PlantParameters { channels: 1, step_ns, ..PlantParameters::default() };
        p.chamber.initial_kpa = 50.0;
        p.valve.spool_time_constant_s = 0.002;
        p.valve.corner = 0.3;
        let mut plant = build(p, &[]);
        plant.set_drive(C0, 0.6).unwrap();
        plant.advance_to(ns(0.02));
        plant.truth(C0).unwrap().pressure_pa
    };
    let fine = run(10_000);
    let (coarse, half) = ((run(200_000) - fine).abs(), (run(100_000) - fine).abs());
    assert!(coarse / half > 12.0 && coarse / half < 20.0, "{coarse} {half}");
}

/// The joint rests at compliance times difference, and rings at its damped frequency.
#[test]
fn joint_follows_the_pressure_difference() {
    let mut p = PlantParameters { channels: 2, ..PlantParameters::default() };
    p.joint.free = true;
    p.joint.damping_ratio = 0.1;
    let mut plant = build(p, &[]);
    plant.set_drive(C0, 1.0).unwrap();
    // By 1.5 s the pressure stands at the supply's and the joint rings on.
    let mut peaks = Vec::new();
    let mut last = [0.0; 2];
    for k in 1..=3000_u32 {
        plant.advance_to(ns(0.001 * f64::from(k)));
        let [angle, other] = plant.joint_angles(0).unwrap();
        assert!(other.abs() < 1e-12);
        if k > 1200 && last[1] > last[0] && last[1] > angle {
            peaks.push(0.001 * f64::from(k - 1));
        }
        last = [last[1], angle];
    }
    // 1 / (1.5 Hz sqrt(1 - 0.1^2)) = 0.670 s; the gas shut in channel 1 stiffens it by 1 to 3 %.
    assert!(peaks.len() >= 2, "{peaks:?}");
    let period = peaks[1] - peaks[0];
    assert!((0.645..0.668).contains(&period), "{period}");
    plant.advance_to(ns(30.0));
    let difference = {
        let other = ChannelId { board: 0, channel: 1 };
        plant.truth(C0).unwrap().pressure_pa - plant.truth(other).unwrap().pressure_pa
    };
    let [angle, _] = plant.joint_angles(0).unwrap();
    assert!((angle - 1e-6 * difference).abs() < 1e-4, "{angle} for {difference}");
    let truth = plant.truth(C0).unwrap();
    let volume = core::f64::consts::PI * 0.024 * 0.024 * (0.2 + 0.045 * angle);
    assert!((truth.volume_m3 - volume).abs() < 1e-12);
}

/// A closed chamber that is stretched obeys `p V^n = const`.
#[test]
fn stretching_a_closed_chamber_is_polytropic() {
    for (gas, n) in [(PAPER, 1.4), (ISOTHERMAL, 1.0), (ADIABATIC, 1.4)] {
        let mut p = ideal(gas);
        p.channels = 2;
        p.joint.free = true;
        p.chamber.initial_kpa = 200.0;
        let mut plant = build(p, &[]);
        // Venting channel 1 bends the joint and lengthens channel 0, whose valve is shut.
        let before = plant.truth(C0).unwrap();
        plant.set_drive(ChannelId { board: 0, channel: 1 }, -1.0).unwrap();
        plant.advance_to(ns(1.5));
        let after = plant.truth(C0).unwrap();
        let invariant = |t: &pneudrive_sim::plant::ChannelTruth| t.pressure_pa * t.volume_m3.powf(n);
        assert!(after.volume_m3 > 1.03 * before.volume_m3);
        assert!((invariant(&after) / invariant(&before) - 1.0).abs() < 1e-5, "n = {n}");
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

/// How the calls are spaced does not matter, only the grid points at which drives change.
#[test]
fn spacing_of_calls_changes_no_bit() {
    let effects = ["supply_ripple", "sensor_lag", "line_water", "valve_lag", "supply_sag"];
    let mut whole = build(PlantParameters::default(), &effects);
    let mut pieces = build(PlantParameters::default(), &effects);
    whole.set_drive(C0, 0.5).unwrap();
    pieces.set_drive(C0, 0.5).unwrap();
    whole.advance_to(300_000_000);
    for k in 0..=30_000_000 / 12_345 {
        pieces.advance_to(k * 123_450);
    }
    pieces.advance_to(300_000_000);
    assert_eq!(whole.truth(C0).unwrap(), pieces.truth(C0).unwrap());
    assert_eq!(whole.sample(0).unwrap(), pieces.sample(0).unwrap());
    pieces.advance_to(10);
    assert_eq!(pieces.time_ns(), 300_000_000);
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
