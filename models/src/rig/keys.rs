//! The known tables and keys, and the nearest one to a misspelt one.

use super::{RigError, limits};

/// Every table with its keys. A test holds this list against the structures.
pub(super) const TABLES: [(&str, &[&str]); 6] = [
    ("supply", &["pressure_kpa"]),
    ("ambient", &["pressure_kpa_abs", "temperature_k"]),
    ("chamber", &["radius_m", "length_m", "offset_m", "volume_m3"]),
    ("valve", &["discharge_coefficient", "critical_ratio"]),
    ("controller", &["rate_hz", "kp", "kd", "saturation", "filter"]),
    ("sensor", &["bits", "zero_counts", "kpa_per_count"]),
];

/// Fails on the first table or key that is not in [`TABLES`].
pub(super) fn refuse_unknown(file: &str, rig: &toml::Table) -> Result<(), RigError> {
    let unknown = |key: String, advice: String| RigError::UnknownKey { file: file.to_owned(), key, advice };
    for (name, value) in rig {
        let Some((table, keys)) = TABLES.iter().find(|(table, _)| table == name) else {
            // A key of some table, written outside it, is the likelier mistake than a misspelt table.
            let home = TABLES.iter().find(|(_, keys)| keys.contains(&name.as_str()));
            let tables: Vec<&str> = TABLES.iter().map(|(table, _)| *table).chain(limits::TABLES).collect();
            let advice = match home {
                Some((table, _)) => format!("it belongs under [{table}]"),
                None => suggestion(name, &tables, "tables"),
            };
            return Err(unknown(name.clone(), advice));
        };
        let Some(content) = value.as_table() else {
            return Err(unknown(
                name.clone(),
                format!("[{table}] is a table with the keys {}", keys.join(", ")),
            ));
        };
        if let Some(key) = content.keys().find(|key| !keys.contains(&key.as_str())) {
            return Err(unknown(format!("{table}.{key}"), suggestion(key, keys, "keys")));
        }
    }
    Ok(())
}

/// "did you mean ...?" when something is near, else what there is.
fn suggestion(name: &str, known: &[&str], what: &str) -> String {
    /// Jaro-Winkler similarity below which a suggestion would only puzzle.
    const NEAR: f64 = 0.75;
    let near = known
        .iter()
        .map(|k| (strsim::jaro_winkler(&name.to_ascii_lowercase(), k), k))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(similarity, _)| *similarity >= NEAR);
    match near {
        Some((_, k)) => format!("did you mean {k}?"),
        None => format!("the known {what} are {}", known.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::{Ambient, Chamber, Controller, Rig, Sensor, Supply, Valve};

    #[test]
    fn the_list_is_what_the_structures_hold() {
        let rig = Rig {
            supply: Some(Supply { pressure_kpa: 550.0 }),
            ambient: Some(Ambient::default()),
            chamber: Some(Chamber {
                radius_m: Some(0.02),
                length_m: Some(0.2),
                offset_m: Some(0.04),
                volume_m3: Some(1e-3),
            }),
            valve: Some(Valve::default()),
            controller: Some(Controller { rate_hz: 1e3, kp: 10.0, kd: 0.0, saturation: 400.0, filter: 0.0 }),
            sensor: Some(Sensor { bits: 10, zero_counts: 102.4, kpa_per_count: 0.84 }),
            highest_set_point_kpa: None,
        };
        let written = toml::Table::try_from(&rig).unwrap();
        assert_eq!(written.len(), TABLES.len());
        for (table, keys) in TABLES {
            let mut found: Vec<&str> =
                written[table].as_table().unwrap().keys().map(String::as_str).collect();
            let mut listed = keys.to_vec();
            found.sort_unstable();
            listed.sort_unstable();
            assert_eq!(found, listed, "[{table}]");
        }
    }
}
