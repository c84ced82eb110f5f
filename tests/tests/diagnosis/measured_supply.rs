//! What a measured supply settles: a supply that the rig file states wrongly does to the inflow
//! what another fill edge does, and without a measurement the two cannot be told apart. The truth
//! plant hides both, and the diagnosis gets the data file and the nominal rig.

use pneudrive_model::data::{LoadOptions, load};
use pneudrive_model::diagnosis::{Request, diagnose};
use pneudrive_model::rig::Rig;
use pneudrive_sim::plant::Nuisances;
use pneudrive_sim::record::{Columns, Loop, Recorder, RecordingSettings, rig_toml, write_csv};
use system_tests::blind::score::named;

/// The report on 60 s of two channels whose supply has 150 kPa less than the rig file says, with
/// these other effects. Where the supply is measured, the board told it after every tenth poll.
fn report(effects: &[&str], seed: u64, measured: bool) -> serde_json::Value {
    let defaults = RecordingSettings::default();
    let mut plant = defaults.plant.clone();
    plant.channels = 2;
    plant.nuisances = Nuisances::laboratory();
    let hidden = effects.iter().chain(&["supply_level=-150"]);
    let settings = RecordingSettings {
        plant,
        effects: hidden.map(|text| text.parse().unwrap()).collect(),
        seed,
        seconds: 60.0,
        rate_hz: 100.0,
        control_loop: Loop::Row,
        columns: Columns { drive: true, supply: measured, ..Columns::default() },
        ..defaults
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    write_csv(&file, 2, settings.columns, Recorder::new(&settings).unwrap()).unwrap();
    if measured {
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, as_a_board_tells_it(&text)).unwrap();
    }
    let rig = Rig::parse("rig.toml", &rig_toml(&settings).unwrap()).unwrap();
    assert_eq!(rig.supply.as_ref().unwrap().pressure_kpa, 550.0, "as stated");
    let limits = |channel| rig.sensor_limits(channel);
    let loaded = load(&file, LoadOptions { limits: Some(&limits), ..LoadOptions::default() }).unwrap();
    assert_eq!(loaded.recording.board_supplies.len(), usize::from(measured));
    let diagnosis = diagnose(&loaded.recording, &rig, Request::default(), &|_, _| {}).unwrap();
    serde_json::to_value(&diagnosis.report).unwrap()
}

/// The last column is board 0's, and has a value in every tenth row only.
fn as_a_board_tells_it(text: &str) -> String {
    let mut told = String::new();
    for (row, line) in text.lines().enumerate() {
        let (others, supply) = line.rsplit_once(',').unwrap();
        match row {
            0 => {
                assert_eq!(supply, "supply_kpa");
                told += &format!("{others},b0_supply_kpa\n");
            }
            row if row % 10 == 1 => told += &format!("{line}\n"),
            _ => told += &format!("{others},\n"),
        }
    }
    told
}

#[test]
fn a_supply_that_is_stated_wrongly_is_suspected_and_one_that_is_measured_needs_no_cause() {
    let stated = report(&[], 31, false);
    let measured = report(&[], 31, true);
    println!(
        "stated: {} ({}); measured: {} ({})",
        named(&stated),
        stated["sentence"],
        named(&measured),
        measured["sentence"]
    );
    assert!(measured["causes"].as_array().unwrap().is_empty(), "{}", measured["sentence"]);
    assert_eq!(measured["verdict"], "adequate", "{}", measured["sentence"]);
    assert!(stated["causes"].as_array().unwrap().is_empty(), "{}", stated["sentence"]);
    let suspected =
        "\"Supply is not what the rig file states\", which is not in the catalogue, explains it as well";
    assert!(stated["sentence"].as_str().unwrap().contains(suspected), "{}", stated["sentence"]);
}

/// The two hide each other: a vent edge of 0.75, and a supply that makes the fill edge seem so.
#[test]
fn edges_that_a_wrong_supply_hides_are_named_where_it_is_measured() {
    let effect = ["valve_asymmetry=0.75"];
    let stated = report(&effect, 32, false);
    let measured = report(&effect, 32, true);
    println!(
        "stated: {} ({}); measured: {} ({})",
        named(&stated),
        stated["sentence"],
        named(&measured),
        measured["sentence"]
    );
    assert!(!named(&stated).contains("valve_asymmetry"), "{}", stated["sentence"]);
    assert_eq!(named(&measured), "valve_asymmetry", "{}", measured["sentence"]);
    let size = measured["causes"][0]["parameters"]["ratio"]["value"].as_f64().unwrap();
    assert!((size / 0.75 - 1.0).abs() < 0.05, "{size}");
}
