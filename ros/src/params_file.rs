//! Parameters in YAML: the files of `--params-file`, as launch files write them, and values of
//! `-p name:=value`.

use saphyr::{LoadableYamlNode, Scalar, Yaml};
use std::path::Path;

/// A parameter file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("--params-file {file}: {reason}")]
pub struct ParamsFileError {
    file: String,
    reason: String,
}

/// Reads the parameters of the node `full_name` (as in `/arm/pneudrive`): names and values in the
/// order of the file.
///
/// Below the node's name, in one key (`/arm/pneudrive`) or one key a part (`arm`, `pneudrive`),
/// stands `ros__parameters`. The wildcards `*` (any one part) and `**` (any number of parts) hold.
/// Values are as [`text`] writes them.
///
/// # Errors
/// When the file cannot be read, is no YAML, or has no `ros__parameters` at all.
pub fn read(file: &Path, full_name: &str) -> Result<Vec<(String, String)>, ParamsFileError> {
    let fail = |reason: String| ParamsFileError { file: file.display().to_string(), reason };
    let content = std::fs::read_to_string(file).map_err(|error| fail(error.to_string()))?;
    parse(&content, full_name).map_err(fail)
}

fn parse(content: &str, full_name: &str) -> Result<Vec<(String, String)>, String> {
    let documents = Yaml::load_from_str(content).map_err(|error| error.to_string())?;
    let mut found = Found { wanted: parts(full_name), parameters: Vec::new(), nodes: 0 };
    for document in &documents {
        found.search(document, &mut Vec::new())?;
    }
    if found.nodes == 0 {
        return Err("no `ros__parameters` in it; expected NODE: {ros__parameters: {NAME: VALUE, ..}}, as \
                    `ros2 param dump` writes it"
            .to_owned());
    }
    Ok(found.parameters)
}

struct Found<'a> {
    wanted: Vec<&'a str>,
    parameters: Vec<(String, String)>,
    /// How many tables of parameters there were, of whatever node.
    nodes: usize,
}

impl Found<'_> {
    fn search(&mut self, yaml: &Yaml<'_>, above: &mut Vec<String>) -> Result<(), String> {
        let Yaml::Mapping(mapping) = yaml else { return Ok(()) };
        for (key, value) in mapping {
            let key = text(key).unwrap_or_default();
            if key == "ros__parameters" {
                self.nodes += 1;
                let pattern: Vec<_> = above.iter().map(String::as_str).collect();
                if matches(&pattern, &self.wanted) {
                    self.take(value, "")?;
                }
                continue;
            }
            let before = above.len();
            above.extend(parts(&key).into_iter().map(str::to_owned));
            self.search(value, above)?;
            above.truncate(before);
        }
        Ok(())
    }

    /// Parameters in tables have names with dots.
    fn take(&mut self, table: &Yaml<'_>, prefix: &str) -> Result<(), String> {
        let Yaml::Mapping(mapping) = table else { return Ok(()) };
        for (key, value) in mapping {
            let name = format!("{prefix}{}", text(key).unwrap_or_default());
            match value {
                Yaml::Mapping(_) => self.take(value, &format!("{name}."))?,
                _ => {
                    let value = text(value).ok_or(format!("{name}: expected a value or a list of values"))?;
                    self.parameters.push((name, value));
                }
            }
        }
        Ok(())
    }
}

/// A value of a flag for a value in YAML: lists are separated by commas, and nothing at all (`~`)
/// is an empty text. `None` for tables.
fn text(yaml: &Yaml<'_>) -> Option<String> {
    match yaml {
        Yaml::Value(Scalar::Null) => Some(String::new()),
        Yaml::Value(Scalar::Boolean(value)) => Some(value.to_string()),
        Yaml::Value(Scalar::Integer(value)) => Some(value.to_string()),
        Yaml::Value(Scalar::FloatingPoint(value)) => Some(value.to_string()),
        Yaml::Value(Scalar::String(value)) => Some(value.to_string()),
        Yaml::Sequence(items) => items.iter().map(text).collect::<Option<Vec<_>>>().map(|all| all.join(",")),
        _ => None,
    }
}

/// What `-p name:=value` says in YAML, as a flag's value. What is no YAML stands for itself.
pub fn value(yaml: &str) -> String {
    let documents = Yaml::load_from_str(yaml).unwrap_or_default();
    documents.first().and_then(text).unwrap_or_else(|| yaml.trim().to_owned())
}

fn parts(name: &str) -> Vec<&str> {
    name.split('/').filter(|part| !part.is_empty()).collect()
}

fn matches(pattern: &[&str], name: &[&str]) -> bool {
    match (pattern.split_first(), name.split_first()) {
        (None, None) => true,
        (Some((&"**", rest)), _) => (0..=name.len()).any(|skipped| matches(rest, &name[skipped..])),
        (Some((part, rest)), Some((first, others))) => {
            (*part == "*" || part == first) && matches(rest, others)
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_of(key: &str, node: &str) -> usize {
        parse(&format!("{key}:\n  ros__parameters:\n    rate_hz: 500.0\n"), node).unwrap().len()
    }

    #[test]
    fn values_become_those_of_flags() {
        let yaml = "/**:\n  ros__parameters:\n    port: [/dev/a, '/dev/b']\n    devices: [4, 2]\n    rate_hz: 500.0\n    \
                    resume: true\n    rig: ''\n    max_kpa: .inf\n    baud: 1000000\n    record: ~\n    \
                    qos_overrides: {/parameter_events: {publisher: {depth: 1000}}}\n";
        let expected = [
            ("port", "/dev/a,/dev/b"),
            ("devices", "4,2"),
            ("rate_hz", "500"),
            ("resume", "true"),
            ("rig", ""),
            ("max_kpa", "inf"),
            ("baud", "1000000"),
            ("record", ""),
            ("qos_overrides./parameter_events.publisher.depth", "1000"),
        ];
        let expected = expected.map(|(name, value)| (name.to_owned(), value.to_owned()));
        assert_eq!(parse(yaml, "/arm/pneudrive").unwrap(), expected);
    }

    #[test]
    fn a_node_takes_what_is_its_own() {
        for key in ["/arm/air", "/**", "/*/air", "/arm/**", "/**/air", "arm/air", "'*/*'"] {
            assert_eq!(names_of(key, "/arm/air"), 1, "{key}");
        }
        for key in ["/air", "air", "/arm", "/arm/other", "/*", "/*/*/air", "/arm/air/x"] {
            assert_eq!(names_of(key, "/arm/air"), 0, "{key}");
        }
        let nested =
            "arm:\n  air:\n    ros__parameters: {rate_hz: 1}\n  other:\n    ros__parameters: {rate_hz: 2}\n";
        assert_eq!(parse(nested, "/arm/air").unwrap(), [("rate_hz".to_owned(), "1".to_owned())]);
    }

    #[test]
    fn what_is_no_parameter_file_is_told() {
        let refused = |yaml: &str| parse(yaml, "/x").unwrap_err();
        assert!(refused("rate_hz: 500").contains("ros2 param dump"));
        assert!(refused("a: [1").contains("line"));
        assert!(refused("/**:\n  ros__parameters:\n    a: [{b: 1}]").starts_with("a: expected a value"));
        let error = read(Path::new("/nowhere.yaml"), "/x").unwrap_err().to_string();
        assert!(error.starts_with("--params-file /nowhere.yaml: "), "{error}");
    }

    #[test]
    fn values_on_the_command_line_are_yaml() {
        for (yaml, text) in [("['/dev/a','/dev/b']", "/dev/a,/dev/b"), ("500.0", "500"), ("never", "never")] {
            assert_eq!(value(yaml), text);
        }
    }
}
