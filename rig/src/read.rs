//! From text to values, each checked against the format.

use crate::RigError;
use crate::format::{FILE, Kind, Numbered, Table};
use std::collections::BTreeMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What stands in a file, by the path of its key or table, as in `boards.0.limits.max_kpa`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Content {
    pub values: BTreeMap<String, Value>,
    /// The line of every table and key.
    pub lines: BTreeMap<String, usize>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Text(String),
}

/// Reads and checks `text`, or what stands in one table of it; `file` is its name in messages.
pub(crate) fn read(file: &str, text: &str, inside: Option<&str>) -> Result<Content, RigError> {
    let reader = Reader { file, text };
    let root = DeTable::parse(text).map_err(|error| match is_table(text) {
        true => RigError::Recording { file: file.to_owned() },
        false => RigError::Syntax {
            file: file.to_owned(),
            line: error.span().map_or(1, |span| reader.line(span.start)),
            // TOML's messages may have several lines.
            problem: error.message().split('\n').collect::<Vec<_>>().join(", "),
        },
    })?;
    let mut content = Content::default();
    let root = match inside {
        None => root.get_ref(),
        Some(name) => match root.get_ref().get(name).map(Spanned::get_ref) {
            Some(DeValue::Table(table)) => table,
            _ => {
                return Err(RigError::Table {
                    file: file.to_owned(),
                    line: 1,
                    table: name.to_owned(),
                    problem: "is missing".to_owned(),
                });
            }
        },
    };
    reader.table(&FILE, "", root, &mut content)?;
    Ok(content)
}

/// Whether text that is no TOML is CSV: its first line, below comments, is a header.
fn is_table(text: &str) -> bool {
    let header = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    header.is_some_and(|header| header.contains(',') && !header.contains(['=', '[']))
}

struct Reader<'a> {
    file: &'a str,
    text: &'a str,
}

impl Reader<'_> {
    /// The line, counted from 1, of the byte at `at`.
    fn line(&self, at: usize) -> usize {
        1 + self.text.bytes().take(at).filter(|&byte| byte == b'\n').count()
    }

    fn table(
        &self,
        table: &Table,
        path: &str,
        found: &DeTable<'_>,
        content: &mut Content,
    ) -> Result<(), RigError> {
        for (name, value) in found {
            let line = self.line(name.span().start);
            let name = name.get_ref().as_ref();
            let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
            content.lines.insert(path.clone(), line);
            if let Some(key) = table.keys.iter().find(|key| key.name == name) {
                let read = self.value(&key.kind, &path, value)?;
                content.values.insert(path, read);
                continue;
            }
            let inner = match table.numbered {
                Some(numbered) => self.number(numbered, &path, name, line)?,
                None => *table
                    .tables
                    .iter()
                    .find(|table| table.name == name)
                    .ok_or_else(|| self.unknown(table, &path, name, value.get_ref(), line))?,
            };
            let DeValue::Table(inside) = value.get_ref() else {
                let expected = format!("a table, [{path}]: {}", inner.meaning);
                return Err(self.wrong(&path, value, expected));
            };
            self.table(inner, &path, inside, content)?;
        }
        let missing = table.keys.iter().filter(|key| key.required && !found.contains_key(key.name));
        let missing: Vec<_> = missing.map(|key| format!("{} ({})", key.name, key.kind.expected())).collect();
        if !missing.is_empty() {
            return Err(self.problem(content, path, format!("needs {}", missing.join(" and "))));
        }
        match table.name {
            "chamber" => self.chamber(found, path, content),
            _ => Ok(()),
        }
    }

    fn number<'n>(
        &self,
        numbered: &'n Numbered,
        path: &str,
        name: &str,
        line: usize,
    ) -> Result<&'n Table, RigError> {
        // 00 is 0 to a parser, and another key to TOML.
        let plain = name.parse::<u8>().ok().filter(|number| number.to_string() == name);
        match plain {
            Some(number) if number <= numbered.highest => Ok(numbered.table),
            _ => Err(RigError::Unknown {
                file: self.file.to_owned(),
                line,
                what: numbered.what,
                path: path.to_owned(),
                advice: format!("expected a number from 0 to {}", numbered.highest),
            }),
        }
    }

    fn value(&self, kind: &Kind, path: &str, value: &Spanned<DeValue<'_>>) -> Result<Value, RigError> {
        let wrong = || self.wrong(path, value, kind.expected());
        match (*kind, value.get_ref()) {
            (Kind::Number { above, low, high, .. }, found) => {
                let number = number_of(found).ok_or_else(wrong)?;
                // Written so that NaN is refused.
                let inside = number <= high && if above { number > low } else { number >= low };
                if inside { Ok(Value::Number(number)) } else { Err(wrong()) }
            }
            (Kind::Whole { low, high, .. } | Kind::WholeOr { low, high, .. }, DeValue::Integer(_)) => {
                let number = number_of(value.get_ref()).ok_or_else(wrong)?;
                let inside = number >= low as f64 && number <= high as f64;
                if inside { Ok(Value::Number(number)) } else { Err(wrong()) }
            }
            (Kind::WholeOr { word, .. }, DeValue::String(text)) if text.as_ref() == word => {
                Ok(Value::Text(text.clone().into_owned()))
            }
            (Kind::Text { most, .. }, DeValue::String(text)) => {
                let fits = (1..=most).contains(&text.chars().count());
                let plain = !text.trim().is_empty() && !text.chars().any(char::is_control);
                if fits && plain { Ok(Value::Text(text.clone().into_owned())) } else { Err(wrong()) }
            }
            (Kind::Word(words), DeValue::String(text)) if words.contains(&text.as_ref()) => {
                Ok(Value::Text(text.clone().into_owned()))
            }
            _ => Err(wrong()),
        }
    }

    fn wrong(&self, path: &str, value: &Spanned<DeValue<'_>>, expected: String) -> RigError {
        const SHOWN: usize = 40;
        let span = value.span();
        let written = self.text.get(span.clone()).unwrap_or_default();
        let shown: String = written.chars().take(SHOWN).filter(|c| !c.is_control()).collect();
        let value = if written.chars().count() > SHOWN { format!("{shown}..") } else { shown };
        let (file, line) = (self.file.to_owned(), self.line(span.start));
        RigError::Value { file, line, path: path.to_owned(), value, expected }
    }

    fn unknown(&self, table: &Table, path: &str, name: &str, value: &DeValue<'_>, line: usize) -> RigError {
        let is_table = matches!(value, DeValue::Table(_));
        let keys = table.keys.iter().map(|key| key.name);
        let known: Vec<&str> = keys.chain(table.tables.iter().map(|table| table.name)).collect();
        // A key written outside its table is the likelier mistake than a misspelt table.
        let home = FILE.tables.iter().find(|other| other.keys.iter().any(|key| key.name == name));
        let advice = match home {
            Some(home) if !is_table => format!("it belongs under [{}]", home.name),
            _ => nearest(name, &known),
        };
        RigError::Unknown {
            file: self.file.to_owned(),
            line,
            what: if is_table { "table" } else { "key" },
            path: path.to_owned(),
            advice,
        }
    }

    fn problem(&self, content: &Content, table: &str, problem: String) -> RigError {
        let line = content.lines.get(table).copied().unwrap_or(1);
        RigError::Table { file: self.file.to_owned(), line, table: table.to_owned(), problem }
    }

    /// A cylinder or a constant volume, and not both.
    fn chamber(&self, found: &DeTable<'_>, path: &str, content: &Content) -> Result<(), RigError> {
        let has = |key: &str| found.contains_key(key);
        let cylinder = ["radius_m", "length_m", "offset_m"].map(has);
        let problem = match (has("volume_m3"), cylinder) {
            (true, [false, false, false]) | (false, [true, true, _]) => return Ok(()),
            (true, _) => {
                "has volume_m3 and a cylinder's radius_m, length_m or offset_m; keep one description"
            }
            (false, _) => {
                "needs radius_m and length_m (and offset_m where a joint bends it), or volume_m3 alone"
            }
        };
        Err(self.problem(content, path, problem.to_owned()))
    }
}

/// A number, whole or not.
fn number_of(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(whole) => {
            i64::from_str_radix(whole.as_str(), whole.radix()).ok().map(|whole| whole as f64)
        }
        _ => None,
    }
}

/// "did you mean ..?" when something is near, else what there is.
fn nearest(name: &str, known: &[&str]) -> String {
    /// Jaro-Winkler similarity below which a suggestion would only puzzle.
    const NEAR: f64 = 0.75;
    let name = name.to_ascii_lowercase();
    let near = known
        .iter()
        .map(|known| (strsim::jaro_winkler(&name, known), known))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(similarity, _)| *similarity >= NEAR);
    match near {
        Some((_, known)) => format!("did you mean {known}?"),
        None => format!("expected one of {}", known.join(", ")),
    }
}
