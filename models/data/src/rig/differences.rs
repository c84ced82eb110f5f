//! Where two descriptions of a machine disagree.

use super::Rig;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

impl Rig {
    /// Every key in which two descriptions differ, with what each says:
    /// `supply.pressure_kpa (550.0, 300.0)`.
    #[must_use]
    pub fn differences(&self, other: &Self) -> Vec<String> {
        let (own, others) = (values(self), values(other));
        let paths: BTreeSet<&String> = own.keys().chain(others.keys()).collect();
        let differing = paths.into_iter().filter(|path| own.get(*path) != others.get(*path));
        let said = |value: Option<&Value>| value.map_or_else(|| "nothing".to_owned(), Value::to_string);
        differing
            .map(|path| format!("{path} ({}, {})", said(own.get(path)), said(others.get(path))))
            .collect()
    }
}

/// All that a description holds, by the paths of its keys.
fn values(rig: &Rig) -> BTreeMap<String, Value> {
    fn collect(path: &str, value: Value, into: &mut BTreeMap<String, Value>) {
        match value {
            Value::Object(table) => {
                let below =
                    |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
                table.into_iter().for_each(|(name, value)| collect(&below(&name), value, into));
            }
            value => {
                into.insert(path.to_owned(), value);
            }
        }
    }
    let mut found = BTreeMap::new();
    // Numbers, words and tables of them: what was read can be written.
    collect("", serde_json::to_value(rig).unwrap_or_default(), &mut found);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_named_with_both_values_and_nothing_else_is() {
        let rig = |supply: &str, more: &str| {
            Rig::parse("rig.toml", &format!("[supply]\npressure_kpa = {supply}\n{more}")).unwrap()
        };
        let one = rig("550", "");
        assert_eq!(one.differences(&rig("550.0 # the same", "[bus]\nboards = 2\n")), Vec::<String>::new());
        let other = rig("300", "[boards.1.channels.2.sensor]\nzero_counts = 102.4\nkpa_per_count = 0.5\n");
        let found = one.differences(&other);
        assert_eq!(found.last().unwrap(), "supply.pressure_kpa (550.0, 300.0)");
        assert!(found.iter().any(|path| path.starts_with("boards.1.channels.2.sensor")), "{found:?}");
    }
}
