//! Cost of the truth plant. `cargo bench -p pneudrive-truth --bench plant`; divan prints steps of
//! one channel per second.

use divan::counter::ItemsCount;
use pneudrive_sim::record::{Recorder, RecordingSettings};
use pneudrive_truth::{ChannelId, Effect, Plant, PlantParameters};

fn main() {
    divan::main();
}

/// Steps of each channel in one measurement: 0.1 s of plant time.
const STEPS: u64 = 2000;

fn plant(effects: &[&str]) -> Plant {
    let effects: Vec<Effect> = effects.iter().map(|e| e.parse().expect("an effect")).collect();
    let mut plant = Plant::new(PlantParameters::default(), &effects, 1).expect("a valid plant");
    for (channel, drive) in [0.3, -0.1, 0.06, 0.0].into_iter().enumerate() {
        let channel = ChannelId::from_index(channel).expect("one of four");
        plant.set_drive(channel, drive).expect("a valid drive");
    }
    plant
}

fn advance(bencher: divan::Bencher<'_, '_>, effects: &[&str]) {
    bencher
        .counter(ItemsCount::new(4 * STEPS))
        .with_inputs(|| plant(effects))
        .bench_local_refs(|plant| plant.advance_to(STEPS * 50_000));
}

#[divan::bench]
fn everything_off(bencher: divan::Bencher<'_, '_>) {
    advance(bencher, &[]);
}

#[divan::bench]
fn energy_balance(bencher: divan::Bencher<'_, '_>) {
    advance(bencher, &["heat_exchange"]);
}

#[divan::bench]
fn all_volumes_lags_and_the_joint(bencher: divan::Bencher<'_, '_>) {
    let effects = [
        "supply_sag",
        "valve_lag",
        "heat_exchange",
        "line_restriction",
        "vent_restriction",
        "wall_compliance",
        "wall_creep",
        "chamber_coupling",
        "sensor_lag",
    ];
    advance(bencher, &effects);
}

/// A second of four channels at 100 Hz with the control crate's boards: the time per item is that
/// of a row.
#[divan::bench]
fn recording(bencher: divan::Bencher<'_, '_>) {
    let settings = RecordingSettings { seconds: 1.0, ..RecordingSettings::default() };
    bencher
        .counter(ItemsCount::new(100_u64))
        .bench_local(|| Recorder::new(&settings).expect("valid settings").map(|row| row.t_s).sum::<f64>());
}
