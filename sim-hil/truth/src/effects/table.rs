//! The catalogue as text.

use core::fmt::Write as _;

use super::catalogue;
use super::definition::{Apply, EffectDefinition, EffectGroup};

/// The effects as a Markdown table, one line a parameter: for people, and for the documentation,
/// which a test compares with it.
#[must_use]
pub fn effects_table() -> String {
    let mut out = String::new();
    for (group, title) in [
        (EffectGroup::Structure, "Structure"),
        (EffectGroup::Change, "Change"),
        (EffectGroup::OffCatalogue, "Off the catalogue"),
    ] {
        let _ = writeln!(out, "### {title}\n");
        out.push_str("| effect | per | what happens | parameter | unit | off at | moderate | range |\n");
        out.push_str("| --- | --- | --- | --- | --- | --- | --- | --- |\n");
        for definition in catalogue().filter(|d| d.group == group) {
            write_lines(&mut out, definition);
        }
        out.push('\n');
    }
    out
}

fn write_lines(out: &mut String, definition: &EffectDefinition) {
    for (index, p) in definition.parameters.iter().enumerate() {
        let per = match definition.apply {
            Apply::Channel(_) => "channel",
            Apply::Joint(_) => "board",
            Apply::Supply(_) => "rig",
        };
        let (id, per, meaning) = if index == 0 {
            (format!("`{}`", definition.id), per, definition.meaning)
        } else {
            (String::new(), "", "")
        };
        let null = p.null.map_or(String::new(), |null| null.to_string());
        let _ = writeln!(
            out,
            "| {id} | {per} | {meaning} | `{}`: {} | {} | {null} | {} | {} to {} |",
            p.name, p.meaning, p.unit, p.moderate, p.min, p.max
        );
    }
}
