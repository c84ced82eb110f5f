//! `completions` and `man`.

use crate::common::Folder;
use crate::common::cli::run;

#[test]
fn completions_and_man_pages_come_from_the_definition() {
    let folder = Folder::new();
    let completions = run(folder.root(), &["completions", "bash"]);
    assert_eq!(completions.status, 0, "{}", completions.stderr);
    assert!(completions.stdout.contains("_pneudrive__model()") && completions.stdout.contains("--loads"));
    assert_eq!(run(folder.root(), &["man", "."]).status, 0);
    let page = std::fs::read_to_string(folder.path("pneudrive-model-diagnose.1")).unwrap();
    assert!(page.contains("\\-\\-loads"), "{page}");
    let refused = run(folder.root(), &["man", "/no/such/folder"]);
    assert!(refused.status == 2 && refused.stderr.contains("/no/such/folder"), "{}", refused.stderr);
}
