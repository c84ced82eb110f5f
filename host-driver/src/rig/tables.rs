//! The file's tables, as serde reads them.

use super::RigError;
use crate::poller::ChannelLimit;
use serde::{Deserialize, Deserializer, de};
use std::collections::BTreeMap;
use toml::Spanned;

/// The whole file. Unknown tables are refused: a misspelt `[limits]` would limit nothing.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Tables {
    pub limits: Option<LimitTable>,
    #[serde(default)]
    pub boards: BTreeMap<Board, BoardTable>,
    // What the modelling toolkit reads.
    #[serde(rename = "supply")]
    _supply: Option<de::IgnoredAny>,
    #[serde(rename = "ambient")]
    _ambient: Option<de::IgnoredAny>,
    #[serde(rename = "chamber")]
    _chamber: Option<de::IgnoredAny>,
    #[serde(rename = "valve")]
    _valve: Option<de::IgnoredAny>,
    #[serde(rename = "controller")]
    _controller: Option<de::IgnoredAny>,
    #[serde(rename = "sensor")]
    _sensor: Option<de::IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BoardTable {
    pub limits: Option<LimitTable>,
    #[serde(default)]
    pub channels: BTreeMap<Channel, ChannelTable>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ChannelTable {
    pub limits: Option<LimitTable>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LimitTable {
    max_kpa: Option<Spanned<f64>>,
    max_rate_kpa_s: Option<Spanned<f64>>,
}

impl LimitTable {
    /// The limit of this table, checked.
    pub fn limit(&self, file: &str, text: &str) -> Result<ChannelLimit, RigError> {
        let value = |key, value: &Option<Spanned<f64>>, usable: fn(f64) -> bool, expected| match value {
            None => Ok(f64::INFINITY),
            Some(value) if usable(*value.get_ref()) => Ok(*value.get_ref()),
            Some(value) => {
                Err(RigError::value(file, text, value.span().start, key, *value.get_ref(), expected))
            }
        };
        Ok(ChannelLimit {
            max_kpa: value("max_kpa", &self.max_kpa, |kpa| kpa >= 0.0, "a number of kPa gauge from 0 on")?,
            max_rate_kpa_s: value(
                "max_rate_kpa_s",
                &self.max_rate_kpa_s,
                |rate| rate > 0.0,
                "a number above 0, in kPa/s",
            )?,
        })
    }
}

/// A board's number, which is a key and so a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Board(pub u8);

/// A channel's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Channel(pub usize);

impl<'de> Deserialize<'de> for Board {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let refused = || de::Error::custom(format!("\"{text}\" is no board: expected 0 to 255"));
        text.parse().map(Self).map_err(|_| refused())
    }
}

impl<'de> Deserialize<'de> for Channel {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let channel = text.parse().ok().filter(|channel| *channel < pneudrive_protocol::CHANNELS);
        channel
            .map(Self)
            .ok_or_else(|| de::Error::custom(format!("\"{text}\" is no channel: expected 0 to 3")))
    }
}
