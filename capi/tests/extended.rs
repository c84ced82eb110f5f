//! An extended model stepped row by row gives the numbers of `pneudrive-model simulate`: every
//! effect of the catalogue, random rigs.

use crate::support::{Driven, Neighbours, channel, extended, generator, recording, stepped};
use pneudrive_model::data::{ChannelId, Recording};
use pneudrive_model::diagnosis::ExtendedFile;
use pneudrive_model::effects::catalogue::CATALOGUE;
use pneudrive_model::simulation::{CalibratedModel, SimulationSettings, simulate};

const ROWS: usize = 250;
/// kPa.
const MOST: f64 = 0.005;

/// What the neighbours of a channel do, as a simulation of all of them sees it: opposite pressures
/// over five rows, the reading of the channel before, the flows of the others.
fn neighbours(of: ChannelId, readings: &[Vec<f64>], draws: &[Vec<f64>], jointed: bool) -> Neighbours {
    let (own, count) = (usize::from(of.channel), readings.len());
    let opposite = readings.get(own ^ 1).filter(|_| !jointed);
    let mean = |kpa: &Vec<f64>, k: usize| {
        let window = &kpa[k.saturating_sub(2)..(k + 3).min(kpa.len())];
        window.iter().sum::<f64>() / window.len() as f64
    };
    let before = (own + count - 1) % count;
    let others = |row: usize| (0..count).filter(|k| *k != own).map(|k| draws[k][row].max(0.0)).sum();
    Neighbours {
        opposite_kpa: opposite.map_or_else(Vec::new, |kpa| (0..kpa.len()).map(|k| mean(kpa, k)).collect()),
        sampled_before_kpa: if before == own { Vec::new() } else { readings[before].clone() },
        others_draw: (0..readings[own].len()).map(others).collect(),
    }
}

/// The channels stepped, each with its neighbours as they were in the pass before.
fn stepped_together(file: &ExtendedFile, recording: &Recording, passes: usize) -> Vec<Vec<f64>> {
    let model = CalibratedModel::from(file.clone());
    let rows = recording.rows();
    let measured = |c: &pneudrive_model::data::Channel| match &c.pressure_kpa {
        Some(p) => p.iter().map(|p| f64::from(*p)).collect(),
        None => vec![0.0; rows],
    };
    let mut readings: Vec<Vec<f64>> = recording.channels.iter().map(measured).collect();
    let mut draws = vec![vec![0.0; rows]; recording.channels.len()];
    for pass in 0..=passes {
        let (seen, drawn) = (readings.clone(), draws.clone());
        for (k, of) in recording.channels.iter().enumerate() {
            let mut around = neighbours(of.id, &seen, &drawn, !recording.joints.is_empty());
            if pass == 0 {
                around.others_draw.clear();
            }
            let mut stepper = channel(&model, of.id);
            let supply = |supply: &[f32], row: usize| f64::from(supply[row]);
            (readings[k], draws[k]) = stepped(&mut stepper, (&file.rig, recording), of, supply, &around);
        }
    }
    readings
}

fn largest_difference(file: &ExtendedFile, recording: &Recording, passes: usize) -> f64 {
    let model = CalibratedModel::from(file.clone());
    let whole = simulate(&model, recording, &SimulationSettings::default(), &mut |_, _| {}).unwrap();
    let steps = stepped_together(file, recording, passes);
    let mut largest = 0.0_f64;
    for (channel, steps) in whole.channels.iter().zip(&steps) {
        assert!(
            channel.kpa.iter().any(|p| (p - channel.kpa[0]).abs() > 1.0),
            "{}: nothing moves",
            channel.id
        );
        for (a, b) in channel.kpa.iter().zip(steps) {
            largest = largest.max((a - b).abs());
        }
    }
    largest
}

#[test]
fn every_effect_steps_as_it_is_simulated() {
    let (mut tried, mut worst) = (0, 0.0_f64);
    for (number, info) in CATALOGUE.iter().enumerate() {
        for driven in Driven::ALL.into_iter().filter(|driven| driven.has(info)) {
            for draw in 0..3 {
                let mut rng = generator(1000 * number as u64 + 10 * driven as u64 + draw);
                let file = extended(&mut rng, driven, 1, &[info.id]);
                let measured = info.id == "stale_samples";
                let recording = recording(&mut rng, (driven, 1, ROWS), measured, draw == 1);
                let largest = largest_difference(&file, &recording, 0);
                assert!(largest < MOST, "{} {driven:?} {draw}: {largest} kPa", info.id);
                (tried, worst) = (tried + 1, worst.max(largest));
            }
        }
    }
    println!("{tried} simulations, at most {worst:.1e} kPa apart");
    assert!(tried > 250, "{tried} of them");
}

/// Some of a board's loops end in the middle between two rows, and times are rounded otherwise in a
/// recording than from step to step.
#[test]
fn a_boards_loop_holds_an_old_sample_as_long_as_it_is_simulated_to() {
    for seed in 0..30 {
        let mut rng = generator(900_000 + seed);
        let file = extended(&mut rng, Driven::Board, 1, &["stale_samples"]);
        let recording = recording(&mut rng, (Driven::Board, 1, ROWS), true, seed % 3 == 1);
        let largest = largest_difference(&file, &recording, 0);
        assert!(largest < MOST, "{seed}: {largest} kPa");
    }
}

#[test]
fn channels_that_act_on_each_other_step_as_they_are_simulated() {
    for id in ["chamber_coupling", "sensor_crosstalk", "supply_sag"] {
        for driven in [Driven::Spool, Driven::Separate, Driven::Board] {
            let mut rng = generator(7 + driven as u64);
            let file = extended(&mut rng, driven, 4, &[id]);
            let recording = recording(&mut rng, (driven, 4, ROWS), false, false);
            let apart = largest_difference(&file, &recording, 0);
            let together = largest_difference(&file, &recording, 4);
            assert!(together < MOST, "{id} {driven:?}: {together} kPa");
            assert!(apart > 2.0 * MOST, "{id} {driven:?} does nothing: {apart} kPa");
        }
    }
}

#[test]
fn several_effects_together_step_as_they_are_simulated() {
    let effects =
        ["transport_delay", "valve_lag", "valve_hysteresis", "vent_restriction", "wall_creep", "sensor_lag"];
    for driven in [Driven::Spool, Driven::Separate, Driven::Board] {
        for draw in 0..4 {
            let mut rng = generator(90 + 10 * driven as u64 + draw);
            let file = extended(&mut rng, driven, 1, &effects);
            let recording = recording(&mut rng, (driven, 1, ROWS), false, draw == 0);
            let largest = largest_difference(&file, &recording, 0);
            assert!(largest < MOST, "{driven:?} {draw}: {largest} kPa");
        }
    }
}
