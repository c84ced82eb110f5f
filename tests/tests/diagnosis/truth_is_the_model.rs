//! With every effect off the truth plant is the nonlinear model of the paper, in other words: two
//! descriptions that share no code (conductances and the ANR density there, areas and the flow
//! function here) agree to within the error of integration. What is fitted to the plant's
//! recordings therefore starts from a model that lacks nothing, and whatever a diagnosis finds
//! there was put there.

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::experiment::{ControllerUse, DriveKind, ModelKind, Score, Setup, score, simulation};
use pneudrive_model::model::{FlowForm, psi_max};
use pneudrive_model::rig::Rig;
use pneudrive_model::rollout::Start;
use pneudrive_sim::plant::{Nuisances, PlantParameters, SensorParameters};
use pneudrive_sim::record::{Columns, Loop, Recorder, RecordingSettings, rig_toml, write_csv};

/// Density (kg/m^3) and temperature (K) of the state in which sonic conductances are stated,
/// ISO 8778.
const ANR: (f64, f64) = (1.185, 293.15);
/// Gas constant of dry air, J/(kg K).
const AIR: f64 = 287.05;

/// Effective area in mm^2 of a sonic conductance in m^3/(s Pa): the choked flow
/// `C rho_0 sqrt(T_0 / T) p` is `A psi_max sqrt(2 / (R T)) p`.
fn area_mm2(conductance: f64) -> f64 {
    conductance * ANR.0 * (ANR.1 * AIR / 2.0).sqrt() / psi_max() * 1e6
}

/// The plant's valve in the model's parameters, by name.
fn parameter(plant: &PlantParameters, name: &str) -> f64 {
    let valve = &plant.valve;
    let open = area_mm2(valve.conductance_m3_per_s_pa);
    match name {
        "leak_in" | "leak_out" => valve.leakage * open,
        // The edges of a symmetric spool are open at full drive.
        "gain" => open / (1.0 - 0.5 * (valve.fill_edge - valve.vent_edge)),
        "threshold_in" => valve.fill_edge,
        "threshold_out" => valve.vent_edge,
        "corner" => valve.corner * open,
        "volume_weight" => 1.0,
        other => panic!("the nonlinear model has got a parameter {other}"),
    }
}

/// The model simulated from the drives of a recording without noise and rounding, with the plant's
/// own numbers: nothing is fitted.
fn agreement(settings: &RecordingSettings, substeps: usize) -> Vec<Score> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("truth.csv");
    let recorder = Recorder::new(settings).unwrap();
    write_csv(&file, settings.plant.channels, settings.columns, recorder).unwrap();
    let rig: Rig = Rig::parse("truth.toml", &rig_toml(settings).unwrap()).unwrap();
    let recording = load(&file, LoadOptions::default()).unwrap().recording;
    let simulated = recording.channels.iter().map(|channel| {
        let (kind, closed) = (ModelKind::Nonlinear, ControllerUse::Off);
        let setup = Setup::resolve(kind, closed, DriveKind::Spool, &recording, channel, &rig).unwrap();
        let prepared = simulation(setup, &recording, channel, &rig, FlowForm::Iso6358, 0.0).unwrap();
        let subject = &prepared.subject;
        let values: Vec<f64> =
            subject.parameters().iter().map(|p| parameter(&settings.plant, &p.name)).collect();
        let series = &prepared.series[0];
        score(series, &subject.simulate(&values, series, Start::Measured, substeps)).unwrap()
    });
    simulated.collect()
}

fn exact(control_loop: Loop, rate_hz: f64) -> RecordingSettings {
    RecordingSettings {
        plant: PlantParameters {
            sensor: SensorParameters { noise_kpa: 0.0, ..PlantParameters::default().sensor },
            nuisances: Nuisances::none(),
            ..PlantParameters::default()
        },
        seconds: 20.0,
        rate_hz,
        control_loop,
        columns: Columns {
            command: !matches!(control_loop, Loop::Open { .. }),
            drive: true,
            ..Columns::default()
        },
        exact: true,
        ..RecordingSettings::default()
    }
}

/// Recordings are kept in single precision, which at 300 kPa stands 3e-5 kPa apart.
const LARGEST_KPA: f64 = 5e-5;

#[test]
fn with_everything_off_the_plant_is_the_nonlinear_model() {
    for (name, control_loop, rate_hz) in [
        ("closed loop", Loop::Row, 100.0),
        ("closed loop", Loop::Row, 1000.0),
        ("open loop", Loop::Open { amplitude: 0.6 }, 100.0),
    ] {
        for (channel, score) in agreement(&exact(control_loop, rate_hz), 20).iter().enumerate() {
            let error = score.largest_kpa;
            assert!(error < LARGEST_KPA, "{name}, {rate_hz} Hz, channel {channel}: {error:e} kPa");
        }
    }
}
