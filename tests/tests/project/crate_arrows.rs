//! Which crate may depend on which: the architecture, held by a test.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// From each crate to those of ours that it may depend on. What is not here may not be.
///
/// Two arrows are missing on purpose. Host and simulator meet only through bytes, so that they
/// cannot share a bug above the packet: what takes `sim` for a port (the program `pneudrive-host`,
/// the Python package, the ROS node) has virtual boards started by a crate which gives it their
/// port's path, and to which the simulator is an optional dependency. And the simulator's plant
/// does not use the models, or every fit would be tested against itself.
const ALLOWED: &[(&str, &[&str])] = &[
    ("pneudrive-protocol", &[]),
    ("pneudrive-control", &["pneudrive-protocol"]),
    ("pneudrive-firmware", &["pneudrive-control", "pneudrive-protocol"]),
    ("pneudrive-rig", &[]),
    ("pneudrive-manual", &[]),
    ("pneudrive-host", &["pneudrive-protocol", "pneudrive-rig", "pneudrive-check"]),
    (
        "pneudrive-host-cli",
        &[
            "pneudrive-host",
            "pneudrive-manual",
            "pneudrive-page",
            "pneudrive-protocol",
            "pneudrive-record",
            "pneudrive-rig",
            "pneudrive-virtual",
        ],
    ),
    ("pneudrive-record", &["pneudrive-host", "pneudrive-protocol"]),
    ("pneudrive-check", &[]),
    ("pneudrive-uf2", &[]),
    ("pneudrive-page", &["pneudrive-protocol"]),
    ("pneudrive-virtual", &["pneudrive-protocol", "pneudrive-sim"]),
    (
        "pneudrive-sim",
        &["pneudrive-control", "pneudrive-protocol", "pneudrive-chip", "pneudrive-manual", "pneudrive-truth"],
    ),
    ("pneudrive-truth", &[]),
    ("pneudrive-chip", &[]),
    ("pneudrive-plant", &[]),
    ("pneudrive-data", &["pneudrive-plant", "pneudrive-rig"]),
    ("pneudrive-model", &["pneudrive-data", "pneudrive-plant"]),
    ("pneudrive-model-cli", &["pneudrive-model", "pneudrive-manual"]),
    ("pneudrive-capi", &["pneudrive-model"]),
    (
        "pneudrive_py",
        &[
            "pneudrive-capi",
            "pneudrive-host",
            "pneudrive-host-cli",
            "pneudrive-model",
            "pneudrive-model-cli",
            "pneudrive-protocol",
            "pneudrive-record",
            "pneudrive-sim",
            "pneudrive-virtual",
        ],
    ),
    ("pneudrive-ros", &["pneudrive-host", "pneudrive-protocol", "pneudrive-record", "pneudrive-virtual"]),
    (
        "system-tests",
        &[
            "pneudrive-protocol",
            "pneudrive-control",
            "pneudrive-host",
            "pneudrive-record",
            "pneudrive-sim",
            "pneudrive-chip",
            "pneudrive-model",
        ],
    ),
];

fn metadata() -> Value {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version=1", "--no-deps", "--offline", "--manifest-path", manifest])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// (crate, dependency, whether it is optional) among the workspace's own crates, dev-dependencies
/// left out: tests may look anywhere.
fn arrows(metadata: &Value) -> Vec<(String, String, bool)> {
    let packages = metadata["packages"].as_array().unwrap();
    let name = |value: &Value| value["name"].as_str().unwrap().to_owned();
    let ours: BTreeSet<_> = packages.iter().map(name).collect();
    let mut arrows = Vec::new();
    for package in packages {
        for dependency in package["dependencies"].as_array().unwrap() {
            if dependency["kind"] != "dev" && ours.contains(&name(dependency)) {
                arrows.push((name(package), name(dependency), dependency["optional"] == true));
            }
        }
    }
    arrows
}

#[test]
fn crates_depend_only_on_what_the_architecture_allows() {
    let allowed: BTreeMap<_, _> = ALLOWED.iter().copied().collect();
    let metadata = metadata();
    for package in metadata["packages"].as_array().unwrap() {
        let name = package["name"].as_str().unwrap();
        assert!(allowed.contains_key(name), "{name} is new: add it and its arrows here and to the README");
    }
    let arrows = arrows(&metadata);
    assert!(arrows.len() > 5, "metadata was understood: {arrows:?}");
    for (from, to, _) in &arrows {
        assert!(allowed[from.as_str()].contains(&to.as_str()), "{from} must not depend on {to}");
    }
}

#[test]
fn the_simulator_can_be_left_out() {
    let metadata = metadata();
    for user in ["pneudrive-virtual", "pneudrive_py"] {
        let arrow = arrows(&metadata).into_iter().find(|(from, to, _)| from == user && to == "pneudrive-sim");
        let optional = arrow.map(|(_, _, optional)| optional);
        assert_eq!(optional, Some(true), "{user}: feature `sim` can be switched off");
    }
}
