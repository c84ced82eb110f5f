//! The binary from outside: exit status, files, messages.

use crate::common::Folder;
use crate::common::cli::{json, run};

const RIG: &str = "[supply]\npressure_kpa = 550.0\n[chamber]\nradius_m = 0.024\nlength_m = 0.2\n\
[controller]\nrate_hz = 1000.0\nkp = 10.0\nsaturation = 400.0\n[sensor]\nbits = 10\nzero_counts = 102.4\nkpa_per_count = 0.841645\n";

/// 12 s at 100 Hz of steps of the command, and a first-order lag of 0.2 s that follows them
/// exactly, with alpha = beta = 5.
pub fn lag() -> String {
    let (mut text, mut p) = ("t_s,b0_cmd0_kpa,b0_p0_kpa\n".to_owned(), 0.0_f64);
    for k in 0..1200_u32 {
        let command = if (k / 150) % 2 == 0 { 200.0 } else { 80.0 };
        text.push_str(&format!("{:.2},{command},{p:.6}\n", f64::from(k) * 0.01));
        p = command + (p - command) * (-0.05_f64).exp();
    }
    text
}

/// Commands and a drive without pressures, for simulations.
fn commands() -> String {
    let mut text = "t_s,b0_cmd0_kpa,b0_u0\n".to_owned();
    for k in 0..3000_u32 {
        let t = f64::from(k) * 0.01;
        let step = f64::from((k / 60 * 7919) % 97) / 97.0;
        let drive = (0.8 * (2.0 * step - 1.0)).clamp(-1.0, 1.0);
        text.push_str(&format!("{t:.2},{:.3},{drive:.4}\n", 60.0 + 240.0 * step));
    }
    text
}

#[test]
fn a_linear_fit_finds_the_lag_and_saves_it() {
    let folder = Folder::new();
    folder.write("lag.csv", lag().as_bytes());
    let fit =
        run(folder.root(), &["fit", "lag.csv", "--model", "linear", "--starts", "4", "--out", "p.toml"]);
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    assert!(fit.stdout.contains("alpha") && fit.stdout.contains("wrote p.toml and p.json"), "{}", fit.stdout);
    let result = json(&folder.path("p.json"));
    assert_eq!(result["schema"], "pneudrive-fit/1");
    for name in ["alpha", "beta"] {
        let parameters = result["channels"]["b0c0"]["fit"]["parameters"].as_array().unwrap();
        let value = parameters.iter().find(|p| p["name"] == name).unwrap()["value"].as_f64().unwrap();
        assert!((value - 5.0).abs() < 1e-3, "{name} = {value}");
    }
    let saved: toml::Table = std::fs::read_to_string(folder.path("p.toml")).unwrap().parse().unwrap();
    assert_eq!(saved["schema"].as_str(), Some("pneudrive-parameters/1"));
    assert_eq!(saved["provenance"]["data"]["sha256"].as_str().map(str::len), Some(64));
    assert!(saved["provenance"]["command"].as_str().unwrap().starts_with("pneudrive-model fit lag.csv"));
    assert_eq!(folder.names(), ["lag.csv", "p.json", "p.toml"]);
}

#[test]
fn parameters_that_were_saved_simulate_and_are_found_again() {
    let folder = Folder::new();
    folder.write("commands.csv", commands().as_bytes());
    folder.write("rig.toml", RIG.as_bytes());
    folder.write("lag.csv", lag().as_bytes());
    // A parameter file to start from, then its values replaced by known ones.
    let first =
        run(folder.root(), &["fit", "lag.csv", "--model", "linear", "--starts", "1", "--out", "p.toml"]);
    assert_eq!(first.status, 0, "{}", first.stderr);
    let simulated = run(
        folder.root(),
        &["simulate", "commands.csv", "--parameters", "p.toml", "--start-kpa", "60", "--out", "sim.csv.gz"],
    );
    assert_eq!(simulated.status, 0, "{}", simulated.stderr);
    let summary = json(&folder.path("sim.json"));
    assert_eq!(summary["schema"], "pneudrive-simulation/1");
    assert_eq!(
        (summary["rows"].as_u64(), summary["channels"]["b0c0"]["score"].is_null()),
        (Some(3000), true)
    );
    let again =
        run(folder.root(), &["fit", "sim.csv.gz", "--model", "linear", "--starts", "4", "--out", "q.toml"]);
    assert_eq!(again.status, 0, "{}", again.stderr);
    let values = |name: &str| -> Vec<f64> {
        let file = json(&folder.path(name));
        let list = file["channels"]["b0c0"]["fit"]["parameters"].as_array().unwrap().clone();
        list.iter().map(|p| p["value"].as_f64().unwrap()).collect()
    };
    for (a, b) in values("p.json").into_iter().zip(values("q.json")) {
        assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
    }
}

#[test]
fn compare_writes_a_page_and_json_and_prints_the_table() {
    let folder = Folder::new();
    folder.write("lag.csv", lag().as_bytes());
    folder.write("rig.toml", RIG.as_bytes());
    let arguments =
        ["compare", "lag.csv", "--rig", "rig.toml", "--fit-seconds", "8", "--starts", "2", "--out", "result"];
    let done = run(folder.root(), &arguments);
    assert_eq!(done.status, 0, "{}", done.stderr);
    for model in ["linear", "nonlinear", "parametric"] {
        assert!(done.stdout.contains(model), "{}", done.stdout);
    }
    let result = json(&folder.path("result/compare.json"));
    assert_eq!(result["schema"], "pneudrive-compare/1");
    assert!((result["fit_seconds"].as_f64().unwrap() - 8.0).abs() < 1e-9);
    // The data are a linear lag: it must win, and nearly be perfect.
    assert_eq!(result["ranking"][0], "linear");
    let linear = &result["channels"][0]["models"][0];
    assert!(linear["rollout"]["rmse_kpa"].as_f64().unwrap() < 1e-3, "{linear}");
    assert!(linear["rollout"]["r2"].as_f64().unwrap() > 0.999_999);
    assert!(linear["evaluation_s"].as_f64().unwrap() > 0.0);
    for key in ["origin", "data", "quality", "rig", "overall", "channels", "test_seconds"] {
        assert!(!result[key].is_null(), "{key}");
    }
    let page = std::fs::read_to_string(folder.path("result/compare.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("<svg") && page.len() < 1_000_000);
    for outside in ["http://", "https://", "<script src", "src=\"", "@import", "<link"] {
        let found = page.replace("http://www.w3.org/2000/svg", "").contains(outside);
        assert!(!found, "the page asks for {outside}");
    }
}

#[test]
fn the_board_s_loop_is_simulated_where_the_drive_is_not_recorded() {
    let folder = Folder::new();
    folder.write("lag.csv", lag().as_bytes());
    folder.write("rig.toml", RIG.as_bytes());
    let fit = run(
        folder.root(),
        &["fit", "lag.csv", "--rig", "rig.toml", "--fit-seconds", "3", "--starts", "1", "--out", "p.toml"],
    );
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    let result = json(&folder.path("p.json"));
    assert_eq!(result["parameters"]["channels"]["b0c0"]["setup"]["controller"], true);
    let off = run(
        folder.root(),
        &["fit", "lag.csv", "--rig", "rig.toml", "--controller", "off", "--out", "off.toml"],
    );
    assert_eq!(off.status, 2);
    assert!(
        off.stderr.contains("channel b0c0 has no drive column (b0_u0, or b0_fill0 and b0_vent0)"),
        "{}",
        off.stderr
    );
    assert!(!folder.path("off.toml").exists());
}

#[test]
fn unusable_input_is_status_2_and_leaves_nothing_behind() {
    let folder = Folder::new();
    folder.write("bad.csv", b"t_s,b0_cmd0_kpa,b0_p0_kpa\n0,1,1\n0.01,x,1\n");
    folder.write("commands.csv", commands().as_bytes());
    folder.write("short.csv", b"t_s,b0_cmd0_kpa,b0_p0_kpa\n0,1,1\n0.01,2,1\n");
    folder.write("lag.csv", lag().as_bytes());
    folder.write("rig.toml", b"[supply]\npressure = 3\n");
    folder.write("other.toml", b"schema = \"something/1\"\n");
    folder.write("good.toml", b"[supply]\npressure_kpa = 300\n");
    let before = folder.names();
    for (arguments, said) in [
        (
            vec!["fit", "bad.csv", "--model", "linear", "--out", "p.toml"],
            "bad.csv, row 3, column b0_cmd0_kpa",
        ),
        (vec!["fit", "none.csv", "--out", "p.toml"], "none.csv: cannot be opened"),
        (
            vec!["fit", "lag.csv", "--rig", "none.toml", "--out", "p.toml"],
            "`pneudrive-host init` writes a rig",
        ),
        (
            vec!["simulate", "lag.csv", "--parameters", "none.toml", "--out", "s.csv"],
            "`fit --out` and `diagnose` write a parameter file",
        ),
        (
            vec!["fit", "commands.csv", "--rig", "good.toml", "--out", "p.toml"],
            "channel b0c0 has no column b0_p0_kpa, which a fit needs",
        ),
        (vec!["fit", "short.csv", "--model", "linear", "--out", "p.toml"], "2 rows are too few to fit"),
        (
            vec!["fit", "lag.csv", "--rig", "rig.toml", "--out", "p.toml"],
            "unknown key supply.pressure; did you mean pressure_kpa?",
        ),
        (vec!["fit", "lag.csv", "--out", "p.toml"], "needs [controller] and [sensor] in the rig file"),
        (
            vec!["fit", "lag.csv", "--channels", "b0c9", "--model", "linear", "--out", "p.toml"],
            "no channel b0c9; the file has b0c0",
        ),
        (vec!["compare", "lag.csv", "--fit-seconds", "11.9", "--out", "d"], "both need 50 at least"),
        (vec!["compare", "lag.csv", "--fit-fraction", "1.5", "--out", "d"], "between 0 and 1"),
        (
            vec!["simulate", "lag.csv", "--parameters", "other.toml", "--out", "s.csv"],
            "schema is \"something/1\"",
        ),
        (vec!["fit", "good.toml", "--out", "p.toml"], "expected a recording, and this is a rig file"),
        (
            vec!["simulate", "lag.csv", "--parameters", "lag.csv", "--out", "s.csv"],
            "expected a parameter file, and this is a recording",
        ),
        (
            vec!["show", "lag.csv", "--out", "page.txt"],
            "a page is written there; let the name end in .html or .htm",
        ),
        (vec!["effects", "gremlins"], "no effect is called gremlins"),
        (vec!["fit", "lag.csv"], "--out"),
        (
            vec!["import", "lag.csv", "--time", "t_s:s", "--map", "b0_p0_kpa=nothing:kPa", "--out", "i.csv"],
            "no column \"nothing\" among: t_s, b0_cmd0_kpa, b0_p0_kpa",
        ),
    ] {
        let done = run(folder.root(), &arguments);
        assert_eq!(done.status, 2, "{arguments:?}: {}", done.stderr);
        assert!(done.stderr.contains(said), "{arguments:?}: {}", done.stderr);
        assert_eq!(folder.names(), before, "{arguments:?}");
    }
}

#[test]
fn a_foreign_file_is_imported() {
    let folder = Folder::new();
    let mut text = "logger 3\nserial 17\nTime [ms];Pressure (psi);Set;PWM\n".to_owned();
    for k in 0..200_u32 {
        text.push_str(&format!("{};{},5;{};{}\n", 5000 + 10 * k, k % 7, 14 + k % 3, 127 + k % 2));
    }
    folder.write("log.txt", text.as_bytes());
    let arguments = [
        "import",
        "log.txt",
        "--skip",
        "2",
        "--delimiter",
        ";",
        "--decimal-comma",
        "--time",
        "Time [ms]:ms",
        "--map",
        "b0_p0_kpa=Pressure (psi):psi",
        "--map",
        "b0_cmd0_kpa=Set:psi:14",
        "--map",
        "b0_u0=PWM:255:127",
        "--out",
        "run.csv",
    ];
    let done = run(folder.root(), &arguments);
    assert_eq!(done.status, 0, "{}", done.stderr);
    let written = std::fs::read_to_string(folder.path("run.csv")).unwrap();
    let lines: Vec<&str> = written.lines().take(4).collect();
    assert_eq!(
        lines,
        [
            "t_s,b0_p0_kpa,b0_cmd0_kpa,b0_u0",
            "0,3.447379,0,0",
            "0.01,10.342136,6.894757,0.003922",
            "0.02,17.236893,13.789515,0"
        ]
    );
    assert!(done.stdout.contains("200 rows") && done.stdout.contains("Sampled at 100 Hz"), "{}", done.stdout);
}

#[test]
fn effects_are_listed_and_explained() {
    let folder = Folder::new();
    let list = run(folder.root(), &["effects"]);
    assert_eq!(list.status, 0);
    for id in ["valve_hysteresis", "supply_sag", "stale_samples", "chamber_volume"] {
        assert!(list.stdout.contains(id), "{id}");
    }
    let one = run(folder.root(), &["effects", "valve_hysteresis"]);
    assert!(one.status == 0 && one.stdout.contains("Told apart by"), "{}", one.stdout);
}

#[cfg(unix)]
#[test]
fn an_interrupted_fit_keeps_the_best_so_far() {
    use std::process::{Command, Stdio};
    let folder = Folder::new();
    folder.write("lag.csv", lag().as_bytes());
    folder.write("rig.toml", RIG.as_bytes());
    // Far more starts than there is patience for.
    let arguments = [
        "fit",
        "lag.csv",
        "--rig",
        "rig.toml",
        "--model",
        "parametric",
        "--starts",
        "10000",
        "--out",
        "p.toml",
    ];
    let mut child = Command::new(env!("CARGO_BIN_EXE_pneudrive-model"))
        .args(arguments)
        .current_dir(folder.root())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    // Wait for its word that the fit has begun, not for a time.
    let mut stderr = std::io::BufReader::new(child.stderr.take().expect("piped"));
    let mut line = String::new();
    while !line.contains("fitting the parametric model") {
        line.clear();
        let read = std::io::BufRead::read_line(&mut stderr, &mut line).expect("text");
        assert!(read > 0, "ended before it began to fit");
    }
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(killed.success());
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut stderr, &mut rest).expect("text");
    let status = child.wait().expect("ends");
    assert_eq!(status.code(), Some(1), "{rest}");
    assert!(rest.contains("stopping: the best so far is kept"), "{rest}");
    assert!(rest.contains("stopped by request: these files hold the best found so far"), "{rest}");
    let saved: toml::Table = std::fs::read_to_string(folder.path("p.toml")).unwrap().parse().unwrap();
    assert_eq!(saved["settings"]["stopped"].as_bool(), Some(true));
    assert_eq!(json(&folder.path("p.json"))["parameters"]["settings"]["stopped"], true);
}

/// A recording of the host carries the rig file that it was made with.
#[test]
fn a_recordings_copy_of_the_rig_file_is_taken_where_none_is_given() {
    let folder = Folder::new();
    let with = |rig: &str| format!("# rig: {}\n{}", serde_json::json!(rig), lag());
    folder.write("run.csv", with("[supply]\npressure_kpa = 550\n[chamber]\nvolume_m3 = 1e-4\n").as_bytes());
    let fit = |data: &str| {
        run(folder.root(), &["fit", data, "--model", "linear", "--starts", "1", "--out", "p.toml"])
    };
    let done = fit("run.csv");
    assert_eq!(done.status, 0, "{}", done.stderr);
    assert!(done.stderr.contains("run.csv: taken with its copy of the rig file"), "{}", done.stderr);
    let saved: toml::Table = std::fs::read_to_string(folder.path("p.toml")).unwrap().parse().unwrap();
    assert_eq!(saved["rig"]["chamber"]["volume_m3"].as_float(), Some(1e-4));

    folder.write("bad.csv", with("[chamber]\nvolume = 1\n").as_bytes());
    let refused = fit("bad.csv");
    let expected = "bad.csv, its copy of the rig file:2: unknown key chamber.volume; did you mean volume_m3?";
    assert!(refused.status == 2 && refused.stderr.contains(expected), "{}", refused.stderr);
}
