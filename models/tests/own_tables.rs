//! Chambers and valves that boards and channels have of their own: honoured by simulations, fits,
//! comparisons and diagnoses.

use std::fmt::Write as _;

use pneudrive_model::data::{ChannelId, LoadOptions, Recording, read};
use pneudrive_model::diagnosis::{ExtendedFile, Purpose, simulate_extended};
use pneudrive_model::experiment::{
    CompareSettings, CompareWatch, FitSettings, ModelKind, compare, fit_channels,
};
use pneudrive_model::fit::{Control, FitOptions};
use pneudrive_model::rig::Rig;
use pneudrive_model::simulation::{CalibratedModel, SimulationSettings, simulate};
use pneudrive_model::store::ParameterFile;

/// Three channels alike but for a chamber of three times the volume, and a valve that is closed
/// half as far below the critical ratio.
const OWN: &str = "[supply]\npressure_kpa = 550\n[chamber]\nvolume_m3 = 1e-4\n\
    [boards.0.channels.1.chamber]\nvolume_m3 = 3e-4\n\
    [boards.0.channels.2.valve]\ndischarge_coefficient = 0.5\ncritical_ratio = 0.3\n";
const USUAL: &str = "[supply]\npressure_kpa = 550\n[chamber]\nvolume_m3 = 1e-4\n";
/// The truth, mm^2.
const GAIN: f64 = 1.2;

fn id(channel: u8) -> ChannelId {
    ChannelId { board: 0, channel }
}

/// The same drives for three channels, 20 s at 100 Hz; pressures so that there are some.
fn drives() -> Recording {
    let mut text = "t_s,b0_u0,b0_p0_kpa,b0_u1,b0_p1_kpa,b0_u2,b0_p2_kpa\n".to_owned();
    for k in 0..2000_u32 {
        let at = f64::from(k.wrapping_mul(2_654_435_761) >> 8);
        let held = f64::from((k / 25).wrapping_mul(2_654_435_761) >> 8) / f64::from(1_u32 << 23) - 1.0;
        // Sensors never stand still; what they read is not used.
        let p = 50.0 + at / f64::from(1_u32 << 24);
        let u = 0.4 * held;
        writeln!(text, "{:.2},{u:.4},{p:.3},{u:.4},{p:.3},{u:.4},{p:.3}", f64::from(k) * 0.01).unwrap();
    }
    read("drives.csv", text.as_bytes(), LoadOptions::default()).unwrap().recording
}

/// A parameter file in which all three channels have the same valve.
fn parameters(rig: &str) -> ParameterFile {
    let mut text = "schema = \"pneudrive-parameters/1\"\n[provenance]\nprogram = \"\"\ncreated = \"\"\ncommand = \"\"\n\
        [provenance.data]\nfile = \"\"\nsha256 = \"\"\nbytes = 0\n\
        [settings]\nobjective = \"rollout\"\nstarts = 1\nseed = 1\nfit_seconds = 1.0\nprinted_flow = false\nstopped = false\n"
        .to_owned();
    text += &rig.replace("[", "[rig.");
    for channel in 0..3 {
        write!(
            text,
            "[channels.b0c{channel}]\nsubsteps = 1\nrms = 0.1\nsamples = 1\ncondition = 1.0\nagreeing_starts = 1\nfree = []\n\
             covariance = []\n[channels.b0c{channel}.setup]\nmodel = \"nonlinear\"\ndrive = \"spool\"\ncontroller = false\n"
        )
        .unwrap();
        let values = [
            ("leak_in", 0.0),
            ("leak_out", 0.0),
            ("gain", GAIN),
            ("threshold_in", 0.045),
            ("threshold_out", -0.045),
            ("corner", 1e-4),
            ("volume_weight", 1.0),
        ];
        for (name, value) in values {
            write!(
                text,
                "[[channels.b0c{channel}.parameters]]\nname = \"{name}\"\nvalue = {value:?}\nunit = \"1\"\ndetermined = true\n"
            )
            .unwrap();
        }
    }
    ParameterFile::parse("parameters.toml", &text).unwrap()
}

/// What three channels with these parameters do, as a recording.
fn simulated(file: &ParameterFile) -> Recording {
    let recording = drives();
    let model = CalibratedModel::from(file.clone());
    simulate(&model, &recording, &SimulationSettings::default(), &mut |_, _| {})
        .unwrap()
        .recording(&recording)
}

fn pressures(recording: &Recording, channel: u8) -> &[f32] {
    recording.channel(id(channel)).unwrap().pressure_kpa.as_ref().unwrap()
}

fn furthest(a: &[f32], b: impl Iterator<Item = f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max)
}

/// Where a pressure is twice as far from the start, it got there in half the time.
#[test]
fn a_larger_chamber_and_a_smaller_valve_are_slower() {
    let run = simulated(&parameters(OWN));
    let alike = simulated(&parameters(USUAL));
    assert_eq!(pressures(&alike, 0), pressures(&alike, 1));
    assert_eq!(pressures(&alike, 0), pressures(&run, 0), "it has nothing of its own");
    let swing = |channel| {
        let p = pressures(&run, channel);
        p.windows(2).map(|pair| f64::from((pair[1] - pair[0]).abs())).sum::<f64>()
    };
    assert!(swing(1) < 0.8 * swing(0), "{} {}", swing(1), swing(0));
    assert!(swing(2) < 0.9 * swing(0), "{} {}", swing(2), swing(0));
}

/// The opening is found where the rig says what else is different, and is off by exactly that where
/// it does not.
#[test]
fn fits_take_each_channel_with_its_own() {
    let run = simulated(&parameters(OWN));
    let settings =
        FitSettings { fit: FitOptions { starts: 1, ..FitOptions::default() }, ..FitSettings::default() };
    let gains = |rig: &str| -> Vec<f64> {
        let rig = Rig::parse("rig.toml", rig).unwrap();
        let fitted = fit_channels(&run, &rig, &settings, Control::none()).unwrap();
        let gain =
            |fit: &pneudrive_model::fit::Fit| fit.parameters.iter().find(|p| p.name == "gain").unwrap().value;
        fitted.iter().map(|channel| gain(&channel.fit)).collect()
    };
    for (gain, expected) in gains(OWN).into_iter().zip([GAIN; 3]) {
        assert!((gain / expected - 1.0).abs() < 0.02, "{gain}, expected {expected}");
    }
    for (gain, expected) in gains(USUAL).into_iter().zip([GAIN, GAIN / 3.0, GAIN / 2.0]) {
        assert!((gain / expected - 1.0).abs() < 0.02, "{gain}, expected {expected}");
    }
}

/// The effects' simulator, which diagnoses use, gives the same pressures as the fits' one.
#[test]
fn diagnoses_take_each_channel_with_its_own() {
    let file = parameters(OWN);
    let run = simulated(&file);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("parameters.toml");
    file.save(&path).unwrap();
    let extended = ExtendedFile::load(&path).unwrap();
    assert_eq!(extended.rig, file.rig, "boards and channels are kept");
    let purpose = Purpose::Simulate { start_kpa: 0.0, controller: false };
    let channels = simulate_extended("parameters.toml", &extended, &run, &extended.rig, purpose).unwrap();
    for (channel, trace) in (0..).zip(&channels) {
        let off = furthest(pressures(&run, channel), trace.kpa.iter().copied());
        assert!(off < 0.2, "channel {channel}: {off} kPa");
    }
}

#[test]
fn comparisons_take_each_channel_with_its_own() {
    let run = simulated(&parameters(OWN));
    let settings = CompareSettings {
        models: vec![ModelKind::Nonlinear],
        fit: FitOptions { starts: 1, ..FitOptions::default() },
        ..CompareSettings::default()
    };
    let rig = Rig::parse("rig.toml", OWN).unwrap();
    let compared = compare(&run, &rig, &settings, CompareWatch::none()).unwrap();
    for channel in &compared.channels {
        let fit = channel.models[0].fit.as_ref().unwrap();
        let gain = fit.parameters.iter().find(|p| p.name == "gain").unwrap().value;
        assert!((gain / GAIN - 1.0).abs() < 0.02, "{}: {gain}", channel.channel);
    }
}
