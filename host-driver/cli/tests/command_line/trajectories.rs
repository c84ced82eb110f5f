//! What is played, and when.

use crate::command_line::program::{program, refused, run, table};
use crate::support::pty::PtyBoards;
use pneudrive_protocol::Counts;
use std::fs;

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
        let files = ["--trajectory", &path(from), "--record", &path(to)];
        let patient = ["--port", &port, "--rate", "200", "--allowance-us", "100000"];
        let (code, _, stderr) = run(&[&patient[..], &files].concat());
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

/// Left out without a word, a misspelt column would leave its chamber at 0 kPa.
#[test]
fn columns_that_are_no_commands_are_refused_or_named() {
    let folder = tempfile::tempdir().unwrap();
    let steps = folder.path().join("steps.csv");
    let preview = ["--port", "x", "--preview", "--trajectory", steps.to_str().unwrap()];
    fs::write(&steps, "t_s,b0_cdm0_kpa,b0_cmd1_kpa\n0,100,0\n1,0,0\n").unwrap();
    refused(
        &preview,
        2,
        "column b0_cdm0_kpa is not one that a trajectory has; did you mean b0_cmd0_kpa? Rename it",
    );
    fs::write(&steps, "t_s,note,b0_cmd1_kpa,b0_p1_kpa,b0_u1,bend\n0,a,0,0,0,1\n1,b,0,0,0,2\n").unwrap();
    let (code, _, stderr) = run(&preview);
    let said = format!(
        "warning: {}: ignored, for they are no commands (b{{n}}_cmd{{k}}_kpa): note, bend\n",
        steps.display()
    );
    assert_eq!((code, stderr), (Some(0), said));
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
        "--allowance-us",
        "100000",
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
fn a_trajectory_is_played_to_its_end_and_recorded() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    let (steps, file) = (folder.path().join("steps.csv"), folder.path().join("run.csv"));
    fs::write(&steps, "t_s,b0_cmd2_kpa\n0,0\n0.1,100\n0.2,200\n").unwrap();
    let args = [
        "--port",
        &port,
        "--allowance-us",
        "100000",
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

/// From a shape to a run: made, piped in, played twice as fast, and seen by who listens.
#[test]
fn a_generated_trajectory_is_played_from_standard_input_and_streamed() {
    use std::io::Write;
    let (code, table, stderr) =
        run(&["generate", "steps", "--seconds", "1", "--hold", "0.1", "--high", "50"]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(table.starts_with("t_s,b0_cmd0_kpa,b0_cmd1_kpa,b0_cmd2_kpa,b0_cmd3_kpa\n0.000,0.00,"), "{table}");
    assert!(table.contains("\n0.500,50.00,50.00,50.00,50.00\n"), "{table}");
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    let listener = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    listener.set_read_timeout(Some(std::time::Duration::from_secs(60))).unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let args =
        ["--port", &port, "--rate", "100", "--trajectory", "-", "--speed", "2", "--udp", &address, "--json"];
    let args = [&args[..], &["--allowance-us", "100000"]].concat();
    let mut child = program(&args).stdin(std::process::Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(table.as_bytes()).unwrap();
    let mut bytes = [0; 2048];
    let count = listener.recv(&mut bytes).unwrap();
    let row: serde_json::Value = serde_json::from_slice(&bytes[..count]).unwrap();
    assert!(
        row["t_s"].is_number() && row["b0_cmd3_kpa"].is_number() && row["b0_p0_kpa"].is_number(),
        "{row}"
    );
    let output = child.wait_with_output().unwrap();
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["ended"], "trajectory");
    assert!(json["seconds"].as_f64().unwrap() >= 0.5, "{json}");
    assert!(boards.stop().iter().any(|(_, command)| command[0].get() == 162), "50 kPa was commanded");
    refused(&["--port", "x", "--repeat"], 2, "--trajectory");
    refused(&["--port", "x", "--trajectory", "y", "--speed", "0"], 2, "expected a number from 0.01 to 100");
    refused(&["generate", "sine", "--low", "300"], 2, "--low must be below --high");
}
