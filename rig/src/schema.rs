//! The format as a JSON schema, which editors use to complete and to check rig files.

use crate::format::{FILE, Key, Kind, Table};
use serde_json::{Map, Value, json};

/// The JSON schema (draft 2020-12) of the rig file.
///
/// It accepts what [`Rig::parse`](crate::Rig::parse) accepts, except that control characters in
/// names are the reader's business.
#[must_use]
pub fn schema() -> Value {
    let mut schema = table(&FILE);
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("PneuDrive rig file");
    schema
}

fn table(table: &Table) -> Value {
    let mut properties = Map::new();
    for one in table.keys {
        properties.insert(one.name.to_owned(), key(one));
    }
    for inner in table.tables {
        properties.insert(inner.name.to_owned(), self::table(inner));
    }
    let mut schema = json!({
        "type": "object",
        "description": table.meaning,
        "additionalProperties": false,
        "properties": properties,
    });
    if let Some(numbered) = table.numbered {
        schema["patternProperties"] = json!({ (pattern(numbered.highest)): self::table(numbered.table) });
    }
    let required: Vec<_> = table.keys.iter().filter(|key| key.required).map(|key| key.name).collect();
    if !required.is_empty() {
        schema["required"] = json!(required);
    }
    if table.name == "chamber" {
        schema["oneOf"] = json!([
            { "required": ["radius_m", "length_m"], "not": { "required": ["volume_m3"] } },
            {
                "required": ["volume_m3"],
                "properties": { "radius_m": false, "length_m": false, "offset_m": false },
            },
        ]);
    }
    schema
}

/// A pattern for whole numbers from 0 to `highest`, without leading zeros.
fn pattern(highest: u8) -> String {
    let numbers: Vec<_> = (0..=highest).map(|number| number.to_string()).collect();
    format!("^({})$", numbers.join("|"))
}

fn key(key: &Key) -> Value {
    let mut schema = match key.kind {
        Kind::Number { above, low, high, .. } => {
            let low_end = if above { "exclusiveMinimum" } else { "minimum" };
            json!({ "type": "number", (low_end): low, "maximum": high })
        }
        Kind::Whole { low, high, .. } => json!({ "type": "integer", "minimum": low, "maximum": high }),
        Kind::WholeOr { word, low, high, .. } => {
            json!({ "anyOf": [{ "type": "integer", "minimum": low, "maximum": high }, { "const": word }] })
        }
        Kind::Text { most, .. } => {
            json!({ "type": "string", "minLength": 1, "maxLength": most, "pattern": "[^ \\t]" })
        }
        Kind::Word(words) => json!({ "enum": words }),
    };
    let unit = match key.kind {
        Kind::Number { unit, .. } | Kind::Whole { unit, .. } | Kind::WholeOr { unit, .. }
            if !unit.is_empty() =>
        {
            format!(", {unit}")
        }
        _ => String::new(),
    };
    schema["description"] = json!(format!("{}{unit}", key.meaning));
    schema
}
