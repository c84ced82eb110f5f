//! The integrator: rest, an independent integration of the paper's model, order, and steps.

use super::{AMBIENT, C0, GAMMA, R, SUPPLY, T, build, ns};
use pneudrive_truth::{ANR_DENSITY_KG_PER_M3, ChannelId, PlantParameters};

/// At rest the two edges pass the same flow, from either side. The pressure is found here by
/// bisection on the ISO 6358 formula.
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

/// The paper's model, written down again with areas, `psi` and a fixed temperature, and integrated
/// at 100 kHz.
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

/// Where nothing kinks (choked filling, a lagging spool past its corner) the error falls with the
/// fourth power of the step.
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
