//! What the host takes from the rig file: the limits of the channels.
//!
//! ```toml
//! [limits]                        # of every channel
//! max_kpa = 300.0
//! max_rate_kpa_s = 500.0
//!
//! [boards.0.limits]               # of one board, beside those above
//! max_kpa = 250.0
//!
//! [boards.0.channels.3.limits]    # of one channel, beside those above
//! max_kpa = 100.0
//! ```
//!
//! Of several limits for one channel the strictest holds. The other tables of the file describe the
//! machine to the modelling toolkit, which checks them; here they are known by name only.

mod error;
mod tables;

pub use error::RigError;

use crate::poller::{ChannelLimit, Limits};
use pneudrive_protocol::CHANNELS;
use std::path::Path;
use tables::{LimitTable, Tables};

/// A rig file.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// Highest set points and fastest changes.
    pub limits: Limits,
    /// The file's text, for recordings to carry.
    pub text: String,
}

impl Rig {
    /// Reads and checks the file at `path`.
    ///
    /// # Errors
    /// The file cannot be read, or a table or value in it cannot be used: with its line and what is expected.
    pub fn load(path: &Path) -> Result<Self, RigError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path)
            .map_err(|error| RigError::Open { file: file.clone(), error: error.to_string() })?;
        Self::parse(&text, &file)
    }

    /// The same from a text; `file` is its name in messages.
    ///
    /// # Errors
    /// As for [`load`](Self::load).
    pub fn parse(text: &str, file: &str) -> Result<Self, RigError> {
        let tables: Tables = toml::from_str(text).map_err(|error| RigError::syntax(file, text, &error))?;
        let place = |table: &LimitTable| table.limit(file, text);
        let usual = tables.limits.as_ref().map_or(Ok(ChannelLimit::NONE), place)?;
        let unusable = |_| RigError::Open { file: file.to_owned(), error: "limits out of range".to_owned() };
        let mut limits = Limits::everywhere(usual).map_err(unusable)?;
        for (board, table) in &tables.boards {
            let of_board = table.limits.as_ref().map_or(Ok(ChannelLimit::NONE), place)?.stricter(usual);
            for channel in 0..CHANNELS {
                let own =
                    table.channels.get(&tables::Channel(channel)).and_then(|table| table.limits.as_ref());
                let limit = own.map_or(Ok(ChannelLimit::NONE), place)?.stricter(of_board);
                limits.set(board.0, channel, limit).map_err(unusable)?;
            }
        }
        Ok(Self { limits, text: text.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MIXED: &str = "\
[supply]
pressure_kpa = 550.0

[limits]
max_kpa = 300
max_rate_kpa_s = 500.0

[boards.0.limits]
max_kpa = 250.0
[boards.0.channels.3.limits]
max_kpa = 100.0
[boards.12.channels.1.limits]
max_rate_kpa_s = 20.0
";

    fn refused(text: &str) -> String {
        Rig::parse(text, "rig.toml").unwrap_err().to_string()
    }

    #[test]
    fn the_strictest_limit_holds_for_each_channel() {
        let limits = Rig::parse(MIXED, "rig.toml").unwrap().limits;
        let pair = |board, channel: usize| {
            let limit = limits.of(board)[channel];
            (limit.max_kpa, limit.max_rate_kpa_s)
        };
        assert_eq!(pair(3, 0), (300.0, 500.0));
        assert_eq!(pair(0, 0), (250.0, 500.0));
        assert_eq!(pair(0, 3), (100.0, 500.0));
        assert_eq!((pair(12, 0), pair(12, 1)), ((300.0, 500.0), (300.0, 20.0)));
    }

    #[test]
    fn a_file_without_limits_limits_nothing() {
        let rig = Rig::parse("[sensor]\nbits = 10\n", "rig.toml").unwrap();
        assert_eq!(rig.limits, Limits::default());
    }

    /// A misspelt key must not leave a limit out in silence.
    #[test]
    fn errors_name_the_line_the_key_and_what_is_expected() {
        let cases = [
            (
                "[limits]\nmax_kpa = -3.0\n",
                "rig.toml:2: max_kpa = -3: expected a number of kPa gauge from 0 on",
            ),
            ("[limits]\n\nmax_rate_kpa_s = 0\n", "rig.toml:3: max_rate_kpa_s = 0: expected a number above 0"),
            ("[limits]\nmax_kpa = nan\n", "rig.toml:2: max_kpa = NaN: expected"),
            (
                "[limits]\nmax_pka = 3.0\n",
                "rig.toml:2: unknown field `max_pka`, expected `max_kpa` or `max_rate_kpa_s`",
            ),
            ("[limit]\nmax_kpa = 3.0\n", "rig.toml:1: unknown field `limit`, expected one of"),
            ("[limits]\nmax_kpa = \"3\"\n", "rig.toml:2: invalid type: string \"3\", expected f64"),
            ("[boards.256.limits]\nmax_kpa = 3\n", "rig.toml:1: \"256\" is no board: expected 0 to 255"),
            (
                "[boards.1.channels.4.limits]\nmax_kpa = 3\n",
                "rig.toml:1: \"4\" is no channel: expected 0 to 3",
            ),
            ("[boards.1.limits\n", "rig.toml:1: "),
        ];
        for (text, expected) in cases {
            let message = refused(text);
            assert!(message.starts_with(expected), "{text:?}: {message}");
            assert!(!message.contains('\n'), "{message}");
        }
    }
}
