//! A quiet rig with one effect, and what is read off it.

use pneudrive_truth::{ChannelId, Effect, Plant, PlantParameters, counts12_to_kpa};

pub const AMBIENT: f64 = 101_325.0;

pub fn channel(channel: u8) -> ChannelId {
    ChannelId { board: 0, channel }
}

/// A quiet rig of four channels at `initial_kpa` with one effect.
pub fn rig(effect: &str, initial_kpa: f64) -> Plant {
    let mut p = PlantParameters::default();
    p.sensor.noise_kpa = 0.0;
    p.chamber.initial_kpa = initial_kpa;
    let effects: Vec<Effect> = (!effect.is_empty()).then(|| effect.parse().unwrap()).into_iter().collect();
    Plant::new(p, &effects, 1).unwrap()
}

/// Drives channel 0 for a time from where the plant is.
pub fn run(plant: &mut Plant, drive: f64, seconds: f64) {
    plant.set_drive(channel(0), drive).unwrap();
    let now = plant.time_ns();
    plant.advance_to(now + (seconds * 1e9).round() as u64);
}

pub fn kpa(plant: &Plant) -> f64 {
    1e-3 * (plant.truth(channel(0)).unwrap().pressure_pa - AMBIENT)
}

pub fn spool(plant: &Plant) -> f64 {
    plant.truth(channel(0)).unwrap().spool
}

pub fn supply_kpa(plant: &Plant) -> f64 {
    1e-3 * (plant.supply_pressure_pa() - AMBIENT)
}

/// Reading of a channel, kPa, from one sample of the board.
pub fn reading(plant: &mut Plant, index: usize) -> f64 {
    counts12_to_kpa(f64::from(plant.sample(0).unwrap()[index]))
}

/// Pressure after filling from `initial` for a time, with and without the effect.
pub fn filled(effect: &str, drive: f64, initial: f64, seconds: f64) -> [f64; 2] {
    ["", effect].map(|effect| {
        let mut plant = rig(effect, initial);
        run(&mut plant, drive, seconds);
        kpa(&plant)
    })
}

/// Flow into channel 0 in the first step at a drive, kg/s, with and without the effect.
pub fn flows(effect: &str, drive: f64, initial: f64) -> [f64; 2] {
    ["", effect].map(|effect| {
        let mut plant = rig(effect, initial);
        run(&mut plant, drive, 50e-6);
        let t = plant.truth(channel(0)).unwrap();
        if drive > 0.0 { t.fill_kg_per_s } else { t.vent_kg_per_s }
    })
}

pub fn near(got: f64, want: f64, tolerance: f64) {
    assert!((got - want).abs() <= tolerance, "{got}, expected {want} +- {tolerance}");
}
