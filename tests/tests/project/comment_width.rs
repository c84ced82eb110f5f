//! Comments end at 100 columns: beside them there is room for a second file.
//!
//! Tables and examples in documentation are as wide as they have to be; rustfmt sees to the code.

use std::path::{Path, PathBuf};

const WIDTH: usize = 100;

/// How a file's comments begin, by what its name ends in; scripts have no such end.
fn marks(path: &Path) -> &'static [&'static str] {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("rs" | "js") => &["//"],
        Some("py" | "pyi" | "toml" | "sh" | "yml") => &["#"],
        Some("c" | "h" | "cpp" | "css") => &["//", "/*", "* "],
        Some("x") => &["/*"],
        None => &["#"],
        Some(_) => &[],
    }
}

/// Does a comment follow code in this line of Rust? What looks like one within a string does not.
fn behind_code(path: &Path, line: &str) -> bool {
    let rust = path.extension().is_some_and(|extension| extension == "rs");
    let code = line.find(" // ").map(|at| &line[..at]).filter(|code| !code.trim().is_empty());
    rust && code
        .is_some_and(|code| !code.trim_start().starts_with("//") && code.matches('"').count() % 2 == 0)
}

/// Numbers of the lines of a text whose comments are wider.
fn too_wide(path: &Path, text: &str) -> Vec<usize> {
    let (marks, mut example) = (marks(path), false);
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let begins = line.trim_start();
        if behind_code(path, line) && line.chars().count() > WIDTH {
            found.push(number + 1);
            continue;
        }
        if !marks.iter().any(|mark| begins.starts_with(mark)) {
            example = false;
            continue;
        }
        let says = begins.trim_start_matches(['/', '!', '#', '*', ' ']);
        example ^= says.starts_with("```");
        let exempt = example || says.starts_with("```") || says.starts_with('|');
        if line.chars().count() > WIDTH && !exempt {
            found.push(number + 1);
        }
    }
    found
}

/// Files below a folder, without what was not written by hand.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a readable folder").filter_map(Result::ok) {
        let (path, name) = (entry.path(), entry.file_name());
        let name = name.to_string_lossy();
        if path.is_dir() {
            let ours = !["target", ".git", "build", "book"].contains(&&*name);
            if ours && !name.contains("venv") && !name.starts_with("__") {
                files(&path, found);
            }
        } else if !name.starts_with("LICENSE") {
            found.push(path);
        }
    }
}

#[test]
fn comments_end_at_100_columns() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let mut all = Vec::new();
    files(root, &mut all);
    assert!(all.iter().any(|path| path.ends_with("tests/project/main.rs")), "nothing was read");
    let mut wide = Vec::new();
    for path in all.iter().filter(|path| !marks(path).is_empty()) {
        // What is not text has no comments.
        let Ok(text) = std::fs::read_to_string(path) else { continue };
        let place = |line| format!("{}:{line}", path.strip_prefix(root).unwrap_or(path).display());
        wide.extend(too_wide(path, &text).into_iter().map(place));
    }
    assert!(wide.is_empty(), "wider than {WIDTH} columns: {wide:#?}");
}

#[test]
fn a_wide_comment_is_found_and_a_table_or_an_example_is_not() {
    let wide = "word ".repeat(25);
    let of = |name: &str, text: String| too_wide(Path::new(name), &text);
    assert_eq!(of("a.rs", format!("fn f() {{}}\n    // {wide}\n")), [2]);
    assert_eq!(of("a.rs", format!("//! | {wide}|\n//! ```\n//! {wide}\n//! ```\n//! {wide}")), [5]);
    assert_eq!(of("a.py", format!("x = '{wide}'\n# {wide}")), [2]);
    assert_eq!(of("a.rs", format!("let a = \"x // {wide}\";\nlet b = 1; // {wide}\n")), [2]);
    assert_eq!(of("memory.x", format!("/* {wide} */")), [1]);
    assert_eq!(of("a.c", format!("/* short\n * {wide} */")), [2]);
    assert_eq!(of("run", format!("echo {wide}\n# {wide}")), [2]);
    assert!(of("a.rs", format!("/// {}", "ä".repeat(96))).is_empty(), "bytes are not columns");
}
