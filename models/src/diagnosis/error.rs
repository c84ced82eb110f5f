//! Why a recording cannot be diagnosed.

use thiserror::Error;

use crate::data::ChannelId;
use crate::rig::RigError;

/// A recording from which nothing can be named.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DiagnosisError {
    /// No channel can be simulated.
    #[error("{file}: no channel can be diagnosed: {reasons}")]
    NoUsableChannel {
        /// The recording.
        file: String,
        /// What is missing, channel by channel.
        reasons: String,
    },
    /// Recordings of one machine have different channels.
    #[error(
        "{file} has the channels {channels}, {first} has {expected} (with the same kind of drive): recordings of one machine need the same; choose them with --channels"
    )]
    OtherChannels {
        /// The recording.
        file: String,
        /// Its channels.
        channels: String,
        /// The first recording.
        first: String,
        /// The channels of that.
        expected: String,
    },
    /// A regulator has no load that could be told from the machine.
    #[error(
        "{file}: a regulator with its own loop is not parted into a machine and its load; --machine and --loads differ need a valve's drive, or a rig file with the board's loop"
    )]
    NoLoad {
        /// The recording.
        file: String,
    },
    /// An effect that the recording, or the question, has no room for.
    #[error("{file}: {effect} cannot be asked about: {why}")]
    NotInQuestion {
        /// The recording.
        file: String,
        /// The effect's id.
        effect: &'static str,
        /// Why not.
        why: &'static str,
    },
    /// Too short to fit, select and test.
    #[error(
        "{file}: {seconds:.1} s of usable data give {blocks} blocks of {block_s:.1} s; at least {wanted} are needed to fit, to choose and to test on different data: record at least 20 s"
    )]
    TooShort {
        /// The recording.
        file: String,
        /// Its length.
        seconds: f64,
        /// Blocks it gives.
        blocks: usize,
        /// Length of a block.
        block_s: f64,
        /// Blocks needed.
        wanted: usize,
    },
    /// The input does not move.
    #[error(
        "{file}: {what} of {channels} never changes: nothing can be learnt about what it drives; move it over its range while recording{}",
        only(.moving)
    )]
    NoExcitation {
        /// The recording.
        file: String,
        /// Drive or command.
        what: &'static str,
        /// Which channels.
        channels: String,
        /// Which move.
        moving: Vec<ChannelId>,
    },
    /// Command and pressure differ by the factor between two units.
    #[error(
        "{file}: the pressure of {channel} is on average {ratio:.3} times its command: {explanation}; convert it (`pneudrive-model import` knows the units)"
    )]
    Units {
        /// The recording.
        file: String,
        /// The channel.
        channel: String,
        /// Mean pressure over mean command.
        ratio: f64,
        /// What it looks like.
        explanation: String,
    },
    /// A pressure follows another channel's command.
    #[error(
        "{file}: the pressure of {channel} follows the {what} of {other} (correlation {theirs:.2}, with its own {own:.2}): two channels are swapped, in the columns or in the tubing"
    )]
    Swapped {
        /// The recording.
        file: String,
        /// The channel.
        channel: String,
        /// Whose command or drive it follows.
        other: String,
        /// Command or drive.
        what: &'static str,
        /// Correlation with its own command.
        own: f64,
        /// Correlation with the other's.
        theirs: f64,
    },
    /// A pressure moves against its own input.
    #[error(
        "{file}: the pressure of {channel} falls where its {what} rises (correlation {correlation:.2}): a positive drive must mean filling; change the sign of the column"
    )]
    Reversed {
        /// The recording.
        file: String,
        /// The channel.
        channel: String,
        /// Command or drive.
        what: &'static str,
        /// Correlation of the two.
        correlation: f64,
    },
    /// Too few samples a second.
    #[error(
        "{file}: {rate_hz:.2} samples a second are too few to see valves and lags; at least {wanted_hz:.0} are needed (and t_s must be in seconds)"
    )]
    TooSlow {
        /// The recording.
        file: String,
        /// Its rate, Hz.
        rate_hz: f64,
        /// Least rate, Hz.
        wanted_hz: f64,
    },
    /// Most of a channel's readings cannot be compared.
    #[error(
        "{file}: {percent:.0} % of the pressure readings of {channel} are missing, stuck or at a limit of the sensor: too many to diagnose anything from the rest; leave the channel out with --channels, or record anew: what was missing, where and why is among the remarks on the data (lost exchanges are the computer's or the wires', a limit is the sensor's)"
    )]
    Unusable {
        /// The recording.
        file: String,
        /// The channel.
        channel: String,
        /// How many, percent.
        percent: f64,
    },
    /// The fit of the base model fails.
    #[error("{file}: the {model} model cannot be fitted to {channel}: {hint}")]
    NoFit {
        /// The recording.
        file: String,
        /// The base model.
        model: &'static str,
        /// The channel.
        channel: String,
        /// What it may be.
        hint: String,
    },
    /// The reference does not fit the recording.
    #[error("{file}: {problem}")]
    Reference {
        /// The reference file.
        file: String,
        /// What is wrong.
        problem: String,
    },
    /// The rig that the reference was calibrated with is none.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// A file cannot be written.
    #[error("cannot write {file}: {source}")]
    Write {
        /// The file.
        file: String,
        /// Why.
        source: std::io::Error,
    },
}

/// What is left to diagnose, where anything is.
fn only(moving: &[ChannelId]) -> String {
    match moving {
        [] => String::new(),
        moving => {
            let names: Vec<String> = moving.iter().map(ToString::to_string).collect();
            format!(", or diagnose {} alone", names.join(","))
        }
    }
}
