//! Why commands are not followed, and how often.

use pneudrive_protocol::CHANNELS;

/// Why a command was not followed. What was commanded before stands.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// Numbers, but none where pressures belong.
    #[error(
        "`effort` is empty: pressures in kPa come in `effort`; `position` and `velocity` are no pressures"
    )]
    NotInEffort,
    /// Not four values.
    #[error("{found} values in `effort`; a board has {CHANNELS} chambers (fewer only with `name`)")]
    WrongLength {
        /// How many came.
        found: usize,
    },
    /// A name without a value, or a value without a name.
    #[error("{names} names for {values} values in `effort`")]
    NamesAndValues {
        /// How many names came.
        names: usize,
        /// How many values came.
        values: usize,
    },
    /// A name of nothing that this joint can be commanded.
    #[error("{name} is no command of joint_{joint}: its names are {known}")]
    UnknownName {
        /// What came.
        name: String,
        /// The joint.
        joint: u16,
        /// What its channels are called.
        known: String,
    },
    /// Two values for one channel.
    #[error("{name} is named twice")]
    NamedTwice {
        /// The name.
        name: String,
    },
    /// NaN or an infinity.
    #[error("channel {channel}: {kpa} is no pressure")]
    NotFinite {
        /// Which of the four.
        channel: usize,
        /// What came.
        kpa: f64,
    },
    /// Negative, more than the sensor can measure, or above the channel's limit.
    #[error("channel {channel}: {reason}")]
    OutOfRange {
        /// Which of the four.
        channel: usize,
        /// What is allowed.
        reason: String,
    },
    /// Its stamp is too far from now.
    #[error("its stamp is {age_s:.3} s old; allowed are {limit_s} s (parameter max_command_age_s)")]
    Stale {
        /// Age; negative for a stamp in the future.
        age_s: f64,
        /// The limit.
        limit_s: f64,
    },
}

/// What has come to a joint's command topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Commands that were followed.
    pub accepted: u64,
    /// Commands that were not, by reason.
    pub not_in_effort: u64,
    /// See [`Refusal::WrongLength`].
    pub wrong_length: u64,
    /// See [`Refusal::NamesAndValues`], [`Refusal::UnknownName`], [`Refusal::NamedTwice`].
    pub wrong_names: u64,
    /// See [`Refusal::NotFinite`].
    pub not_finite: u64,
    /// See [`Refusal::OutOfRange`].
    pub out_of_range: u64,
    /// See [`Refusal::Stale`].
    pub stale: u64,
    /// How often channels of the joint were vented because no command came.
    pub timeouts: u64,
}

impl Counters {
    /// All that were not followed.
    pub fn refused(&self) -> u64 {
        self.not_in_effort
            + self.wrong_length
            + self.wrong_names
            + self.not_finite
            + self.out_of_range
            + self.stale
    }

    /// Those that were not followed for the same kind of reason.
    pub fn refused_for(&mut self, refusal: &Refusal) -> &mut u64 {
        match refusal {
            Refusal::NotInEffort => &mut self.not_in_effort,
            Refusal::WrongLength { .. } => &mut self.wrong_length,
            Refusal::NamesAndValues { .. } | Refusal::UnknownName { .. } | Refusal::NamedTwice { .. } => {
                &mut self.wrong_names
            }
            Refusal::NotFinite { .. } => &mut self.not_finite,
            Refusal::OutOfRange { .. } => &mut self.out_of_range,
            Refusal::Stale { .. } => &mut self.stale,
        }
    }
}
