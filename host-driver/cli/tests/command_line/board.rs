//! `board status`: what boards say of themselves.

use crate::command_line::program::{refused, run};
use crate::support::pty::PtyBoards;

/// Of virtual boards, on a machine that may be busy.
fn status(more: &[&str]) -> (Option<i32>, String, String) {
    let patient = ["board", "status", "--port", "sim", "--wait", "60", "--allowance-us", "100000"];
    run(&[&patient, more].concat())
}

#[test]
fn a_virtual_board_tells_state_drives_and_version() {
    let (code, stdout, stderr) = status(&["--board", "1", "--json"]);
    assert_eq!(code, Some(0), "{stderr}");
    let json: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((&json["board"], &json["schema"]), (&1.into(), &1.into()), "{stdout}");
    assert_eq!(json["firmware"], env!("CARGO_PKG_VERSION"), "{stdout}");
    // For 2 s after power-up they vent; then the missing host is waited for.
    let vents = ["power_up_vent", "vent"].contains(&json["state"].as_str().unwrap());
    let regulates = ["running", "hold"].contains(&json["state"].as_str().unwrap());
    let each = if vents { "venting" } else { "regulating" };
    assert!(vents || regulates, "{stdout}");
    assert_eq!(json["channels"], serde_json::json!([each, each, each, each]));
    let drives = json["drives"].as_array().unwrap().iter().map(|drive| drive.as_f64().unwrap());
    assert!(
        drives.into_iter().all(|drive| if vents { drive == -1.0 } else { drive.abs() < 0.5 }),
        "{stdout}"
    );
    assert!(json["post_mortem"].is_null(), "{stdout}");
    let counters = json["counters"].as_object().unwrap();
    assert_eq!(
        (counters.len(), &counters["requests"], &counters["watchdog_resets"]),
        (16, &0.into(), &0.into())
    );
    assert!(counters["page_requests"].as_u64().unwrap() > 0, "{stdout}");

    let (code, text, stderr) = status(&[]);
    assert_eq!(code, Some(0), "{stderr}");
    let version = env!("CARGO_PKG_VERSION");
    assert!(text.contains(&format!("board 0: no chip (simulated), firmware {version}, ")), "{text}");
    assert!(text.contains("channel 3: ") && text.contains(", drive "), "{text}");
    assert!(text.contains("command timeouts: 0"), "{text}");
    assert!(text.contains("last reset by the watchdog: none known"), "{text}");
}

/// Boards of before pages hear nothing that they would answer, and nothing is commanded to them.
#[test]
fn a_board_without_pages_is_said_to_be_one_and_is_not_commanded() {
    let boards = PtyBoards::start(2);
    let port = boards.path().to_str().unwrap();
    let arguments = ["board", "status", "--port", port, "--board", "1", "--echo", "absent", "--wait", "0.1"];
    refused(&arguments, 1, "firmware of before pages does not answer them");
    assert!(boards.stop().is_empty());
    refused(&["board", "status", "--port", "sim", "--board", "4"], 2, "--max-devices");
    let (code, _, stderr) = status(&["--sim-original", "0"]);
    assert!(code == Some(1) && stderr.contains("it has no pages"), "{stderr}");
    refused(&["board", "--port", "sim"], 2, "status");
}

/// A file that is none is refused before a port is opened; virtual boards have no flash to be
/// updated.
#[test]
fn an_update_that_cannot_be_is_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let nowhere = ["--port", "/dev/ttyNone"];
    let hello = write("hello.bin", b"hello");
    refused(&[&["board", "update", &hello][..], &nowhere].concat(), 2, "no program of a PneuDrive board");
    let elf = write("cut.elf", b"\x7fELF\x01\x01");
    refused(&[&["board", "update", &elf][..], &nowhere].concat(), 2, "a damaged ELF file");
    let missing = folder.path().join("missing.uf2");
    refused(&[&["board", "update", missing.to_str().unwrap()][..], &nowhere].concat(), 2, "cannot read");
    // What could be a program.
    let mut program = vec![0; 1_000];
    let words = [(0, 0x2004_0000_u32), (4, 0x2000_00d1), (192, 0x3146_4450), (196, 1_000), (200, 1)];
    for (at, word) in words {
        program[at..at + 4].copy_from_slice(&word.to_le_bytes());
    }
    let program = write("program.bin", &program);
    let patient = ["board", "update", &program, "--port", "sim", "--allowance-us", "100000"];
    let (code, _, stderr) = run(&patient);
    assert_eq!(code, Some(1), "{stderr}");
    assert!(stderr.contains("no chip (simulated) is not updated over the bus; flash it"), "{stderr}");
}
