//! Modules of a crate import each other in one direction only: a cycle means that none of its
//! modules can be understood, tested or moved without all the others.

mod graph;
mod imports;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use graph::{Source, cycles, graph, sources};

/// The cycles that there are, by the crate's folder and the module whose inner modules they join
/// (none for those of the crate). A new one is an error; one that is gone, or has fewer modules, is
/// taken from here or made shorter here.
const KNOWN: &[(&str, &str, &[&str])] = &[
    ("firmware", "", &["bus", "chip"]),
    ("host-driver", "", &["poller", "statistics"]),
    ("host-driver/cli", "", &["args", "connect", "limits", "setup", "view", "web"]),
    ("host-driver/cli", "", &["bench", "bench_table"]),
    ("host-driver/cli", "", &["board", "board_parameters", "board_update"]),
    ("host-driver/page", "", &["api", "download", "picture", "sampler", "server", "stream"]),
    ("host-driver/record", "", &["bag", "recorder"]),
    ("host-driver/record", "", &["rows", "sensor_columns"]),
    ("sim-hil", "", &["bus", "fault"]),
    ("sim-hil/truth", "", &["background", "flow", "parameters", "physics"]),
    ("models/data", "", &["bag", "csv", "error"]),
    ("models", "fit", &["report", "run"]),
    ("models", "report", &["plot", "svg"]),
];

/// Crates of which the modules within modules are looked at, too: there are none in the others' way
/// yet.
const DEEP: &[&str] = &["models", "models/data", "models/plant"];

#[test]
fn modules_import_each_other_in_one_direction_except_in_known_cycles() {
    let mut seen = 0;
    for folder in members() {
        let sources = sources(&root().join(&folder).join("src"));
        seen += sources.len();
        for parent in parents(&folder, &sources) {
            let name = parent.join("::");
            let found: BTreeSet<BTreeSet<String>> = cycles(&graph(&sources, &parent)).into_iter().collect();
            let here = KNOWN.iter().filter(|(at, inside, _)| *at == folder && *inside == name);
            let known: BTreeSet<BTreeSet<String>> =
                here.map(|(_, _, modules)| modules.iter().map(|m| (*m).to_owned()).collect()).collect();
            if let Some(cycle) = found.difference(&known).next() {
                let smaller = known.iter().any(|old| cycle.is_subset(old));
                let what = if smaller {
                    "a known cycle has become smaller: shorten it in KNOWN"
                } else {
                    "a new cycle"
                };
                panic!("{folder}, modules of {name:?}: {what}: {cycle:?}");
            }
            if let Some(cycle) = known.difference(&found).next() {
                panic!("{folder}, modules of {name:?}: this cycle is gone: take it from KNOWN: {cycle:?}");
            }
        }
    }
    assert!(seen > 500, "{seen} files");
}

/// Modules whose inner modules are looked at; the crate itself is the one without a name.
fn parents(folder: &str, sources: &[Source]) -> BTreeSet<Vec<String>> {
    let mut parents = BTreeSet::from([Vec::new()]);
    if DEEP.contains(&folder) {
        parents.extend(sources.iter().filter_map(|s| Some(s.module.split_last()?.1.to_vec())));
    }
    parents
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Folders of the workspace's crates.
fn members() -> Vec<String> {
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let list = manifest.split_once("\nmembers = [").and_then(|(_, rest)| rest.split_once(']')).unwrap().0;
    let name = |name: &str| name.trim().trim_matches('"').to_owned();
    list.split(',').map(name).filter(|name| !name.is_empty()).collect()
}

#[test]
fn every_known_cycle_is_in_a_crate_of_the_workspace() {
    let members = members();
    for (folder, ..) in KNOWN {
        assert!(members.iter().any(|member| member == folder), "{folder} is no crate");
    }
}
