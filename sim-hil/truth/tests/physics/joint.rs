//! Joint and chambers that stretch.

use super::{ADIABATIC, C0, ISOTHERMAL, PAPER, build, ideal, ns};
use pneudrive_truth::{ChannelId, PlantParameters};

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
        let invariant = |t: &pneudrive_truth::ChannelTruth| t.pressure_pa * t.volume_m3.powf(n);
        assert!(after.volume_m3 > 1.03 * before.volume_m3);
        assert!((invariant(&after) / invariant(&before) - 1.0).abs() < 1e-5, "n = {n}");
    }
}
