//! What a watcher says.

use serde::Serialize;

use crate::data::ChannelId;

/// One thing to say.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum WatchEvent {
    /// What is usual on a channel is known; from now on changes are found.
    Learnt(Learnt),
    /// Something has changed.
    Changed(Change),
}

/// A channel that is watched from now on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Learnt {
    /// When, s.
    pub t_s: f64,
    /// The channel.
    pub channel: ChannelId,
    /// Seconds that it was learnt from.
    pub seconds: f64,
    /// Standard deviation of the whitened innovations, kPa.
    pub innovation_kpa: f64,
    /// Least change of each effect's first parameter that would ever be said, however long it
    /// lasts; effects that cannot be seen in the rig's movements are left out.
    pub detectable: Vec<Detectable>,
}

/// A size.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Detectable {
    /// Effect of the catalogue.
    pub effect: &'static str,
    /// Its first parameter.
    pub parameter: &'static str,
    /// Value at which it would be said.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
}

/// Where something has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Where {
    /// On one channel.
    Channel(ChannelId),
    /// On the whole rig.
    Rig,
}

impl std::fmt::Display for Where {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Channel(id) => id.fmt(f),
            Self::Rig => f.write_str("rig"),
        }
    }
}

impl Serialize for Where {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// A change.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// When it was found, s.
    pub t_s: f64,
    /// The channel on which it was seen first.
    pub channel: ChannelId,
    /// Since when, s.
    pub since_s: f64,
    /// 95 % interval of that, s.
    pub since_ci95_s: [f64; 2],
    /// How far it stands out from what is usual: twice a logarithm of likelihoods.
    pub statistic: f64,
    /// What it may be, the most probable first. Together they have probability 1 but for what is
    /// left out below 1 %.
    pub explanations: Vec<Explanation>,
}

/// What a change may be.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explanation {
    /// Effect of the catalogue, or `something_else`.
    pub effect: &'static str,
    /// Where.
    #[serde(rename = "where")]
    pub place: Where,
    /// Probability, 0 to 1.
    pub probability: f64,
    /// Its first parameter and what that is now, if the effect is one of the catalogue.
    pub parameter: Option<&'static str>,
    /// Value of the parameter.
    pub value: Option<f64>,
    /// 95 % interval of the value.
    pub ci95: Option<[f64; 2]>,
    /// Unit of the value.
    pub unit: Option<&'static str>,
}
