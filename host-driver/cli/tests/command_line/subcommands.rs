//! Subcommands that measure and list.

use crate::command_line::program::{program, refused, run, signal, until};
use crate::support::pty::PtyBoards;
use pneudrive_protocol::Counts;
use rustix::process::Signal;
use std::fs;
use std::sync::atomic::Ordering;

#[test]
fn timing_gives_the_originals_figures() {
    let (code, stdout, _) = run(&["timing", "--json"]);
    assert_eq!(code, Some(0));
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(json["exchange_us"], 200.0);
    assert_eq!(json["pulse"]["resistor_ohm"], 976);
    let (_, text, _) = run(&["timing"]);
    assert!(text.contains("976 ohm") && text.contains("107.4 us   +- 5.5 us"), "{text}");
}

#[test]
fn ping_names_each_board() {
    let boards = PtyBoards::start(3);
    boards.last_unplugged.store(true, std::sync::atomic::Ordering::Relaxed);
    let port = boards.path().to_str().unwrap();
    let patient = ["-n", "3", "--wait", "0.2", "--count", "5", "--allowance-us", "20000"];
    let (code, stdout, stderr) = run(&[&["ping", "--port", port][..], &patient].concat());
    assert_eq!(code, Some(1));
    assert!(stdout.starts_with(&format!("port {port}\n")), "{stdout}");
    assert!(stdout.contains("board 1: ") && stdout.contains("-0.3 -0.3 -0.3 -0.3 kPa"), "{stdout}");
    assert!(
        stdout.contains("board 2: 0 of 5 answered\n  last error: board 2 (0xFFFD): no answer"),
        "{stdout}"
    );
    assert!(stderr.contains("1 of 3 boards did not answer"), "{stderr}");
}

#[test]
fn ping_tells_what_it_counted_when_it_is_interrupted() {
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap();
    let args = ["ping", "--port", port, "-n", "2", "--count", "1000000", "--allowance-us", "100000"];
    let child = program(&args).spawn().unwrap();
    // After the request that finds out about echoes and one to find each board.
    until("pings", || boards.answered.load(Ordering::Relaxed) > 20);
    signal(&child, Signal::INT);
    let output = child.wait_with_output().unwrap();
    let stdout = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{stdout}");
    let counted = stdout.split("board 0: ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    assert!((10..1_000_000).contains(&counted.parse::<u32>().unwrap()), "{stdout}");
    assert!(stdout.contains("(fastest, median, slowest)") && !stdout.contains("board 1"), "{stdout}");
}

#[test]
fn bench_prints_a_row_for_each_number_of_boards() {
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap();
    let (code, stdout, stderr) = run(&[
        "bench",
        "--port",
        port,
        "-n",
        "2",
        "--cycles",
        "50",
        "--json",
        "--echo",
        "absent",
        "--allowance-us",
        "1000000",
    ]);
    assert_eq!(code, Some(0), "{stderr}");
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let runs = json["runs"].as_array().unwrap();
    assert_eq!(runs.iter().map(|run| run["devices"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 2]);
    assert!(runs.iter().all(|run| run["cycles"] == 50), "{stdout}");
    assert_eq!(runs[1]["wire_limit_hz"], 2500.0);
    for run in runs {
        for name in ["core_wait_share", "other_programs_share"] {
            assert!(run[name].as_f64().is_none_or(|share| (0.0..=1.1).contains(&share)), "{name}: {stdout}");
        }
        let bins = run["round_trip_us"].as_array().unwrap();
        let counted = bins.iter().map(|bin| bin["count"].as_u64().unwrap()).sum::<u64>();
        assert_eq!(counted, run["exchanges"].as_u64().unwrap() - run["lost"].as_u64().unwrap(), "{stdout}");
        assert!(bins.iter().all(|bin| bin["from_us"].as_f64() < bin["to_us"].as_f64()), "{stdout}");
        let (mean, p50, max) = (&run["loop_hz"]["mean"], &run["cycle_us"]["p50"], &run["cycle_us"]["max"]);
        let (mean, p50, max) = (mean.as_f64().unwrap(), p50.as_f64().unwrap(), max.as_f64().unwrap());
        assert!(p50 <= max && mean >= 0.999e6 / max, "{stdout}");
        // No cycle can be shorter than one write and one read of a pty.
        assert!(run["loop_hz"]["std"].as_f64().unwrap() < 1e6, "{stdout}");
    }
}

#[test]
fn list_names_the_boards_of_a_port_and_what_they_are() {
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap();
    let (code, stdout, stderr) =
        run(&["list", "--port", port, "--json", "-n", "2", "--wait", "20", "--allowance-us", "100000"]);
    assert_eq!(code, Some(0), "{stderr}");
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let found = json["ports"][0]["boards"].as_array().unwrap();
    let numbers: Vec<_> = found.iter().map(|board| board["board"].as_u64().unwrap()).collect();
    assert_eq!(numbers, [0, 1], "{stdout}");
    assert_eq!(json["ports"][0]["path"], port);
    assert!(found[0]["pressures_kpa"][3].is_number(), "{stdout}");
    let (_, text, _) = run(&["list", "--port", port, "-n", "2", "--wait", "20", "--allowance-us", "100000"]);
    assert!(text.contains("board 1: ") && text.contains("-0.3 -0.3 -0.3 -0.3 kPa"), "{text}");
    assert!(boards.stop().iter().all(|(_, command)| command[0].get() == 102), "only 0 kPa was commanded");
    refused(&["list", "--port", "/dev/no-such-port"], 2, "no such port");
}

/// From the boards to a rig file that runs.
#[test]
fn init_writes_a_rig_file_that_runs_and_replaces_none() {
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rig.toml");
    let path = file.to_str().unwrap();
    let (code, stdout, stderr) = run(&[
        "init",
        path,
        "--port",
        port,
        "-n",
        "2",
        "--wait",
        "20",
        "--allowance-us",
        "100000",
        "--unit",
        "psi",
    ]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains("board(s) 0, 1 on "), "{stdout}");
    let text = fs::read_to_string(&file).unwrap();
    for name in ["left", "right", "front", "back"] {
        assert_eq!(text.matches(&format!("# name = \"{name}\"")).count(), 2, "one a board: {text}");
    }
    assert!(text.contains("unit = \"psi\"") && text.contains("boards = 2"), "{text}");
    let (code, stdout, stderr) =
        run(&["--rig", path, "--duration", "0.2", "--json", "--echo", "absent", "--allowance-us", "1000000"]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains("\"devices\":2,"), "{stdout}");
    refused(&["init", path, "--port", port], 2, "exists and is not replaced");
    assert_eq!(fs::read_to_string(&file).unwrap(), text);
    boards.last_unplugged.store(true, std::sync::atomic::Ordering::Relaxed);
    let second = format!("{path}.2");
    let quick = ["--wait", "0.5", "--allowance-us", "100000"];
    refused(
        &[&["init", &second, "--port", port, "-n", "2"], &quick[..]].concat(),
        1,
        "board(s) 1 did not answer on ",
    );
    assert!(!fs::exists(&second).unwrap());
    let (code, stdout, _) =
        run(&["init", &second, "--port", port, "--wait", "20", "-n", "1", "--allowance-us", "100000"]);
    assert_eq!(code, Some(0), "{stdout}");
}

/// The boards here read what they are commanded, so a gauge that shows 1 % more is a slope of 1 %
/// more.
#[test]
fn calibrate_asks_for_two_pressures_and_writes_them() {
    use std::io::Write;
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rig.toml");
    let path = file.to_str().unwrap();
    fs::write(&file, format!("# ours\n[bus]\nport = \"{port}\"\nboards = 2\n[limits]\nmax_kpa = 250\n"))
        .unwrap();
    let asked = ["calibrate", "--rig", path, "--board", "1", "--settle", "0.5", "--allowance-us", "100000"];
    let mut child = program(&asked).stdin(std::process::Stdio::piped()).spawn().unwrap();
    // Channel 0: a slip, then both; channel 1: a wrong unit, then left; 2 and 3 are left.
    let answers = "fifty\n50.5\n202\n7\n29\n\n\n\n";
    child.stdin.take().unwrap().write_all(answers.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    let (stdout, stderr) =
        (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert_eq!(output.status.code(), Some(0), "{stdout}{stderr}");
    assert!(stdout.contains("\"fifty\" is no number") && stdout.contains("no 100 psi sensor"), "{stdout}");
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.starts_with("# ours\n") && text.contains("[boards.1.channels.0.sensor]"), "{text}");
    assert_eq!(text.matches("zero_counts").count(), 1, "{text}");
    let number = |key: &str| -> f64 {
        let line = text.lines().find_map(|line| line.strip_prefix(key)).unwrap();
        line.trim_start_matches([' ', '=']).parse().unwrap()
    };
    // Sent and read are 162 and 340 counts: 50.162 and 199.975 kPa nominally.
    assert!((number("kpa_per_count") - (202.0 - 50.5) / (340.0 - 162.0)).abs() < 1e-6, "{text}");
    assert!((number("zero_counts") - (162.0 - 50.5 / number("kpa_per_count"))).abs() < 0.01, "{text}");
    refused(&["calibrate", "--port", port], 2, "pass --rig FILE.toml");
    refused(&["calibrate", "--rig", path, "--high", "260"], 2, "above its limit of 250 kPa");
    refused(&["calibrate", "--rig", path, "--low", "200"], 2, "--low must be below --high");
    refused(&["calibrate", "--rig", path, "--board", "2"], 2, "boards 0 to 1");
    assert_eq!(boards.stop().last().unwrap().1, [Counts::ATMOSPHERE; 4]);
}

#[test]
fn completions_and_man_pages_come_from_the_definition() {
    for (shell, expected) in [("bash", "_pneudrive__host()"), ("zsh", "#compdef"), ("fish", "complete -c")] {
        let (code, stdout, _) = run(&["completions", shell]);
        assert!(code == Some(0) && stdout.contains(expected) && stdout.contains("calibrate"), "{stdout}");
    }
    let (code, page, _) = run(&["man"]);
    assert!(code == Some(0) && page.contains(".TH pneudrive-host") && page.contains("max\\-kpa"), "{page}");
    let folder = tempfile::tempdir().unwrap();
    let (code, ..) = run(&["man", folder.path().to_str().unwrap()]);
    assert_eq!(code, Some(0));
    let page = fs::read_to_string(folder.path().join("pneudrive-host-calibrate.1")).unwrap();
    assert!(page.contains("settle"), "{page}");
    refused(&["man", "/no/such/folder"], 2, "/no/such/folder");
}

#[test]
fn rust_log_says_more() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap();
    let said = |level: &str| {
        let args = ["ping", "--port", port, "--count", "1"];
        let output = program(&args).env("RUST_LOG", level).output().unwrap();
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(said("debug").contains("debug: pneudrive_host::"), "{}", said("debug"));
    assert!(!said("warn").contains("debug"), "{}", said("warn"));
}
