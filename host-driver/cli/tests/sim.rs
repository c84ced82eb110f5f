//! The main job: `--port sim` from start to end.

use std::process::Command;

#[test]
fn three_virtual_boards_are_polled_and_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let output = Command::new(env!("CARGO_BIN_EXE_pneudrive-host"))
        .args([
            "--port",
            "sim",
            "--devices",
            "3",
            "--command",
            "50",
            "--rate",
            "100",
            "--duration",
            "1",
            "--json",
        ])
        // The machine that runs the tests may be busy with others.
        .args(["--allowance-us", "10000000", "--echo", "absent", "--record"])
        .arg(&file)
        .output()
        .unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{stderr}");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&json["devices"], &json["lost"]), (&3.into(), &0.into()), "{json}");
    for board in json["boards"].as_array().unwrap() {
        assert_eq!((&board["state"], &board["frames"]), (&"present".into(), &"checked".into()), "{json}");
    }
    let text = std::fs::read_to_string(file).unwrap();
    let table: Vec<_> = text.lines().filter(|line| !line.starts_with('#')).collect();
    assert!(table[0].starts_with("t_s,b0_cmd0_kpa,"), "{text}");
    assert_eq!(table.len() as u64, json["recording"]["rows"].as_u64().unwrap() + 1);
    // They were switched on before: a model is to be fitted to all of a recording, not to all but
    // its first two seconds.
    let pressures = |row: &str| -> Vec<f64> {
        let columns = table[0].split(',').zip(row.split(','));
        columns.filter(|(name, _)| name.contains("_p")).map(|(_, value)| value.parse().unwrap()).collect()
    };
    let (first, later) = (pressures(table[1]), pressures(table[table.len() - 10]));
    assert_eq!((first.len(), later.len()), (12, 12), "{}", table[0]);
    assert!(first.iter().all(|kpa| kpa.abs() < 5.0), "they vented: {first:?}");
    assert!(later.iter().all(|kpa| (kpa - 50.0).abs() < 5.0), "within a second they follow: {later:?}");
    assert_eq!(json["recording"]["rows"], json["cycles"]);
}
