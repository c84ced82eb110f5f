//! The extended model leaves as a file and comes back as a simulation: what was measured on the
//! test blocks is what `extended.toml` simulates, from drives or commands alone, neighbours
//! included.

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::diagnosis::{
    Diagnosis, ExtendedFile, Purpose, Request, Role, SimulatedChannel, diagnose, simulate_extended,
};
use pneudrive_model::rig::Rig;
use pneudrive_sim::plant::{Effect, Nuisances};
use pneudrive_sim::record::{Columns, Loop, Recorder, RecordingSettings, rig_toml, write_csv};

/// A recording of the truth plant with `effect` hidden in it, diagnosed; and its extended model
/// simulated from the file, without the measured pressures but for the first.
fn round_trip(effect: &str, control_loop: Loop, drive: bool) -> (Diagnosis, Vec<SimulatedChannel>) {
    let defaults = RecordingSettings::default();
    let mut plant = defaults.plant.clone();
    plant.channels = 2;
    plant.nuisances = Nuisances::laboratory();
    let settings = RecordingSettings {
        plant,
        effects: vec![effect.parse::<Effect>().unwrap()],
        seed: 31,
        seconds: 40.0,
        control_loop,
        columns: Columns { drive, ..Columns::default() },
        ..defaults
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    write_csv(&file, 2, settings.columns, Recorder::new(&settings).unwrap()).unwrap();
    let rig = Rig::parse("rig.toml", &rig_toml(&settings).unwrap()).unwrap();
    let recording = load(&file, LoadOptions::default()).unwrap().recording;
    let diagnosis = diagnose(&recording, &rig, Request::default(), &|_, _| {}).unwrap();

    let saved = folder.path().join("extended.toml");
    diagnosis.extended.save(&saved).unwrap();
    let read = ExtendedFile::load(&saved).unwrap();
    let mut commands = recording;
    for channel in &mut commands.channels {
        let pressure = channel.pressure_kpa.as_mut().unwrap();
        pressure[1..].fill(f32::NAN);
    }
    let purpose = Purpose::Simulate { start_kpa: 0.0, controller: !drive };
    let simulated = simulate_extended("extended.toml", &read, &commands, &read.rig, purpose).unwrap();
    (diagnosis, simulated)
}

/// Root mean square, on the test blocks, of the difference between what the diagnosis compared and
/// what the file simulates, and of the residual itself, kPa.
fn on_test_blocks(diagnosis: &Diagnosis, simulated: &[SimulatedChannel]) -> (f64, f64) {
    let (mut apart, mut residual, mut count) = (0.0, 0.0, 0.0_f64);
    for ((data, model), simulated) in diagnosis.channels.iter().zip(&diagnosis.extended_models).zip(simulated)
    {
        assert_eq!(data.id, simulated.id);
        // A file begins with the first row, and is set to no other.
        let mut from_the_first_row = data.clone();
        from_the_first_row.inputs.anchors = [].into();
        let compared = from_the_first_row.readings(model);
        let tests = data.blocks.iter().zip(&data.spans).filter(|(block, _)| block.role == Role::Test);
        for row in tests.flat_map(|(_, span)| span.clone()) {
            let from_file = simulated.kpa[data.rows[row] as usize];
            apart += (from_file - compared[row]).powi(2);
            residual += (data.measured_kpa[row] - compared[row]).powi(2);
            count += 1.0;
        }
    }
    ((apart / count).sqrt(), (residual / count).sqrt())
}

#[track_caller]
fn assert_the_same(effect: &str, control_loop: Loop, drive: bool) {
    let (diagnosis, simulated) = round_trip(effect, control_loop, drive);
    let named: Vec<&str> = diagnosis.report.causes.iter().map(|c| c.effect.as_str()).collect();
    assert!(!named.is_empty(), "{}", diagnosis.report.sentence);
    let (apart, residual) = on_test_blocks(&diagnosis, &simulated);
    assert!(apart < 0.1 * residual, "{named:?}: {apart} kPa apart, residual {residual} kPa");
}

/// Channels that draw from one supply: the file's simulation has to find by itself what the others
/// draw.
#[test]
fn a_supply_that_all_channels_share() {
    assert_the_same("supply_sag", Loop::Row, true);
}

/// From commands, through the board's loop.
#[test]
fn play_in_the_boards_loop() {
    assert_the_same("valve_hysteresis=0.08", Loop::Board { age: 0.5 }, false);
}
