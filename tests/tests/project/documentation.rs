//! What people read hangs together: the book has every chapter, and links lead somewhere.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn pages(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("the folder is there").filter_map(Result::ok);
    entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect()
}

/// Targets of `[text](target)` outside of code, without those on the web.
fn links(text: &str) -> Vec<String> {
    let mut in_code = false;
    let prose = text.lines().filter(|line| {
        let fence = line.trim_start().starts_with("```");
        in_code ^= fence;
        !in_code && !fence
    });
    prose
        .flat_map(|line| line.split("](").skip(1).filter_map(|rest| rest.split_once(')')))
        .map(|(target, _)| target.to_owned())
        .filter(|target| !target.contains("://") && !target.starts_with("mailto:"))
        .collect()
}

/// The anchors that a page's headings have: lower case, words joined by hyphens, other marks gone.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    headings
        .map(|line| {
            let words = line.trim_start_matches('#').trim().to_lowercase();
            let kept = words.chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
            kept.map(|c| if c == ' ' { '-' } else { c }).collect()
        })
        .collect()
}

#[test]
fn every_page_is_a_chapter_of_the_book() {
    let docs = root().join("docs");
    let summary = std::fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let chapters: Vec<String> = links(&summary);
    let unique: BTreeSet<&String> = chapters.iter().collect();
    assert_eq!(unique.len(), chapters.len(), "a chapter is there twice: {chapters:?}");
    for page in pages(&docs) {
        let name = page.file_name().unwrap().to_str().unwrap();
        assert!(
            name == "SUMMARY.md" || chapters.iter().any(|chapter| chapter == name),
            "docs/{name} is no chapter of docs/SUMMARY.md"
        );
    }
}

/// Folders with a README of their own.
const READMES: [&str; 8] =
    ["capi", "chip", "dist", "models", "models/data", "models/plant", "protocol", "python"];

#[test]
fn links_lead_to_files_and_headings() {
    let root = root();
    let mut all = pages(&root);
    all.extend(pages(&root.join("docs")));
    all.extend(READMES.iter().map(|crate_folder| root.join(crate_folder).join("README.md")));
    all.push(root.join("tests/defects.md"));
    let mut checked = 0;
    let mut broken = Vec::new();
    for page in all {
        let text = std::fs::read_to_string(&page).unwrap();
        for link in links(&text) {
            let (file, anchor) = link.split_once('#').map_or((link.as_str(), None), |(f, a)| (f, Some(a)));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            checked += 1;
            let there = match anchor {
                None => target.exists(),
                Some(_) if target.extension().is_none_or(|e| e != "md") => target.exists(),
                Some(anchor) => std::fs::read_to_string(&target).is_ok_and(|t| anchors(&t).contains(anchor)),
            };
            if !there {
                broken.push(format!("{}: {link}", page.strip_prefix(&root).unwrap_or(&page).display()));
            }
        }
    }
    assert!(checked > 80, "only {checked} links were found");
    assert!(broken.is_empty(), "links that lead nowhere:\n{}", broken.join("\n"));
}

/// The book has nothing but `docs/`: a link out of it would be dead there.
#[test]
fn chapters_link_to_nothing_outside_of_the_book() {
    for page in pages(&root().join("docs")) {
        let text = std::fs::read_to_string(&page).unwrap();
        let outside: Vec<String> = links(&text).into_iter().filter(|link| link.starts_with("..")).collect();
        assert!(outside.is_empty(), "{}: {outside:?}", page.display());
    }
}

/// What a reader copies compiles and runs: `host-driver/tests/examples.rs` runs that file. README
/// shows whole lines of it, as they follow each other in the function `run`.
#[test]
fn the_readme_shows_a_tested_example() {
    let read = |file| std::fs::read_to_string(root().join(file)).unwrap();
    let readme = read("README.md");
    let blocks: Vec<&str> =
        readme.split("```rust\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert_eq!(blocks.len(), 1, "README.md shows one Rust example");
    let example = read("host-driver/examples/set_points.rs");
    let body: String = example
        .lines()
        .skip_while(|line| !line.starts_with("pub fn run("))
        .filter_map(|line| line.strip_prefix("    "))
        .flat_map(|line| [line, "\n"])
        .collect();
    assert!(
        blocks[0].lines().count() > 5 && format!("\n{body}").contains(&format!("\n{}", blocks[0])),
        "README.md shows what is not in host-driver/examples/set_points.rs:\n{}",
        blocks[0]
    );
}
