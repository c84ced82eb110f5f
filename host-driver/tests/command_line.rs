//! The program as users run it: what it refuses, what it leaves behind, how it ends.

#![cfg(feature = "cli")]
#![allow(clippy::unwrap_used)]

mod support;

use pneudrive_protocol::Counts;
use rustix::process::{Pid, Signal, kill_process};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use support::counts;
use support::pty::PtyBoards;

fn program(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pneudrive-host"));
    command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn run(args: &[&str]) -> (Option<i32>, String, String) {
    let Output { status, stdout, stderr } = program(args).output().unwrap();
    (status.code(), String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap())
}

/// It must end with `status` and say `message`.
#[track_caller]
fn refused(args: &[&str], status: i32, message: &str) {
    let (code, stdout, stderr) = run(args);
    assert_eq!(code, Some(status), "{args:?}: {stdout}{stderr}");
    assert!(stderr.contains(message), "{args:?} said: {stderr}");
    assert!(!stderr.contains("panicked"), "{stderr}");
}

fn until(what: &str, mut done: impl FnMut() -> bool) {
    let started = Instant::now();
    while !done() {
        assert!(started.elapsed() < Duration::from_secs(60), "waiting for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

/// Complete rows below the header.
fn rows(path: &Path) -> usize {
    fs::read_to_string(path).map_or(0, |text| table(&text).count().saturating_sub(1))
}

/// Header and rows.
fn table(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|line| !line.starts_with('#'))
}

#[test]
fn unusable_arguments_are_refused_with_advice() {
    refused(&[], 2, "no --port given");
    refused(&["--port", "/dev/no-such-port"], 2, "no such port");
    refused(&["--port", "/dev/null"], 2, "not a serial port");
    refused(&["--port", "x", "--devices", "0"], 2, "--devices 0: must be 1 to 4");
    refused(&["--port", "x", "--devices", "5"], 2, "need --max-devices");
    refused(
        &["--port", "x", "--devices", "256", "--max-devices", "256"],
        2,
        "--echo present or --echo absent",
    );
    refused(&["--port", "x", "--max-devices", "257"], 2, "257 is not in 1..=256");
    refused(&["--port", "x", "--baud", "300"], 2, "300 baud is outside 1200 to 7812500 baud");
    refused(&["--port", "x", "--rate", "5001"], 2, "at most 5000.0 Hz, the wire's limit for 1 board");
    refused(&["--port", "x", "--rate", "0"], 2, "--rate 0: must be above 0");
    refused(&["--port", "x", "--rate", "NaN"], 2, "--rate NaN");
    refused(&["--port", "x", "--filter=1.5"], 2, "filter weight");
    refused(&["--port", "x", "--duration", "-1"], 2, "--duration");
    for command in ["NaN", "-100", "776", "1,2,3", "1,2,3,4,5", "a"] {
        refused(&["--port", "x", "--command", command], 2, "--command");
    }
    refused(&["--port", "x", "--command", "1:5"], 2, "boards 0 to 0");
    refused(&["--port", "x", "--record", "run.txt"], 2, "ends in .csv, .csv.gz, .csv.zst or .mcap");
    refused(&["--port", "x", "--record", "/no/such/folder/run.csv"], 2, "no such folder");
    refused(&["--port", "x", "--record", "run.csv", "ping"], 2, "not to `ping`");
    refused(&["timing", "--capacitor-nf", "0"], 2, "capacitance");
    refused(&["timing", "--baud", "1"], 2, "1 baud");
}

#[test]
fn a_bad_trajectory_is_refused_before_the_port_is_touched() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("steps.csv");
    fs::write(&file, "t_s,b0_cmd0_kpa\n0,100\n1,900\n").unwrap();
    let path = file.to_str().unwrap();
    refused(&["--port", "/dev/no-such-port", "--trajectory", path], 2, "row 3, column b0_cmd0_kpa");
    refused(&["--port", "x", "--trajectory", "/no/such.csv"], 2, "/no/such.csv: No such file");
}

#[test]
fn what_is_above_a_limit_is_refused_before_the_port_is_touched() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let rig = file("rig.toml", "[limits]\nmax_kpa = 300.0\n[boards.1.channels.3.limits]\nmax_kpa = 100.0\n");
    let steps = file("steps.csv", "t_s,b0_cmd0_kpa\n0,100\n1.5,250\n");
    let with = |more: &[&str], message: &str| {
        refused(&[&["--port", "/dev/no-such-port", "--devices", "2"], more].concat(), 2, message);
    };
    with(
        &["--max-kpa", "200", "--command", "201"],
        "200.8 kPa for channel 0 of board 0 is above its limit of 200",
    );
    with(&["--max-kpa", "200", "--command", "200"], "no such port");
    with(
        &["--rig", &rig, "--command", "150"],
        "--command: 150.3 kPa for channel 3 of board 1 is above its limit of 100",
    );
    with(
        &["--max-kpa", "200", "--trajectory", &steps],
        "steps.csv: at 1.5 s: 250.0 kPa for channel 0 of board 0",
    );
    with(&["--max-kpa", "-1"], "expected a number of kPa gauge from 0 on");
    with(&["--max-rate-kpa-s", "0"], "expected a number above 0");
    let misspelt = file("misspelt.toml", "[limits]\nmax = 300.0\n");
    with(
        &["--rig", &misspelt],
        "misspelt.toml:2: unknown field `max`, expected `max_kpa` or `max_rate_kpa_s`",
    );
    with(&["--rig", "/no/such.toml"], "/no/such.toml: cannot be read");
}

#[test]
fn nobody_there_is_an_error_and_leaves_no_recording() {
    let boards = PtyBoards::start(1);
    boards.last_unplugged.store(true, std::sync::atomic::Ordering::Relaxed);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let port = boards.path().to_str().unwrap();
    refused(
        &["--port", port, "--wait", "0.1", "--record", file.to_str().unwrap()],
        1,
        "none of the 1 board(s) answered within 0.1 s; the last try said: board 0 (0xFFFF): no answer after ",
    );
    assert!(!file.exists());
    refused(&["ping", "--port", port, "--wait", "0.1"], 1, "none of the 1 board(s) answered");
}

#[test]
fn an_existing_recording_is_kept_unless_told_otherwise() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let path = file.to_str().unwrap();
    fs::write(&file, "precious").unwrap();
    refused(&["--port", port, "--duration", "0.05", "--record", path], 2, "--overwrite");
    assert_eq!(fs::read_to_string(&file).unwrap(), "precious");
    let (code, ..) = run(&["--port", port, "--duration", "0.05", "--record", path, "--overwrite"]);
    assert_eq!(code, Some(0));
    assert!(rows(&file) > 0);
}

/// A recording would replace the trajectory that it is commanded by: by its name, another name, or
/// another name still.
#[test]
fn a_recording_never_replaces_what_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (steps, rig) = (path("steps.csv"), path("rig.toml"));
    let text = "t_s,b0_cmd0_kpa\n0,10\n1,20\n";
    fs::write(&steps, text).unwrap();
    fs::write(&rig, "[limits]\nmax_kpa = 100.0\n").unwrap();
    std::os::unix::fs::symlink(&steps, path("soft.csv")).unwrap();
    fs::hard_link(&steps, path("hard.csv")).unwrap();
    fs::hard_link(&rig, path("rig.csv")).unwrap();
    fs::create_dir(path("sub")).unwrap();
    for name in ["steps.csv", "soft.csv", "hard.csv", "sub/../steps.csv"] {
        let record = path(name);
        let args = ["--port", "x", "--trajectory", &steps, "--record", &record, "--overwrite"];
        refused(&args, 2, "it is the file of --trajectory");
    }
    let args = ["--port", "x", "--rig", &rig, "--record", &path("rig.csv"), "--overwrite"];
    refused(&args, 2, "it is the file of --rig");
    assert_eq!(fs::read_to_string(&steps).unwrap(), text);
}

/// From a recording of a recording: compressed, and as a bag.
#[test]
fn what_the_program_records_it_plays() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(path("steps.csv"), "t_s,b0_cmd2_kpa\n0.1,100\n0.2,200\n0.3,50\n").unwrap();
    for (from, to) in
        [("steps.csv", "a.csv.zst"), ("a.csv.zst", "b.csv.gz"), ("b.csv.gz", "c.mcap"), ("c.mcap", "d.csv")]
    {
        let (code, _, stderr) =
            run(&["--port", &port, "--rate", "200", "--trajectory", &path(from), "--record", &path(to)]);
        assert_eq!(code, Some(0), "{from} to {to}: {stderr}");
        let late = stderr.contains("the trajectory begins at 0.100 s; --from-first-row begins");
        assert_eq!(late, from == "steps.csv", "{stderr}");
    }
    let text = fs::read_to_string(path("d.csv")).unwrap();
    let mut commands: Vec<_> = table(&text).skip(1).map(|row| row.split(',').nth(3).unwrap()).collect();
    commands.dedup();
    // 0 kPa until the first row's time.
    assert_eq!(commands, ["0.000", "99.819", "199.975", "50.162"]);
    assert!(text.contains("\n# command_line: [\"") && text.contains("c.mcap"), "{text}");
    assert!(text.lines().last().unwrap().contains("\"text\":\"trajectory: "), "{text}");
}

#[test]
fn a_trajectory_can_begin_with_its_first_row() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let (steps, file) = (folder.path().join("steps.csv"), folder.path().join("run.csv"));
    fs::write(&steps, "t_s,b0_cmd0_kpa\n1000,100\n1000.1,50\n").unwrap();
    let files = [steps.to_str().unwrap(), file.to_str().unwrap()];
    let args = [
        "--port",
        &port,
        "--rate",
        "200",
        "--from-first-row",
        "--trajectory",
        files[0],
        "--record",
        files[1],
    ];
    let (code, _, stderr) = run(&args);
    assert_eq!(code, Some(0), "{stderr}");
    let text = fs::read_to_string(&file).unwrap();
    let row = table(&text).nth(1).unwrap();
    assert!(row.starts_with("0.000000000,99.819,"), "{row}");
    refused(&["--port", "x", "--from-first-row"], 2, "--trajectory");
}

#[test]
fn a_full_disk_is_an_error_before_anything_moves() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    refused(&["--port", &port, "--command", "100", "--record", "/dev/full"], 1, "No space left");
    let commands = boards.stop();
    assert!(commands.iter().all(|(_, command)| *command == [Counts::ATMOSPHERE; 4]), "only pings were sent");
}

/// The disk fills up while recording, in the middle of a block: the run ends, the boards are safe, and what is in the file is whole.
#[test]
fn a_disk_that_fills_up_ends_the_run_and_cuts_no_row() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    // A limit of 40 KiB on files stands for the full disk; 500 rows a second are about 35 KiB.
    let script = "trap '' XFSZ; ulimit -f 40; exec \"$@\"";
    let host = env!("CARGO_BIN_EXE_pneudrive-host");
    let args = ["-c", script, "bash", host, "--port", &port, "--rate", "500", "--command", "100", "--record"];
    let output = Command::new("bash").args(args).arg(&file).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    let rows_said =
        stderr.split("writing failed after ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.ends_with('\n'), "the file ends in the middle of a row");
    assert_eq!(rows(&file), rows_said.parse::<usize>().unwrap(), "{stderr}");
    assert!(rows(&file) > 0);
    assert_eq!(boards.stop().last(), Some(&(0, [Counts::ATMOSPHERE; 4])));
}

#[test]
fn the_json_object_keeps_its_contract() {
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap();
    let (code, stdout, stderr) = run(&[
        "--port",
        port,
        "-n",
        "2",
        "--rate",
        "200",
        "--duration",
        "0.5",
        "--json",
        "--allowance-us",
        "5000000",
    ]);
    assert_eq!(code, Some(0), "{stderr}");
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((&json["schema"], &json["program"]), (&1.into(), &"pneudrive-host".into()));
    assert_eq!((&json["version"], &json["port"]), (&env!("CARGO_PKG_VERSION").into(), &port.into()));
    assert_eq!(json["ended"], "duration");
    let started = json["started_utc"].as_str().unwrap();
    assert!(started.starts_with("20") && started.ends_with('Z'), "{stdout}");
    assert_eq!(json["devices"], 2);
    let cycles = json["cycles"].as_u64().unwrap();
    assert!((2..=102).contains(&cycles), "at most 0.5 s at 200 Hz and both ends: {cycles}");
    for (group, names) in
        [("loop_hz", &["mean", "std", "min"][..]), ("cycle_us", &["p50", "p99", "p999", "max"])]
    {
        for name in names {
            assert!(json[group][name].is_number(), "{group}.{name} in {stdout}");
        }
    }
    for name in ["seconds", "exchanges", "lost", "rejected", "cpu_share"] {
        assert!(json[name].is_number(), "{name} in {stdout}");
    }
    for board in json["boards"].as_array().unwrap() {
        assert!(board["answered"].as_u64().unwrap() > 0 && board["lost"].is_u64(), "{stdout}");
        assert_eq!(board["state"], "present");
    }
    let sum = json["boards"].as_array().unwrap().iter().map(|b| b["answered"].as_u64().unwrap()).sum::<u64>();
    assert_eq!(json["exchanges"].as_u64().unwrap(), sum + json["lost"].as_u64().unwrap());
}

#[test]
fn a_trajectory_is_played_to_its_end_and_recorded() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let (steps, file) = (folder.path().join("steps.csv"), folder.path().join("run.csv"));
    fs::write(&steps, "t_s,b0_cmd2_kpa\n0,0\n0.1,100\n0.2,200\n").unwrap();
    let args = [
        "--port",
        &port,
        "--command",
        "50",
        "--trajectory",
        steps.to_str().unwrap(),
        "--record",
        file.to_str().unwrap(),
    ];
    let (code, _, stderr) = run(&args);
    assert_eq!(code, Some(0), "{stderr}");
    let text = fs::read_to_string(&file).unwrap();
    let recorded = |kpa: &str| text.lines().any(|line| line.split(',').nth(3) == Some(kpa));
    assert!(recorded("0.000") && recorded("99.819") && recorded("199.975"), "{text}");
    // The boards answer what they were commanded: command and pressure of one row belong together.
    for line in table(&text).skip(1) {
        let cells: Vec<_> = line.split(',').collect();
        assert_eq!(cells.len(), 9, "{line}");
        let pressures_are_commands = (1..=4).all(|k| cells[k] == cells[k + 4] || cells[k] == "0.000");
        assert!(pressures_are_commands || cells[5].is_empty(), "{line}");
    }
    assert_eq!(boards.stop().last(), Some(&(0, [Counts::ATMOSPHERE; 4])));
}

#[test]
fn signals_end_a_run_with_the_boards_at_zero() {
    for stop in [Signal::INT, Signal::TERM, Signal::HUP] {
        let boards = PtyBoards::start(2);
        let port = boards.path().to_str().unwrap().to_owned();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("run.csv");
        let args = ["--port", &port, "-n", "2", "--command", "100", "--record", file.to_str().unwrap()];
        let child = program(&args).spawn().unwrap();
        until("rows", || rows(&file) > 10);
        signal(&child, stop);
        let output = child.wait_with_output().unwrap();
        let stdout = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(0), "{stop:?}: {stdout}");
        let last = fs::read_to_string(&file).unwrap().lines().last().unwrap().to_owned();
        assert!(last.contains("\"kind\":\"end\",\"text\":\"signal: "), "{last}");
        assert!(stdout.contains("cycles of 2 board(s)") && stdout.contains("run.csv"), "{stdout}");
        let commands = boards.stop();
        assert!(commands.contains(&(1, counts(221))), "100 kPa was commanded");
        for board in [0, 1] {
            let last = commands.iter().rfind(|(of, _)| *of == board).unwrap();
            assert_eq!(last.1, [Counts::ATMOSPHERE; 4]);
        }
    }
}

/// Half a second of rows at most may be missing, and none may be cut.
#[test]
fn a_recording_survives_kill_9() {
    for name in ["run.csv", "run.csv.gz", "run.csv.zst"] {
        let boards = PtyBoards::start(1);
        let port = boards.path().to_str().unwrap().to_owned();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        let args = ["--port", &port, "--rate", "500", "--record", file.to_str().unwrap()];
        let mut child = program(&args).spawn().unwrap();
        // Header, and two blocks of rows.
        until("three blocks", || text_of(&file).lines().count() > 300);
        child.kill().unwrap();
        child.wait().unwrap();
        let text = text_of(&file);
        assert!(text.ends_with('\n'), "{name} ends in the middle of a row");
        let cells = table(&text).next().unwrap().split(',').count();
        assert!(table(&text).all(|line| line.split(',').count() == cells), "{name}");
        assert!(text.starts_with("# pneudrive_recording: 1\n"), "{name}: {text}");
    }
}

/// A streaming reader finds whole chunks up to the end, of every topic.
#[test]
fn a_bag_survives_kill_9() {
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let args = ["--port", &port, "--devices", "2", "--rate", "500", "--record", file.to_str().unwrap()];
    let mut child = program(&args).spawn().unwrap();
    until("three blocks", || messages(&file).0.len() > 600);
    child.kill().unwrap();
    child.wait().unwrap();
    let (topics, end) = messages(&file);
    assert_eq!(end.as_deref(), Some("MCAP file ended in the middle of a record"), "there is no end");
    let count = |topic: &str| topics.iter().filter(|name| *name == topic).count();
    let (first, second) =
        (count("/pneudrive/joint_0/pressure_state"), count("/pneudrive/joint_1/pressure_state"));
    assert!(first > 300 && first == second, "{first} and {second} states: rows are whole");
    assert_eq!(count("/pneudrive/joint_1/pressure_command"), 1, "it never changed");
    assert!(folder.path().join("metadata.yaml").exists());
}

/// A bag's topics message by message, and what the reader said at the end if that was an error.
fn messages(path: &Path) -> (Vec<String>, Option<String>) {
    let mut topics = Vec::new();
    let Ok(file) = fs::File::open(path) else { return (topics, None) };
    for message in mcap::io::MessageReader::new(file) {
        match message {
            Ok(message) => topics.push(message.channel.topic.clone()),
            Err(error) => return (topics, Some(error.to_string())),
        }
    }
    (topics, None)
}

/// A second recording in the folder of a first leaves the first's metadata.yaml alone, and says so.
#[test]
fn metadata_of_another_bag_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let metadata = folder.path().join("metadata.yaml");
    let other = "rosbag2_bagfile_information:\n  relative_file_paths: ['other.mcap']\n";
    fs::write(&metadata, other).unwrap();
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let file = folder.path().join("run.mcap");
    let (code, _, stderr) = run(&["--port", &port, "--duration", "0.2", "--record", file.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stderr.contains("belongs to another recording"), "{stderr}");
    assert_eq!(fs::read_to_string(&metadata).unwrap(), other);
    let (topics, end) = messages(&file);
    assert!(!topics.is_empty() && end.is_none(), "{end:?}");
}

/// The text of a recording, as any tool reads it: to the end, without an error.
fn text_of(path: &Path) -> String {
    use std::io::Read;
    let stored = fs::read(path).unwrap_or_default();
    if stored.is_empty() {
        return String::new();
    }
    let mut text = String::new();
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("gz") => {
            flate2::read::MultiGzDecoder::new(&stored[..]).read_to_string(&mut text).map(drop).unwrap()
        }
        Some("zst") => text = String::from_utf8(zstd::decode_all(&stored[..]).unwrap()).unwrap(),
        _ => text = String::from_utf8(stored).unwrap(),
    }
    text
}

#[test]
fn a_second_host_is_refused_by_name() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let mut first = program(&["--port", &port, "--record", file.to_str().unwrap()]).spawn().unwrap();
    until("the first host", || rows(&file) > 10);
    refused(&["ping", "--port", &port], 2, "in use by another process");
    refused(&["--port", &port], 2, "in use by another process");
    first.kill().unwrap();
    first.wait().unwrap();
}

#[test]
fn a_port_that_vanishes_ends_the_run_with_its_reason() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.csv");
    let child = program(&["--port", &port, "--record", file.to_str().unwrap()]).spawn().unwrap();
    until("rows", || rows(&file) > 10);
    drop(boards);
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("the port is gone"), "{stderr}");
    assert!(stderr.contains("0 kPa was not confirmed by board(s) 0"), "{stderr}");
}

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

/// `pneudrive-host .. | head -1`
#[test]
fn a_reader_that_has_seen_enough_is_no_panic() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap();
    for args in [
        &["bench", "--port", port, "-n", "1", "--cycles", "50", "--allowance-us", "1000000"][..],
        &["ping", "--port", port],
        &["timing"],
        &["--port", port, "--duration", "0.3"],
    ] {
        let mut child = program(args).spawn().unwrap();
        drop(child.stdout.take());
        let stderr = String::from_utf8(child.wait_with_output().unwrap().stderr).unwrap();
        assert!(!stderr.contains("panicked"), "{args:?}: {stderr}");
    }
}

#[test]
fn ping_names_each_board() {
    let boards = PtyBoards::start(3);
    boards.last_unplugged.store(true, std::sync::atomic::Ordering::Relaxed);
    let port = boards.path().to_str().unwrap();
    let (code, stdout, stderr) = run(&["ping", "--port", port, "-n", "3", "--wait", "0.2", "--count", "5"]);
    assert_eq!(code, Some(1));
    assert!(stdout.contains("board 1: ") && stdout.contains("-0.3 -0.3 -0.3 -0.3 kPa"), "{stdout}");
    assert!(
        stdout.contains("board 2: 0 of 5 answered\n  last error: board 2 (0xFFFD): no answer"),
        "{stdout}"
    );
    assert!(stderr.contains("1 of 3 boards did not answer"), "{stderr}");
}

#[test]
fn bench_prints_a_row_for_each_number_of_boards() {
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap();
    let (code, stdout, stderr) =
        run(&["bench", "--port", port, "-n", "2", "--cycles", "50", "--json", "--allowance-us", "5000000"]);
    assert_eq!(code, Some(0), "{stderr}");
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let runs = json["runs"].as_array().unwrap();
    assert_eq!(runs.iter().map(|run| run["devices"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 2]);
    assert!(runs.iter().all(|run| run["cycles"] == 50), "{stdout}");
    assert_eq!(runs[1]["wire_limit_hz"], 2500.0);
    for run in runs {
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

#[cfg(feature = "web")]
#[test]
fn unusable_web_options_are_refused_before_the_port_is_touched() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let folder = tempfile::tempdir().unwrap();
    let token = folder.path().join("token");
    fs::write(&token, "short\n").unwrap();
    let with = |more: &[&str], message: &str| {
        refused(&[&["--port", "/dev/no-such-port"], more].concat(), 2, message);
    };
    with(&["--web", "nonsense"], "expected ADDRESS:PORT");
    with(&["--web", &address], "choose another address or port");
    with(&["--allow-control"], "--web");
    with(&["--web=0", "--allow-control", "--control-limit", "700"], "at most 689.5 kPa");
    with(&["--web=0", "--allow-control", "--web-deadman", "0.1"], "must be 0.5 to 60 s");
    with(&["--web=0", "--web-deadman", "3"], "--allow-control");
    with(&["--web=0", "--record-folder", "/no/such/folder"], "--record-folder /no/such/folder: No such file");
    let file = token.to_str().unwrap();
    with(&["--web=0", "--allow-control", "--control-token-file", file], "16 to 256 characters");
}

/// The page starts a recording, the disk fills up, and nobody looks at the page any more.
#[cfg(feature = "web")]
#[test]
fn a_recording_from_the_page_that_fails_is_told_on_the_terminal_and_in_the_status() {
    use std::io::{BufRead, BufReader, Read, Write};
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    // A limit of 40 KiB on files stands for the full disk.
    let script = "trap '' XFSZ; ulimit -f 40; exec \"$@\"";
    let host = env!("CARGO_BIN_EXE_pneudrive-host");
    let args =
        ["-c", script, "bash", host, "--port", &port, "--rate", "500", "--web=0", "--record-format", "csv"];
    let mut child = Command::new("bash")
        .args(args)
        .arg("--record-folder")
        .arg(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stderr = BufReader::new(child.stderr.take().unwrap()).lines().map(|line| line.unwrap());
    let line = stderr.find(|line| line.contains("live page: http://")).unwrap();
    let address = line.split("http://").nth(1).unwrap().trim_end_matches('/').to_owned();
    let mut stream = std::net::TcpStream::connect(&address).unwrap();
    let head = "Content-Type: application/json\r\nContent-Length: 0\r\nConnection: close\r\n";
    write!(
        stream,
        "POST /api/record/start HTTP/1.1\r\nHost: {address}\r\nOrigin: http://{address}\r\n{head}\r\n"
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    let told = stderr.find(|line| line.contains("a recording from the page failed: ")).unwrap();
    assert!(told.contains("writing failed after"), "{told}");
    signal(&child, Signal::INT);
    let last: Vec<_> = stderr.collect();
    assert_eq!(child.wait().unwrap().code(), Some(1), "{last:?}");
    assert!(last.last().unwrap().starts_with("error: "), "{last:?}");
}

#[cfg(feature = "web")]
#[test]
fn the_pages_address_is_said_and_others_are_warned_about() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap();
    let patient = ["--port", port, "--duration", "0.2", "--allowance-us", "5000000"];
    let (code, _, stderr) = run(&[&patient[..], &["--web=0"]].concat());
    assert!(code == Some(0) && stderr.contains("live page: http://127.0.0.1:"), "{stderr}");
    assert!(!stderr.contains("token") && !stderr.contains("reached by others"), "{stderr}");
    let (code, _, stderr) = run(&[&patient[..], &["--web", "0.0.0.0:0", "--allow-control"]].concat());
    assert!(
        code == Some(0) && stderr.contains("can be reached by others: they can look, vent, and"),
        "{stderr}"
    );
    let token = stderr.split("#token=").nth(1).unwrap().split_whitespace().next().unwrap();
    assert!(token.len() == 32 && token.bytes().all(|byte| byte.is_ascii_hexdigit()), "{stderr}");
}
