//! Setting the system's time must not touch the bus. Tests cannot set it; but they can see that
//! nothing asks for it.

use std::fs;
use std::path::{Path, PathBuf};

/// What reads the wall clock in Rust and in rustix.
const WALL_CLOCKS: [&str; 3] = ["SystemTime", "ClockId::Realtime", "UNIX_EPOCH"];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn nothing_between_wire_and_rows_reads_the_wall_clock() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    for module in ["line", "bus", "poller", "statistics", "real_time", "../record/src/trajectory"] {
        sources(&src.join(module), &mut files);
    }
    assert!(files.len() > 30, "{files:?}");
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        for clock in WALL_CLOCKS {
            assert!(!text.contains(clock), "{} reads {clock}", file.display());
        }
    }
}
