//! What the program says, line by line.

use serde::Deserialize;

/// A line of `pneudrive-model watch --json`. Keys that are not needed here are passed over.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Line {
    /// Version of the keys.
    pub(super) schema: String,
    /// A sentence for people.
    pub(super) text: String,
    #[serde(flatten)]
    pub(super) says: Says,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(super) enum Says {
    /// It runs; so many channels are to be watched.
    Begin { channels: Vec<String> },
    /// What is usual on a channel is known.
    Learnt,
    /// A channel has changed.
    Changed {
        channel: String,
        /// When it was found and since when, s since the run's start.
        t_s: f64,
        since_s: f64,
        explanations: Vec<Explanation>,
    },
    /// There are no more rows.
    End,
    /// Of a newer program.
    #[serde(other)]
    Other,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Explanation {
    pub(super) effect: String,
    pub(super) probability: f64,
}

impl Line {
    /// Version of the keys that is understood.
    pub(super) const SCHEMA: &str = "pneudrive-watch/1";

    /// Reads a line; why it cannot be understood, in words.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let line: Self = serde_json::from_str(text).map_err(|error| format!("not understood: {error}"))?;
        match line.schema == Self::SCHEMA {
            true => Ok(line),
            false => Err(format!("it speaks {}, expected {}", line.schema, Self::SCHEMA)),
        }
    }
}

/// The board of a channel's name, as in `b0c2`.
pub(super) fn board_of(channel: &str) -> Option<u8> {
    channel.strip_prefix('b')?.split('c').next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_and_strange_ones_told() {
        let begin = r#"{"schema":"pneudrive-watch/1","text":"learning","kind":"begin","channels":["b0c0"],"learn_s":600.0}"#;
        assert_eq!(Line::parse(begin).unwrap().says, Says::Begin { channels: vec!["b0c0".into()] });
        let newer = r#"{"schema":"pneudrive-watch/1","text":"x","kind":"rests"}"#;
        assert_eq!(Line::parse(newer).unwrap().says, Says::Other);
        let other = Line::parse(&newer.replace("watch/1", "watch/2")).unwrap_err();
        assert!(other.contains("pneudrive-watch/2, expected pneudrive-watch/1"), "{other}");
        assert!(Line::parse("hello").is_err());
        assert_eq!((board_of("b12c3"), board_of("c3")), (Some(12), None));
    }
}
