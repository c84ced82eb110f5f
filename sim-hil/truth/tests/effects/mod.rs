//! Every effect by name: nothing when null, something when on, and the something is what its
//! physics says.

mod bench;
mod changes;
mod off_catalogue;
mod structure;

use pneudrive_sim::record::{Recorder, RecordingSettings, Row};
use pneudrive_truth::{Effect, GasModel, Plant, PlantParameters, catalogue};

use bench::{channel, rig, run};

/// What each effect does to the quiet rig. The lists are complete: an effect without a line fails.
fn assert_direction(id: &str) {
    let known = structure::assert_direction(id)
        || changes::assert_direction(id)
        || off_catalogue::assert_direction(id);
    assert!(known, "no direction is asserted for {id}");
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

/// In a recording of 6 s, read through a sensor with 0.36 kPa of noise, every moderate effect is
/// there.
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
