//! The parameters of a fit stepped row by row give the numbers of `pneudrive-model simulate`: every
//! model, random rigs.

use std::collections::BTreeMap;

use crate::support::{Driven, Neighbours, base, channel, generator, recording, rig, stepped};
use pneudrive_model::data::{ChannelId, Source};
use pneudrive_model::experiment::{DriveKind, ModelKind, Setup};
use pneudrive_model::model::{Gas, Model, Parametric, ValveDrive, nominal_values};
use pneudrive_model::simulation::{CalibratedModel, SimulationSettings, simulate};
use pneudrive_model::store::{ChannelParameters, ParameterFile, Provenance, Settings, StoredParameter};

const ROWS: usize = 250;
/// kPa.
const MOST: f64 = 0.005;
const ID: ChannelId = ChannelId { board: 0, channel: 0 };

/// A parameter file of one channel, as `fit` saves it.
fn file(seed: u64, setup: Setup, driven: Driven) -> ParameterFile {
    let mut rng = generator(seed);
    // A regulator's rig has no board.
    let rig = rig(&mut rng, driven);
    let named: Vec<(String, f64)> = match setup.model {
        ModelKind::Parametric => {
            let drive = if driven == Driven::Separate { ValveDrive::Separate } else { ValveDrive::Spool };
            let parameters = Parametric { gas: Gas::default(), drive }.parameters();
            let values = nominal_values(&parameters);
            parameters.into_iter().zip(values).map(|(p, value)| (p.name, value)).collect()
        }
        ModelKind::Nonlinear => {
            let valve = pneudrive_model::model::Nonlinear {
                drive: if driven == Driven::Separate { ValveDrive::Separate } else { ValveDrive::Spool },
                ..Default::default()
            };
            let values = base(&mut rng, driven);
            valve.parameters().into_iter().map(|p| (p.name.clone(), values[&p.name])).collect()
        }
        ModelKind::Linear => base(&mut rng, driven).into_iter().collect(),
    };
    let stored = |(name, value)| StoredParameter {
        name,
        value,
        unit: "1".to_owned(),
        ci95: None,
        standard_error: None,
        profile95: None,
        determined: true,
    };
    let parameters = ChannelParameters {
        setup,
        substeps: 2,
        rms: 0.4,
        noise_kpa: None,
        samples: ROWS,
        condition: 1.0,
        agreeing_starts: 1,
        free: Vec::new(),
        covariance: Vec::new(),
        parameters: named.into_iter().map(stored).collect(),
    };
    let source = Source { file: "run.csv".to_owned(), sha256: String::new(), bytes: 0 };
    ParameterFile {
        schema: ParameterFile::SCHEMA.to_owned(),
        provenance: Provenance::now(&source),
        settings: Settings {
            objective: "rollout".to_owned(),
            starts: 1,
            seed: 1,
            fit_seconds: 2.0,
            printed_flow: seed.is_multiple_of(2),
            stopped: false,
        },
        rig,
        channels: BTreeMap::from([(ID, parameters)]),
    }
}

#[test]
fn every_model_steps_as_it_is_simulated() {
    let spool = Some(DriveKind::Spool);
    let separate = Some(DriveKind::Separate);
    let cases = [
        (ModelKind::Linear, None, false, Driven::Command),
        (ModelKind::Nonlinear, spool, false, Driven::Spool),
        (ModelKind::Nonlinear, separate, false, Driven::Separate),
        (ModelKind::Nonlinear, spool, true, Driven::Board),
        (ModelKind::Parametric, spool, false, Driven::Spool),
        (ModelKind::Parametric, separate, false, Driven::Separate),
        (ModelKind::Parametric, spool, true, Driven::Board),
    ];
    for (number, (model, drive, controller, driven)) in cases.into_iter().enumerate() {
        for draw in 0..4 {
            let setup = Setup { model, drive, controller };
            let seed = 10 * number as u64 + draw;
            let file = file(seed, setup, driven);
            let rig = file.rig.clone();
            let model = CalibratedModel::from(file);
            let recording = recording(&mut generator(seed), (driven, 1, ROWS), false, draw == 1);
            let whole = simulate(&model, &recording, &SimulationSettings::default(), &mut |_, _| {}).unwrap();
            // Means over each interval.
            let supply = |supply: &[f32], row: usize| {
                0.5 * (f64::from(supply[row]) + f64::from(supply[(row + 1).min(supply.len() - 1)]))
            };
            let of = &recording.channels[0];
            let mut stepper = channel(&model, ID);
            let (steps, _) = stepped(&mut stepper, (&rig, &recording), of, supply, &Neighbours::default());
            let kpa = &whole.channels[0].kpa;
            assert!(kpa.iter().any(|p| (p - kpa[0]).abs() > 5.0), "{setup:?}: nothing moves");
            let largest = kpa.iter().zip(&steps).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(largest < MOST, "{setup:?} {draw}: {largest} kPa");
        }
    }
}
