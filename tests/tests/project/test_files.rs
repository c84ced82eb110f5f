//! No test is forgotten: tests of a crate are one binary, which runs the files that it names and no
//! others.

use std::path::{Path, PathBuf};

fn read(path: &Path) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// The source that names the modules of a folder.
fn owner(folder: &Path) -> Option<String> {
    [folder.join("main.rs"), folder.join("mod.rs"), folder.with_extension("rs")]
        .iter()
        .find_map(|path| read(path))
}

/// Files below a folder that nobody names.
fn forgotten(folder: &Path) -> Vec<PathBuf> {
    let names = owner(folder);
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            found.extend(forgotten(&path));
        } else if path.extension().is_some_and(|e| e == "rs") && !["main", "mod"].contains(&&*stem) {
            let named =
                |text: &String| text.lines().any(|line| line.trim_start().ends_with(&format!("mod {stem};")));
            if !names.as_ref().is_some_and(named) {
                found.push(path);
            }
        }
    }
    found
}

#[test]
fn every_file_of_tests_is_in_a_binary() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    for krate in [
        "capi",
        "chip",
        "control",
        "host-driver",
        "host-driver/cli",
        "host-driver/page",
        "host-driver/record",
        "models",
        "models/cli",
        "models/data",
        "protocol",
        "rig",
        "sim-hil",
        "sim-hil/truth",
    ] {
        let manifest = read(&root.join(krate).join("Cargo.toml")).expect(krate);
        assert!(manifest.contains("autotests = false"), "{krate}: Cargo looks for tests by itself");
        let mut left = forgotten(&root.join(krate).join("tests"));
        // What needs a feature is a binary of its own.
        left.retain(|path| !manifest.contains(&format!("name = {:?}", path.file_stem().unwrap_or_default())));
        assert!(left.is_empty(), "no main.rs names {left:?}");
    }
    for folder in ["diagnosis", "firmware", "fuzz", "host", "project"] {
        let left = forgotten(&root.join("tests/tests").join(folder));
        assert!(left.is_empty(), "no main.rs names {left:?}");
    }
}
