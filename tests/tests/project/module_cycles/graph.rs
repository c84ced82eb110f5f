//! Who imports whom among the modules of one folder.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::imports::imports;

/// From each module to those that it imports.
pub type Graph = BTreeMap<String, BTreeSet<String>>;

/// A source file.
pub struct Source {
    /// The module that it holds, from the crate's root.
    pub module: Vec<String>,
    text: String,
    /// What it imports, from the crate's root.
    imports: Vec<Vec<String>>,
}

impl Source {
    fn new(module: Vec<String>, text: String) -> Self {
        let imports = imports(&text, &module);
        Self { module, text, imports }
    }
}

/// All source files below a folder, except those that hold the tests of others.
pub fn sources(folder: &Path) -> Vec<Source> {
    let mut found = Vec::new();
    read(folder, &[], &mut found);
    found
}

fn read(folder: &Path, module: &[String], found: &mut Vec<Source>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    for entry in entries {
        let path = entry.expect("a readable folder").path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let inner: Vec<String> = module.iter().cloned().chain([stem.clone()]).collect();
        if path.is_dir() {
            read(&path, &inner, found);
        } else if stem != "tests" && path.extension().is_some_and(|e| e == "rs") {
            let root = matches!(stem.as_str(), "lib" | "main" | "mod");
            let text = std::fs::read_to_string(&path).expect("a readable file");
            found.push(Source::new(if root { module.to_vec() } else { inner }, text));
        }
    }
}

/// The modules directly below `parent` and what they import of each other. What a `mod.rs` passes
/// on (`pub use inner::Name`) counts as an import of the module that it comes from.
pub fn graph(sources: &[Source], parent: &[String]) -> Graph {
    let depth = parent.len();
    let below = |source: &&Source| source.module.len() > depth && source.module.starts_with(parent);
    let modules: BTreeSet<&String> = sources.iter().filter(below).map(|s| &s.module[depth]).collect();
    let passed_on = passed_on(sources, parent);
    let mut graph: Graph = modules.iter().map(|m| ((*m).clone(), BTreeSet::new())).collect();
    for source in sources.iter().filter(below) {
        let from = &source.module[depth];
        for path in &source.imports {
            if path.len() <= depth || !path.starts_with(parent) {
                continue;
            }
            let name = &path[depth];
            // What is passed on from another crate is of no module here.
            let passed = || passed_on.get(name).filter(|module| modules.contains(module));
            let to = if modules.contains(name) { Some(name) } else { passed() };
            if let Some(to) = to.filter(|to| *to != from)
                && let Some(targets) = graph.get_mut(from)
            {
                targets.insert(to.clone());
            }
        }
    }
    graph
}

/// Names that the file of `parent` passes on, with the module of `parent` that each comes from.
fn passed_on(sources: &[Source], parent: &[String]) -> BTreeMap<String, String> {
    let mut names = BTreeMap::new();
    for source in sources.iter().filter(|s| s.module == parent) {
        for line in source.text.split(';') {
            let Some((_, tree)) = line.split_once("pub use ").or(line.split_once("pub(crate) use ")) else {
                continue;
            };
            // As if from the root of a crate: the first part of each path is the module.
            for path in imports(&format!("crate::{};", tree.trim_start_matches("self::")), &[]) {
                if let (Some(module), Some(name)) = (path.first(), path.last()) {
                    names.insert(name.clone(), module.clone());
                }
            }
        }
    }
    names
}

/// The cycles: groups of modules of which each imports every other, directly or through others.
pub fn cycles(graph: &Graph) -> Vec<BTreeSet<String>> {
    let reached: BTreeMap<&String, BTreeSet<&String>> =
        graph.keys().map(|m| (m, reached(graph, m))).collect();
    let mut found: Vec<BTreeSet<String>> = Vec::new();
    for (module, far) in &reached {
        let group: BTreeSet<String> =
            far.iter().filter(|other| reached[*other].contains(module)).map(|m| (*m).clone()).collect();
        if group.len() > 1 && !found.contains(&group) {
            found.push(group);
        }
    }
    found
}

/// Modules that one imports, directly or through others.
fn reached<'a>(graph: &'a Graph, module: &String) -> BTreeSet<&'a String> {
    let mut seen = BTreeSet::new();
    let mut open: Vec<&String> = graph[module].iter().collect();
    while let Some(next) = open.pop() {
        if seen.insert(next) {
            open.extend(&graph[next]);
        }
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(module: &str, text: &str) -> Source {
        let module = module.split("::").filter(|m| !m.is_empty()).map(str::to_owned).collect();
        Source::new(module, text.to_owned())
    }

    #[test]
    fn a_cycle_is_found_through_other_modules_and_through_names_that_are_passed_on() {
        let mut sources = vec![
            source("", "pub use c::Thing;"),
            source("a", "use crate::b::inner;"),
            source("b", ""),
            source("b::inner", "use crate::Thing;"),
            source("c", "use super::d;"),
            source("d", ""),
        ];
        assert_eq!(cycles(&graph(&sources, &[])), Vec::<BTreeSet<String>>::new());
        sources[4] = source("c", "use super::d; use crate::a;");
        let expected: BTreeSet<String> = ["a", "b", "c"].map(str::to_owned).into();
        assert_eq!(cycles(&graph(&sources, &[])), [expected]);
    }

    #[test]
    fn modules_of_a_folder_are_told_from_those_of_the_crate() {
        let sources = [
            source("a", ""),
            source("a::x", "use super::y; use crate::b;"),
            source("a::y", "use super::x;"),
            source("b", ""),
        ];
        assert_eq!(cycles(&graph(&sources, &[])), Vec::<BTreeSet<String>>::new());
        let inner = cycles(&graph(&sources, &["a".to_owned()]));
        assert_eq!(inner, [["x", "y"].map(str::to_owned).into()]);
    }
}
