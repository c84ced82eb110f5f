//! What a recording is worth when something goes wrong.

use crate::command_line::program::{program, refused, rows, run, table, until};
use crate::support::pty::PtyBoards;
use pneudrive_protocol::Counts;
use std::fs;
use std::path::Path;
use std::process::Command;

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

#[test]
fn a_full_disk_is_an_error_before_anything_moves() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap().to_owned();
    refused(&["--port", &port, "--command", "100", "--record", "/dev/full"], 1, "No space left");
    let commands = boards.stop();
    assert!(commands.iter().all(|(_, command)| *command == [Counts::ATMOSPHERE; 4]), "only pings were sent");
}

/// The disk fills up while recording, in the middle of a block: the run ends, the boards are safe,
/// and what is in the file is whole.
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
    let (code, _, stderr) = run(&[
        "--port",
        &port,
        "--duration",
        "0.2",
        "--allowance-us",
        "1000000",
        "--echo",
        "absent",
        "--record",
        file.to_str().unwrap(),
    ]);
    assert_eq!(code, Some(0), "{stderr}");
    assert_eq!(stderr.matches("belongs to another recording").count(), 1, "{stderr}");
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
