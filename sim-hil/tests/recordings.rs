//! Recordings: the format, the order of command and measurement, noise, repeatability, refusals.
use std::io::Read;
use std::path::Path;

use pneudrive_sim::plant::{Effect, Nuisances, PlantParameters};
use pneudrive_sim::record::{
    BoardKind, Columns, ControlSettings, Excitation, Loop, RecordError, Recorder, RecordingSettings, Row,
    rig_toml, write_csv,
};

fn rows(settings: &RecordingSettings) -> Vec<Row> {
    Recorder::new(settings).unwrap().collect()
}

fn short(change: impl FnOnce(&mut RecordingSettings)) -> RecordingSettings {
    let mut settings = RecordingSettings { seconds: 2.0, ..RecordingSettings::default() };
    change(&mut settings);
    settings
}

fn write(path: &Path, settings: &RecordingSettings) -> Result<u64, RecordError> {
    write_csv(path, settings.plant.channels, settings.columns, Recorder::new(settings)?)
}

#[test]
fn header_follows_the_measured_data_format() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    let settings = short(|s| {
        s.plant.channels = 6;
        s.columns = Columns { command: true, drive: true, joints: true, supply: true };
    });
    assert_eq!(write(&path, &settings).unwrap(), 200);
    let text = std::fs::read_to_string(&path).unwrap();
    let header = "t_s,b0_cmd0_kpa,b0_cmd1_kpa,b0_cmd2_kpa,b0_cmd3_kpa,b0_p0_kpa,b0_p1_kpa,b0_p2_kpa,b0_p3_kpa,\
                  b0_u0,b0_u1,b0_u2,b0_u3,b0_qu_rad,b0_qv_rad,b1_cmd0_kpa,b1_cmd1_kpa,b1_p0_kpa,b1_p1_kpa,b1_u0,b1_u1,\
                  b1_qu_rad,b1_qv_rad,supply_kpa";
    assert_eq!(text.lines().next().unwrap(), header);
    let columns = header.split(',').count();
    let mut last = -1.0;
    for line in text.lines().skip(1) {
        let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
        assert_eq!(values.len(), columns);
        assert!(values[0] > last);
        last = values[0];
    }
    assert!((last - 1.99).abs() < 1e-9);
    // Nothing but the finished file is left behind.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn compressed_files_hold_the_same_text() {
    let folder = tempfile::tempdir().unwrap();
    let settings = short(|_| {});
    let of = |name: &str| {
        let path = folder.path().join(name);
        write(&path, &settings).unwrap();
        std::fs::read(path).unwrap()
    };
    let plain = of("a.csv");
    let mut gzip = Vec::new();
    flate2::read::GzDecoder::new(&of("a.csv.gz")[..]).read_to_end(&mut gzip).unwrap();
    assert!(gzip == plain);
    assert!(zstd::decode_all(&of("a.csv.zst")[..]).unwrap() == plain);
}

/// The rig file says what the user knows; effects and spread are not in it.
#[test]
fn rig_file_is_the_nominal_rig() {
    let settings = short(|s| s.effects = vec![Effect::moderate("supply_level").unwrap()]);
    let rig: toml::Table = rig_toml(&settings).unwrap().parse().unwrap();
    let number = |table: &str, key: &str| match &rig[table][key] {
        toml::Value::Float(v) => *v,
        toml::Value::Integer(v) => *v as f64,
        other => panic!("{other}"),
    };
    for (table, key, value) in [
        ("supply", "pressure_kpa", 550.0),
        ("ambient", "pressure_kpa_abs", 101.325),
        ("ambient", "temperature_k", 293.15),
        ("chamber", "radius_m", 0.024),
        ("chamber", "length_m", 0.20),
        ("chamber", "offset_m", 0.045),
        ("valve", "discharge_coefficient", 1.0),
        ("valve", "critical_ratio", 0.30),
        ("controller", "rate_hz", 1000.0),
        ("controller", "kp", 10.0),
        ("controller", "kd", 0.0),
        ("controller", "saturation", 400.0),
        ("controller", "filter", 0.0),
        ("sensor", "bits", 10.0),
        ("sensor", "zero_counts", 102.4),
        ("sensor", "kpa_per_count", 0.841_645),
    ] {
        assert!((number(table, key) - value).abs() < 1e-6, "{table}.{key}");
    }
}

/// Random drives instead of set points.
fn open(settings: &mut RecordingSettings, amplitude: f64) {
    settings.control_loop = Loop::Open { amplitude };
    settings.columns.command = false;
}

/// Closed valves and a constant pressure: what is left is noise and quantisation, 0.36 kPa RMS.
/// Averaged over pressures that divide two counts into eighths (two, because halves round to even),
/// as 0.25 kPa of noise does not blur a count of 0.84 kPa.
#[test]
fn noise_is_0_36_kpa() {
    let (mut squares, mut sum, mut count) = (0.0, 0.0, 0.0);
    for eighth in 0..16_u32 {
        let initial_kpa = 200.0 + 0.841_645 * f64::from(eighth) / 8.0;
        let settings = short(|s| {
            s.seconds = 5.0;
            s.seed = u64::from(eighth);
            open(s, 0.0);
            s.plant.chamber.initial_kpa = initial_kpa;
            s.plant.valve.leakage = 0.0;
            s.plant.valve.corner = 1e-4;
        });
        for error in rows(&settings).iter().flat_map(|r| &r.pressure_kpa).map(|p| p - initial_kpa) {
            (squares, sum, count) = (squares + error * error, sum + error, count + 1.0);
        }
    }
    let rms = f64::sqrt(squares / count);
    assert!((rms - 0.36).abs() < 0.006, "{rms}");
    assert!((sum / count).abs() < 0.01, "{}", sum / count);
}

/// A row's pressure is measured before its command acts: the first row after a step still shows the
/// old pressure, and the second shows nearly a whole row of filling.
#[test]
fn a_row_holds_no_effect_of_its_own_command() {
    for control_loop in [Loop::Board { age: 0.5 }, Loop::Board { age: 0.0 }, Loop::Row] {
        let settings = short(|s| {
            s.control_loop = control_loop;
            s.excitation = Excitation::Steps;
            s.exact = true;
        });
        let rows = rows(&settings);
        // Row 0 steps from rest to somewhere above 50 kPa: full fill, 754 kPa/s.
        assert!(rows[0].pressure_kpa.iter().all(|p| p.abs() < 0.05), "{:?}", rows[0]);
        let waited = match control_loop {
            // From the row to the next loop, and the measurement of the next row is as old as it
            // is.
            Loop::Board { .. } => 0.001,
            _ => 0.0,
        };
        for (p, command) in rows[1].pressure_kpa.iter().zip(&rows[0].command_kpa) {
            let expected = 754.0 * (0.01 - waited);
            assert!(*command > 45.0 && (p - expected).abs() < 0.3, "{control_loop:?}: {p} for {expected}");
        }
    }
}

/// On a ramp of 754 kPa/s the answered pressure is as old as the settings say.
#[test]
fn answers_are_as_old_as_the_settings_say() {
    for age in [0.0, 0.25, 0.8] {
        let settings = short(|s| {
            s.control_loop = Loop::Board { age };
            s.excitation = Excitation::Steps;
            s.exact = true;
        });
        let mut recorder = Recorder::new(&settings).unwrap();
        let row = recorder.nth(3).unwrap();
        let id = pneudrive_sim::plant::ChannelId { board: 0, channel: 0 };
        let now =
            1e-3 * (recorder.plant().truth(id).unwrap().port_pa - recorder.plant().ambient_pressure_pa());
        let behind = now - row.pressure_kpa[0];
        assert!((behind - 0.754 * age).abs() < 0.01, "age {age}: {behind} kPa");
    }
}

/// Between the drives of two rows the plant sees nothing else: with the drives recorded, the plant
/// alone gives the same pressures.
#[test]
fn recorded_drives_replay() {
    use pneudrive_sim::plant::{ChannelId, Plant};
    for control_loop in [Loop::Row, Loop::Open { amplitude: 0.6 }] {
        let settings = short(|s| {
            s.control_loop = control_loop;
            s.columns.command = control_loop == Loop::Row;
            s.exact = true;
            s.effects = vec!["valve_lag=0.01".parse().unwrap()];
        });
        let mut plant = Plant::new(settings.plant.clone(), &settings.effects, 99).unwrap();
        for (k, row) in rows(&settings).iter().enumerate() {
            plant.advance_to(k as u64 * 10_000_000);
            for (index, drive) in row.drive.iter().enumerate() {
                let channel = ChannelId::from_index(index).unwrap();
                let gauge = 1e-3 * (plant.truth(channel).unwrap().port_pa - plant.ambient_pressure_pa());
                assert!((gauge - row.pressure_kpa[index]).abs() < 1e-9);
                plant.set_drive(channel, *drive).unwrap();
            }
        }
    }
}

/// The firmware's integers and PWM steps make little of a difference: the two boards stay within a
/// kilopascal or two.
#[test]
fn firmware_and_ideal_board_agree() {
    let of = |board| {
        rows(&short(|s| {
            s.seconds = 10.0;
            s.board = board;
            s.exact = true;
            s.control = ControlSettings { filter: 210.0 / 256.0, kd: 20.0, ..ControlSettings::default() };
        }))
    };
    let (firmware, ideal) = (of(BoardKind::Firmware), of(BoardKind::Ideal));
    let squares: f64 = firmware
        .iter()
        .zip(&ideal)
        .flat_map(|(a, b)| a.pressure_kpa.iter().zip(&b.pressure_kpa).map(|(a, b)| (a - b).powi(2)))
        .sum();
    let rms = (squares / (4.0 * firmware.len() as f64)).sqrt();
    assert!(rms > 0.0 && rms < 0.7, "{rms}");
}

#[test]
fn recordings_repeat_by_seed() {
    let laboratory = |seed| {
        rows(&short(|s| {
            s.seed = seed;
            s.plant.nuisances = Nuisances::laboratory();
            s.effects = ["stale_samples", "line_water", "supply_ripple"].map(|e| e.parse().unwrap()).to_vec();
        }))
    };
    let first = laboratory(5);
    assert!(first == laboratory(5));
    let other = laboratory(6);
    assert!(first.iter().zip(&other).any(|(a, b)| a.command_kpa != b.command_kpa));
    assert!(first.iter().zip(&other).any(|(a, b)| a.pressure_kpa != b.pressure_kpa));
}

/// Spread and wander are what they say: channels differ by some percent, the supply by 1 % RMS over
/// many runs.
#[test]
fn nuisances_have_their_size() {
    let (mut levels, mut volumes) = (Vec::new(), Vec::new());
    for seed in 0..60 {
        let settings = short(|s| {
            s.seconds = 0.01;
            s.seed = seed;
            s.exact = true;
            s.plant.nuisances = Nuisances::laboratory();
        });
        let mut recorder = Recorder::new(&settings).unwrap();
        levels.push(recorder.next().unwrap().supply_kpa / 550.0 - 1.0);
        for index in 0..4 {
            let id = pneudrive_sim::plant::ChannelId { board: 0, channel: index };
            let volume = recorder.plant().truth(id).unwrap().volume_m3;
            volumes.push((volume / PlantParameters::default().chamber.resting_volume_m3()).ln());
        }
    }
    let deviation = |x: &[f64]| (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt();
    // 60 values: 9 % standard error; 240 values: 5 %.
    assert!((deviation(&levels) - 0.01).abs() < 0.003, "{}", deviation(&levels));
    assert!((deviation(&volumes) - 0.05).abs() < 0.008, "{}", deviation(&volumes));
}

#[test]
fn open_loop_stays_about_the_range_and_has_no_commands() {
    let settings = short(|s| {
        s.seconds = 40.0;
        open(s, 0.4);
    });
    let rows = rows(&settings);
    let all = || rows.iter().skip(200).flat_map(|r| r.pressure_kpa.iter().copied());
    assert!(rows[0].command_kpa.is_empty());
    assert!(all().fold(f64::MIN, f64::max) < 330.0 && all().fold(f64::MAX, f64::min) > 20.0);
    assert!(all().fold(f64::MIN, f64::max) > 250.0 && all().fold(f64::MAX, f64::min) < 100.0);
}

#[test]
fn unusable_settings_are_named() {
    let refusal =
        |change: fn(&mut RecordingSettings)| Recorder::new(&short(change)).err().unwrap().to_string();
    assert!(refusal(|s| s.seconds = f64::NAN).contains("seconds is NaN s"));
    assert!(refusal(|s| s.rate_hz = 0.0).contains("rate_hz is 0 Hz: expected 1 to 1000"));
    assert!(refusal(|s| s.range_kpa = [200.0, 100.0]).contains("range_kpa high is 100"));
    assert!(refusal(|s| s.control.kp = 0.5).contains("control.kp is 0.5"));
    assert!(refusal(|s| open(s, 2.0)).contains("amplitude"));
    assert!(refusal(|s| s.control_loop = Loop::Open { amplitude: 0.5 }).contains("no set points"));
    assert!(refusal(|s| s.plant.channels = 0).contains("channels is 0"));
    let folder = tempfile::tempdir().unwrap();
    let bad_name = write(&folder.path().join("run.txt"), &short(|_| {})).unwrap_err();
    assert!(bad_name.to_string().contains("run.txt: expected a name that ends in .csv"));
    assert_eq!(bad_name.exit_status(), 2);
    let no_folder = write(&folder.path().join("none/run.csv"), &short(|_| {})).unwrap_err();
    assert!(no_folder.to_string().contains("none/run.csv"));
    assert_eq!(no_folder.exit_status(), 2);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
