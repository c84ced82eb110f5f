//! The name of one chamber: board and channel.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// One valve and chamber pair, named as in reports: board 0, channel 2 is `b0c2`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ChannelId {
    /// Board number, from 0. The bus carries four boards; a recording may hold more.
    pub board: u8,
    /// Channel on the board, from 0.
    pub channel: u8,
}

impl ChannelId {
    /// Name of this channel's command column, kPa gauge.
    #[must_use]
    pub fn command_column(self) -> String {
        format!("b{}_cmd{}_kpa", self.board, self.channel)
    }

    /// Name of this channel's pressure column, kPa gauge.
    #[must_use]
    pub fn pressure_column(self) -> String {
        format!("b{}_p{}_kpa", self.board, self.channel)
    }

    /// Name of this channel's drive column, -1 to 1.
    #[must_use]
    pub fn drive_column(self) -> String {
        format!("b{}_u{}", self.board, self.channel)
    }

    /// Names of this channel's separate drive columns, 0 to 1.
    #[must_use]
    pub fn fill_vent_columns(self) -> (String, String) {
        (format!("b{}_fill{}", self.board, self.channel), format!("b{}_vent{}", self.board, self.channel))
    }
}

impl fmt::Display for ChannelId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "b{}c{}", self.board, self.channel)
    }
}

/// A text that is not a channel name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected a channel such as b0c2 (board 0, channel 2), found \"{text}\"")]
pub struct ChannelNameError {
    /// What was given.
    pub text: String,
}

impl FromStr for ChannelId {
    type Err = ChannelNameError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parse = || {
            let (board, channel) = text.strip_prefix('b')?.split_once('c')?;
            Some(Self { board: board.parse().ok()?, channel: channel.parse().ok()? })
        };
        parse().ok_or_else(|| ChannelNameError { text: text.to_owned() })
    }
}

impl TryFrom<String> for ChannelId {
    type Error = ChannelNameError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse()
    }
}

impl From<ChannelId> for String {
    fn from(id: ChannelId) -> Self {
        id.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_round() {
        let id = ChannelId { board: 3, channel: 1 };
        assert_eq!(id.to_string(), "b3c1");
        assert_eq!("b3c1".parse(), Ok(id));
        assert!("b3".parse::<ChannelId>().is_err());
        assert!("b3c-1".parse::<ChannelId>().is_err());
        assert!("3c1".parse::<ChannelId>().is_err());
    }
}
