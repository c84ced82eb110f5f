use thiserror::Error;

/// A rig file that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RigError {
    /// It cannot be read.
    #[error("{file}: cannot be read: {error}")]
    Open {
        /// The file.
        file: String,
        /// The system's word.
        error: String,
    },
    /// It is no TOML, or a table or key in it is unknown or of the wrong type.
    #[error("{file}:{line}: {problem}")]
    Syntax {
        /// The file.
        file: String,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong, and what is expected.
        problem: String,
    },
    /// A value out of its range.
    #[error("{file}:{line}: {key} = {value}: expected {expected}")]
    Value {
        /// The file.
        file: String,
        /// The line, counted from 1.
        line: usize,
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What is expected.
        expected: &'static str,
    },
}

impl RigError {
    pub(super) fn syntax(file: &str, text: &str, error: &toml::de::Error) -> Self {
        let line = error.span().map_or(1, |span| line_of(text, span.start));
        // TOML's own messages may have several lines.
        let problem = error.message().split('\n').collect::<Vec<_>>().join(", ");
        Self::Syntax { file: file.to_owned(), line, problem }
    }

    pub(super) fn value(
        file: &str,
        text: &str,
        at: usize,
        key: &'static str,
        value: f64,
        expected: &'static str,
    ) -> Self {
        Self::Value { file: file.to_owned(), line: line_of(text, at), key, value, expected }
    }
}

/// The line, counted from 1, of the byte at `at`.
fn line_of(text: &str, at: usize) -> usize {
    1 + text.bytes().take(at).filter(|&byte| byte == b'\n').count()
}
