//! What can be wrong with a plant's description.

use super::id::ChannelId;

/// For people: a number of the unit 1 stands alone.
pub fn with_unit(value: f64, unit: &str) -> String {
    if unit == "1" { value.to_string() } else { format!("{value} {unit}") }
}

/// A plant that cannot be built or asked for a channel it does not have.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// A parameter is outside the range in which its equation means anything.
    #[error("plant parameter {name} is {}: expected {expected}", with_unit(*value, unit))]
    Parameter {
        /// Path of the field, for example `valve.conductance_m3_per_s_pa`.
        name: &'static str,
        /// What was given.
        value: f64,
        /// Unit of `value`.
        unit: &'static str,
        /// The range that is accepted.
        expected: &'static str,
    },
    /// An effect could not be applied.
    #[error(transparent)]
    Effect(#[from] EffectError),
    /// Parameters that are fine one by one make a time constant the fixed step cannot follow.
    #[error(
        "{what} of {channel} has a time constant of {time_constant_us:.1} us, too short for steps of {step_us:.1} us \
         (at least {required_us:.1} us): enlarge {enlarge} or shorten step_ns"
    )]
    TooStiff {
        /// The volume that fills too fast.
        what: &'static str,
        /// Where.
        channel: ChannelId,
        /// Shortest time constant it can reach, microseconds.
        time_constant_us: f64,
        /// The integration step, microseconds.
        step_us: f64,
        /// Shortest time constant that is accepted at this step, microseconds.
        required_us: f64,
        /// Which parameter to enlarge.
        enlarge: &'static str,
    },
    /// The plant has no such channel.
    #[error("no channel {channel}: the plant has {channels} channels, from b0c0 on, four to a board")]
    NoSuchChannel {
        /// What was asked for.
        channel: ChannelId,
        /// How many there are.
        channels: usize,
    },
    /// The plant has no such board.
    #[error("no board {board}: the plant has {boards} boards, from 0 on")]
    NoSuchBoard {
        /// What was asked for.
        board: u8,
        /// How many there are.
        boards: usize,
    },
    /// A drive is not a number from -1 to 1.
    #[error("drive of {channel} is {value}: expected -1 (vent) to 1 (fill)")]
    Drive {
        /// Where.
        channel: ChannelId,
        /// What was given.
        value: f64,
    },
}

/// An effect that cannot be read or applied.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EffectError {
    /// The text is not an effect.
    #[error(
        "effect {text:?}: {problem}; expected id, id=value or id:name=value,name=value, each with an optional @b0 or @b0c2"
    )]
    Syntax {
        /// The text.
        text: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// No such effect.
    #[error("no effect {id:?}; known: {known}")]
    UnknownId {
        /// What was asked for.
        id: String,
        /// All ids.
        known: String,
    },
    /// The effect has no such parameter.
    #[error("effect {id} has no parameter {name:?}; it has {known}")]
    UnknownParameter {
        /// The effect.
        id: &'static str,
        /// What was asked for.
        name: String,
        /// Its parameters.
        known: String,
    },
    /// A value is not a number or outside its range.
    #[error("effect {id}: {name} is {}: expected {min} to {max}", with_unit(*value, unit))]
    Value {
        /// The effect.
        id: &'static str,
        /// Its parameter.
        name: &'static str,
        /// What was given.
        value: f64,
        /// Unit of `value`, `min` and `max`.
        unit: &'static str,
        /// Smallest accepted value.
        min: f64,
        /// Largest accepted value.
        max: f64,
    },
    /// The scope is finer than what the effect acts on.
    #[error("effect {id} acts on {acts_on}: it cannot be limited to {scope}")]
    Scope {
        /// The effect.
        id: &'static str,
        /// `the whole rig` or `a whole board`.
        acts_on: &'static str,
        /// What was asked for.
        scope: String,
    },
    /// The scope names something the plant does not have.
    #[error("effect {id}: no {scope} in a plant of {channels} channels")]
    NoSuchPlace {
        /// The effect.
        id: &'static str,
        /// What was asked for.
        scope: String,
        /// How many channels there are.
        channels: usize,
    },
    /// The same effect twice on one channel.
    #[error("effect {id} is given twice for {place}: give it once with the values wanted")]
    Twice {
        /// The effect.
        id: &'static str,
        /// Where.
        place: String,
    },
}
