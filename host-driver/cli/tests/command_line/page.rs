//! The live page, as far as the command line has to do with it.

use crate::command_line::program::{refused, run, signal};
use crate::support::pty::PtyBoards;
use rustix::process::Signal;
use std::fs;
use std::process::Command;
use std::process::Stdio;

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
    with(&["--web", &address], "another program has this port; choose another, for example --web ");
    with(&["--allow-control"], "--web");
    with(&["--web=0", "--allow-control", "--control-limit", "0"], "must be a number of kPa above 0");
    with(&["--web=0", "--allow-control", "--web-deadman", "0.1"], "must be 0.5 to 60 s");
    with(&["--web=0", "--web-deadman", "3"], "--allow-control");
    with(&["--web=0", "--record-folder", "/proc"], "--record-folder /proc: nothing can be written there: ");
    with(&["--web=0", "--record-folder", "/no/such/folder"], "--record-folder /no/such/folder: No such file");
    let file = token.to_str().unwrap();
    with(&["--web=0", "--allow-control", "--control-token-file", file], "16 to 256 characters");
}

/// What the sensors' full scale is, the rig file says.
#[test]
fn the_page_may_command_what_the_sensors_of_the_rig_can_measure_and_no_more() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let rig = |name: &str, kpa_per_count: f64| {
        let file = folder.path().join(name);
        let channel = |k: u8| {
            format!("[boards.0.channels.{k}.sensor]\nzero_counts = 102.4\nkpa_per_count = {kpa_per_count}\n")
        };
        fs::write(&file, (0..4).map(channel).collect::<String>()).unwrap();
        file.to_str().unwrap().to_owned()
    };
    let (small, large) = (rig("small.toml", 0.2), rig("large.toml", 1.2));
    let page = |limit: &'static str| ["--port", port, "--web=0", "--allow-control", "--control-limit", limit];
    refused(&page("700"), 2, "--control-limit 700: at most 689.5 kPa");
    refused(&[&page("190")[..], &["--rig", &small]].concat(), 2, "--control-limit 190: at most 163.8 kPa");
    assert!(boards.stop().is_empty(), "bytes were sent");

    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap();
    let duration = ["--port", port, "--web=0", "--allow-control", "--duration", "0.2"];
    // The default is no more than they can measure, and needs no other word.
    for more in [&["--control-limit", "900", "--rig", &large][..], &["--rig", &small]] {
        let (code, stdout, stderr) = run(&[&duration[..], more].concat());
        assert_eq!(code, Some(0), "{more:?}: {stdout}{stderr}");
    }
}

/// The page starts a recording, the disk fills up, and nobody looks at the page any more.
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

#[test]
fn the_pages_address_is_said_and_others_are_warned_about() {
    let boards = PtyBoards::start(1);
    let port = boards.path().to_str().unwrap();
    let patient = ["--port", port, "--duration", "0.2", "--echo", "absent", "--allowance-us", "1000000"];
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
