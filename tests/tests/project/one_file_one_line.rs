//! A new effect is one file and one line, and so is a new model: no other source names them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Sources of the toolkit.
fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/src")
}

/// Sources of its program.
fn program() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/cli/src")
}

/// Sources of what it reads.
fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/data/src")
}

/// Sources of what it simulates.
fn plant() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/plant/src")
}

/// All Rust files below a folder with their text, without that of their tests.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("tests.rs") {
            let text = std::fs::read_to_string(&path).expect("a readable file");
            let own = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default().to_owned();
            found.push((path, own));
        }
    }
    found
}

/// What stands between the first `from` and the next `to`.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    text.split_once(from).and_then(|(_, rest)| rest.split_once(to)).expect("the list").0
}

/// Modules of a list of `module::Name` lines.
fn listed(list: &str) -> BTreeSet<String> {
    list.lines()
        .filter_map(|line| Some(line.trim().strip_suffix(',')?.split_once("::")?.0.to_owned()))
        .collect()
}

#[test]
fn an_effect_is_one_file_and_one_line_of_the_catalogue() {
    let folder = plant().join("effects/catalogue");
    let list = std::fs::read_to_string(folder.join("mod.rs")).expect("the catalogue");
    let lines = listed(between(&list, "\ncatalogue! {", "\n}"));
    let effects: Vec<(String, String)> = sources(&folder)
        .into_iter()
        .filter(|(path, text)| !path.ends_with("mod.rs") && text.contains("pub const INFO: EffectInfo"))
        .map(|(path, text)| (path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), text))
        .collect();
    let files: BTreeSet<String> = effects.iter().map(|(stem, _)| stem.clone()).collect();
    assert!(files.len() > 25, "{files:?}");
    assert_eq!(lines, files);
    for (stem, text) in &effects {
        assert!(text.contains(&format!("id: \"{stem}\"")), "{stem}.rs has another id");
    }
    // Nothing else of the toolkit asks for one of them by its id: what makes it different are its
    // traits.
    let mut named = Vec::new();
    let all = [models(), program(), data(), plant()].into_iter().flat_map(|folder| sources(&folder));
    for (path, text) in all.filter(|(path, _)| !path.starts_with(&folder)) {
        named.extend(
            files.iter().filter(|id| text.contains(&format!("\"{id}\""))).map(|id| (path.clone(), id)),
        );
    }
    assert!(named.is_empty(), "{named:?}");
}

#[test]
fn a_model_is_one_file_and_one_line_of_the_list() {
    let folder = plant().join("model");
    let list = std::fs::read_to_string(folder.join("mod.rs")).expect("the models");
    let lines = listed(between(&list, "\nmodels! { $", "\n}"));
    let files: BTreeSet<String> = sources(&folder)
        .into_iter()
        .filter(|(path, text)| !path.ends_with("mod.rs") && text.contains("impl Listed for "))
        .map(|(path, _)| path.file_stem().unwrap_or_default().to_string_lossy().into_owned())
        .collect();
    assert_eq!(lines, files);
    // The last of them is in no list beside that: simulation, choice, command line and page take it
    // from there.
    let last = "Parametric";
    let mut places = vec![plant().join("rollout"), data()];
    places.extend([models().join("experiment"), program(), models().join("store")]);
    for (path, text) in places.iter().flat_map(|place| sources(place)) {
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let named: Vec<&str> = code.filter(|line| line.contains(last)).collect();
        assert!(named.is_empty(), "{}: {named:?}", path.display());
    }
}
