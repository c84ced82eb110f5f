//! `pneudrive-model trends` from outside.

use crate::common::Folder;
use crate::common::cli::{json, run};

/// 12 s at 100 Hz of steps of the command, and a first-order lag that follows them, recorded on a
/// day of November 2026.
fn lag(day: u32, rate_per_s: f64) -> String {
    let mut text = format!("# created_utc: \"2026-11-{day:02}T08:00:00.000Z\"\nt_s,b0_cmd0_kpa,b0_p0_kpa\n");
    let mut p = 0.0_f64;
    for k in 0..1200_u32 {
        let command = if (k / 150) % 2 == 0 { 200.0 } else { 80.0 };
        text.push_str(&format!("{:.2},{command},{p:.6}\n", f64::from(k) * 0.01));
        p = command + (p - command) * (-0.01 * rate_per_s).exp();
    }
    text
}

#[test]
fn a_folder_becomes_a_page_with_its_change_and_is_fitted_once() {
    let folder = Folder::new();
    // Named so that their order is not that of their dates.
    let recordings =
        [("f", 2, 5.0), ("b", 4, 5.05), ("e", 7, 4.96), ("a", 9, 5.02), ("d", 15, 3.0), ("c", 20, 3.04)];
    for (name, day, rate_per_s) in recordings {
        folder.write(&format!("{name}.csv"), lag(day, rate_per_s).as_bytes());
    }
    folder.write("broken.csv", b"t_s,b0_p0_kpa\n0,much\n");
    let arguments = ["trends", ".", "--model", "linear", "--starts", "4"];
    let first = run(folder.root(), &arguments);
    assert_eq!(first.status, 0, "{}", first.stderr);
    assert!(first.stdout.contains("b0c0 alpha: 5.01"), "{}", first.stdout);
    assert!(first.stdout.contains("until 2026-11-09, 3.02") && first.stdout.contains("from 2026-11-15 on"));
    let told = json(&folder.path("trends/trends.json"));
    assert_eq!(told["schema"], "pneudrive-trends/1");
    assert_eq!(told["recordings"].as_array().map(Vec::len), Some(6));
    assert!(told["left_out"][0].as_str().unwrap().contains("broken.csv"), "{}", told["left_out"]);
    let alpha =
        told["trends"].as_array().unwrap().iter().find(|trend| trend["parameter"] == "alpha").unwrap();
    let values: Vec<f64> =
        alpha["points"].as_array().unwrap().iter().map(|point| point["value"].as_f64().unwrap()).collect();
    for (value, (_, _, rate_per_s)) in values.iter().zip(recordings) {
        assert!((value - rate_per_s).abs() < 0.01, "{values:?}");
    }
    let changes = alpha["changes"].as_array().unwrap();
    assert_eq!((changes.len(), &changes[0]["at"]), (1, &4.into()), "{changes:?}");
    let page = std::fs::read_to_string(folder.path("trends/trends.html")).unwrap();
    assert!(page.contains("days since 2026-11-02") && page.contains("change"), "{page}");
    // Nothing is fitted again, and the result is the same.
    let again = run(folder.root(), &arguments);
    assert_eq!(again.status, 0, "{}", again.stderr);
    assert!(first.stderr.contains("fitting") && !again.stderr.contains("fitting"), "{}", again.stderr);
    assert_eq!(json(&folder.path("trends/trends.json")), told);
    // Other settings are other fits.
    let other = run(folder.root(), &["trends", ".", "--model", "linear", "--starts", "5"]);
    assert!(other.stderr.contains("fitting"), "{}", other.stderr);
}

#[test]
fn a_folder_without_recordings_is_refused() {
    let folder = Folder::new();
    let empty = run(folder.root(), &["trends", "."]);
    assert!(empty.status == 2 && empty.stderr.contains("no recordings in it"), "{}", empty.stderr);
    let missing = run(folder.root(), &["trends", "nowhere"]);
    assert!(missing.status == 2 && missing.stderr.contains("nowhere"), "{}", missing.stderr);
    folder.write("broken.csv", b"t_s,b0_p0_kpa\n0,much\n");
    let broken = run(folder.root(), &["trends", "."]);
    assert!(broken.status == 2 && broken.stderr.contains("none of the 1 recordings"), "{}", broken.stderr);
}
