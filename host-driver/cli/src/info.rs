//! `info`: what a recording says of itself.

use crate::args::InfoArgs;
use crate::failure::Failure;
use crate::output::{outln, print_json};
use pneudrive_record::Contents;
use serde::Serialize;

#[derive(Serialize)]
struct InfoReport<'a> {
    file: String,
    #[serde(flatten)]
    contents: &'a Contents,
}

/// Prints what is in a recording beside its rows.
pub fn run(info: &InfoArgs, json: bool) -> Result<(), Failure> {
    let file = info.file.display().to_string();
    let contents = Contents::read(&info.file).map_err(|error| Failure::input(format!("{file}: {error}")))?;
    if json {
        return print_json(&InfoReport { file, contents: &contents });
    }
    outln!("{file}");
    for (key, value) in &contents.description {
        match value {
            // A copy of a file: as it was.
            serde_json::Value::String(text) if text.contains('\n') => {
                outln!("  {key}:");
                text.lines().for_each(|line| outln!("    {line}"));
            }
            serde_json::Value::String(text) => outln!("  {key}: {text}"),
            value => outln!("  {key}: {value}"),
        }
    }
    match (contents.first_s, contents.last_s) {
        (Some(first), Some(last)) => outln!("  {} rows, {first:.3} s to {last:.3} s", contents.rows),
        _ => outln!("  no rows"),
    }
    for event in &contents.events {
        outln!("  {:>10.3} s  {:<14} {}", event.t_s, event.kind, event.text);
    }
    if contents.end().is_none() {
        outln!(
            "  no end: the program was killed or is still recording, or it is not a recording of pneudrive-host"
        );
    }
    Ok(())
}
