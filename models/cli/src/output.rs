//! Results as files: whole or not at all.

use std::path::Path;

use pneudrive_model::data::write;
use serde::Serialize;

use super::Failure;

/// What a diagnosis writes for programs, and the page for readers.
pub const REPORT: &str = "report.json";
pub const PAGE: &str = "report.html";

/// Writes `value` as indented JSON. Values that JSON cannot hold (infinities, not-a-number) become
/// null.
pub fn json(path: &Path, value: &impl Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(value).map_err(Failure::running)?;
    text.push('\n');
    Ok(write::text_atomically(path, &text)?)
}

/// What is said of a page that was written to `path`, in place of an earlier one (`replaced`) or
/// not.
pub fn wrote_page(path: &Path, replaced: bool) -> String {
    let earlier = if replaced { ", in place of the earlier result in that folder" } else { "" };
    format!("wrote {}{earlier}; a browser shows it", path.display())
}

/// Makes the folder for the results.
pub fn folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path)
        .map_err(|e| Failure::running(format!("{}: the folder cannot be made: {e}", path.display())))
}
