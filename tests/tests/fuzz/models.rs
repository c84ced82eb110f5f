use super::mutation::contents;
use super::scripts;
use bolero::check;
use pneudrive_model::data::{LoadOptions, Recording, read};
use pneudrive_model::diagnosis::{ExtendedFile, Purpose, simulate_extended};
use pneudrive_model::experiment::{ControllerUse, Setup, simulation};
use pneudrive_model::rig::Rig;
use pneudrive_model::rollout::Start;
use pneudrive_model::store::ParameterFile;

const RIG: &str = include_str!("seeds/rig.toml");
const FITTED: &str = include_str!("seeds/fitted.toml");
const EXTENDED: &str = include_str!("seeds/extended.toml");
const FILE: &str = "fuzzed.toml";

/// What a text editor leaves: TOML that is no UTF-8 is refused before it is parsed.
fn text(seed: &str, script: &[u8]) -> Option<String> {
    String::from_utf8(contents(seed.as_bytes(), script)).ok()
}

/// A rig is refused, or written back it is the same rig.
#[test]
fn rig_files() {
    assert!(Rig::parse(FILE, RIG).is_ok());
    check!().with_iterations(5_000).with_generator(scripts(64)).for_each(|script: &Vec<u8>| {
        let Some(text) = text(RIG, script) else { return };
        match Rig::parse(FILE, &text) {
            Ok(rig) => {
                let again = toml::to_string(&rig).unwrap();
                assert_eq!(Rig::parse(FILE, &again).unwrap(), rig);
            }
            Err(error) => assert!(error.to_string().contains(FILE), "{error}"),
        }
    });
}

/// Ten rows of two driven channels.
fn recording() -> Recording {
    let mut text = "t_s,b0_p0_kpa,b0_u0,b0_p1_kpa,b0_u1\n".to_owned();
    for row in 0..10 {
        let part = 0.1 * f64::from(row);
        text.push_str(&format!("{},{},{part},{},{}\n", 0.1 * part, 10 * row, 100 - 10 * row, -part));
    }
    read("rows.csv", text.as_bytes(), LoadOptions::default()).unwrap().recording
}

fn simulate_fitted(file: &ParameterFile, recording: &Recording) -> Option<Vec<f64>> {
    let channel = &recording.channels[0];
    let stored = file.channel(FILE, channel.id).ok()?;
    let Setup { model, controller, drive } = stored.setup;
    let controller = if controller { ControllerUse::On } else { ControllerUse::Auto };
    let drive = drive.unwrap_or_default();
    let setup = Setup::resolve(model, controller, drive, recording, channel, &file.rig).ok()?;
    let prepared = simulation(setup, recording, channel, &file.rig, file.flow_form(), 0.0).ok()?;
    let values = file.values(FILE, channel.id, &prepared.subject).ok()?;
    Some(prepared.subject.simulate(&values, &prepared.series[0], Start::Measured, stored.substeps))
}

/// A parameter file is refused, or can be simulated, whatever comes of it, and is the same when it
/// is written back.
#[test]
fn parameter_files() {
    let recording = recording();
    let good = ParameterFile::parse(FILE, FITTED).unwrap();
    assert!(simulate_fitted(&good, &recording).unwrap().iter().all(|pa| pa.is_finite()));
    check!().with_iterations(5_000).with_generator(scripts(64)).for_each(|script: &Vec<u8>| {
        let Some(text) = text(FITTED, script) else { return };
        match ParameterFile::parse(FILE, &text) {
            Ok(file) => {
                assert_eq!(Rig::parse(FILE, &toml::to_string(&file.rig).unwrap()).unwrap(), file.rig);
                let again = ParameterFile::parse(FILE, &toml::to_string(&file).unwrap()).unwrap();
                assert_eq!(format!("{again:?}"), format!("{file:?}"));
                let _ = simulate_fitted(&file, &recording);
            }
            Err(error) => assert!(error.to_string().contains(FILE), "{error}"),
        }
    });
}

/// The same of what a diagnosis writes.
#[test]
fn extended_files() {
    let recording = recording();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(FILE);
    let simulate = |file: &ExtendedFile| {
        let purpose = Purpose::Simulate { start_kpa: 0.0, controller: false };
        simulate_extended(FILE, file, &recording, &file.rig, purpose)
    };
    std::fs::write(&path, EXTENDED).unwrap();
    let good = simulate(&ExtendedFile::load(&path).unwrap()).unwrap();
    assert!(good[0].kpa.iter().all(|kpa| kpa.is_finite()));
    check!().with_iterations(5_000).with_generator(scripts(64)).for_each(|script: &Vec<u8>| {
        let seed = if script.len().is_multiple_of(4) { FITTED } else { EXTENDED };
        std::fs::write(&path, contents(seed.as_bytes(), script)).unwrap();
        match ExtendedFile::load(&path) {
            Ok(file) => {
                assert_eq!(Rig::parse(FILE, &toml::to_string(&file.rig).unwrap()).unwrap(), file.rig);
                let _ = simulate(&file);
            }
            Err(error) => assert!(error.to_string().contains(FILE), "{error}"),
        }
    });
}

/// What was found: a rig inside a parameter file was not checked (a shift by 40 bits, a division by
/// zero), and a number of steps was taken for granted (years of computing).
#[test]
fn values_that_no_simulation_survives_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(FILE);
    for (good, bad, said) in [
        ("bits = 10", "bits = 40", "sensor.bits"),
        ("rate_hz = 100.0", "rate_hz = 0.0", "controller.rate_hz"),
        ("critical_ratio = 0.3", "critical_ratio = 1.0", "valve.critical_ratio"),
        ("temperature_k = 293.15", "temperature_k = nan", "ambient.temperature_k"),
    ] {
        assert_eq!((FITTED.matches(good).count(), EXTENDED.matches(good).count()), (1, 1), "{good}");
        let error = ParameterFile::parse(FILE, &FITTED.replace(good, bad)).unwrap_err().to_string();
        assert!(error.starts_with(FILE) && error.contains(said), "{error}");
        std::fs::write(&path, EXTENDED.replace(good, bad)).unwrap();
        let error = ExtendedFile::load(&path).unwrap_err().to_string();
        assert!(error.contains(FILE) && error.contains(said), "{error}");
    }
    for substeps in ["0", "1001", "9223372036854775807"] {
        let text = FITTED.replace("substeps = 1", &format!("substeps = {substeps}"));
        let error = ParameterFile::parse(FILE, &text).unwrap_err().to_string();
        assert_eq!(error, format!("{FILE}: channel b0c0: substeps = {substeps}; 1 to 1000 are possible"));
    }
}
