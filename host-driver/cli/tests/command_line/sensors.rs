//! `--sensors` and `--sessions`, of virtual boards on a machine that may be busy.

use crate::command_line::program::{program, refused, run, table};
use crate::command_line::schema::{RUN, conforms};
use std::fs;

const PATIENT: [&str; 6] = ["--port", "sim", "--wait", "60", "--allowance-us", "100000"];

#[test]
fn a_board_tells_what_is_on_its_i2c_connector() {
    let arguments = [&["board", "status"], &PATIENT[..], &["--json"]].concat();
    let (code, stdout, stderr) = run(&arguments);
    assert_eq!(code, Some(0), "{stderr}");
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let sensors = &json["sensors"];
    assert_eq!((&sensors["supply_part"], &sensors["supply_state"]), (&"ADS1115".into(), &"live".into()));
    assert_eq!((&sensors["imu_part"], &sensors["imu_state"]), (&"BMI323".into(), &"live".into()));
    assert!((sensors["supply_kpa"].as_f64().unwrap() - 550.0).abs() < 3.0, "{stdout}");
    assert!((sensors["acceleration_m_s2"][2].as_f64().unwrap() - 9.807).abs() < 0.1, "{stdout}");
    assert!(sensors["angular_rate_rad_s"][0].as_f64().unwrap().abs() < 0.02, "{stdout}");
    assert_eq!(json["rail_v"], 5.0, "{stdout}");
    assert!(json["chip_c"].is_null() || json["chip_c"] == 27.2, "its first second may not be over: {stdout}");

    let (code, text, stderr) = run(&[&["board", "status"], &PATIENT[..], &["--unit", "bar"]].concat());
    assert_eq!(code, Some(0), "{stderr}");
    assert!(text.contains("  supply sensor: ADS1115, 5.") && text.contains(" bar\n"), "{text}");
    assert!(text.contains("  IMU: BMI323, ") && text.contains(" rad/s\n"), "{text}");
}

#[test]
fn a_run_records_its_sensors_and_shows_the_supply() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let path = file.to_str().unwrap();
    let run_arguments =
        ["--rate", "100", "--duration", "2.5", "--sensors", "0.5", "--drives", "0.1", "--record", path];
    let (code, stdout, stderr) = run(&[&PATIENT[..], &run_arguments].concat());
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.lines().any(|line| line.contains(" supply 5")), "{stdout}");
    let text = fs::read_to_string(&file).unwrap();
    let event = "board 0: supply sensor ADS1115 live, IMU BMI323 live";
    assert!(text.contains(event) && text.contains("\"kind\":\"sensors\""), "{text}");
    let mut rows = table(&text);
    assert!(rows.next().unwrap().ends_with(
        ",b0_u3,b0_supply_kpa,b0_ax_m_s2,b0_ay_m_s2,b0_az_m_s2,b0_gx_rad_s,b0_gy_rad_s,b0_gz_rad_s,b0_chip_c,b0_rail_v"
    ));
    let supply: Vec<f64> = rows.filter_map(|row| row.split(',').nth(13)?.parse().ok()).collect();
    assert!(supply.len() > 5 && supply.iter().all(|kpa| (kpa - 550.0).abs() < 3.0), "{supply:?}");
}

/// The last readings; a run without `--sensors` has none.
#[test]
fn the_json_of_a_run_has_its_sensors() {
    let more = ["--rate", "100", "--duration", "4", "--sensors", "0.5", "--json"];
    let (code, stdout, stderr) = run(&[&PATIENT[..], &more].concat());
    assert_eq!(code, Some(0), "{stderr}");
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    conforms(&json, RUN);
    let sensors = &json["boards"][0]["sensors"];
    assert!((sensors["supply_kpa"].as_f64().unwrap() - 550.0).abs() < 3.0, "{stdout}");
    assert!(sensors["supply_age_s"].as_f64().is_some(), "{stdout}");
    assert!((sensors["acceleration_m_s2"][2].as_f64().unwrap() - 9.807).abs() < 0.1, "{stdout}");
    assert_eq!((&sensors["chip_c"], &sensors["rail_v"]), (&27.2.into(), &5.0.into()), "{stdout}");
    let (_, stdout, _) = run(&[&PATIENT[..], &["--rate", "100", "--duration", "1", "--json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(json["boards"][0].get("sensors"), Some(&serde_json::Value::Null), "{stdout}");
}

#[test]
fn what_is_no_share_or_switch_is_refused() {
    refused(&["--port", "sim", "--sensors", "0"], 2, "expected a share of the polls above 0 and at most 1");
    refused(&["--port", "sim", "--sessions", "maybe"], 2, "[possible values: on, off]");
    let both = ["--port", "sim", "--rate", "3000", "--sensors", "0.5", "--drives", "0.5"];
    refused(
        &both,
        2,
        "2500.0 Hz, the wire's limit for 1 board(s) at 1000000 baud with 1 page requests for each poll",
    );
}

/// Without sessions line rates stay, and it is said why; what was chosen stands in the recording.
#[test]
fn sessions_can_be_turned_off() {
    let folder = tempfile::tempdir().unwrap();
    let [off, on] = ["off", "on"].map(|sessions| {
        let file = folder.path().join(format!("{sessions}.csv"));
        let more = ["--baud", "auto", "--rate", "200", "--duration", "1", "--sessions", sessions, "--record"];
        let arguments = [&PATIENT[..], &more, &[file.to_str().unwrap()]].concat();
        let output = program(&arguments).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        fs::read_to_string(&file).unwrap()
    });
    assert!(off.contains("# sessions: false\n") && on.contains("# sessions: true\n"));
    let refusal = "it gives this host no session, in which alone line rates are changed";
    assert!(off.contains(refusal), "{off}");
    assert!(!on.contains(refusal), "{on}");
}
