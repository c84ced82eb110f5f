//! Why a channel cannot be created or advanced.

use pneudrive_model::data::ChannelId;
use pneudrive_model::diagnosis::DiagnosisError;
use pneudrive_model::rig::RigError;
use pneudrive_model::simulation::SimulationError;
use pneudrive_model::store::StoreError;

/// A channel that cannot be created.
#[derive(Debug, thiserror::Error)]
pub enum CreateError {
    /// Not the name of a channel.
    #[error("{0}")]
    Name(String),
    /// The parameter file.
    #[error(transparent)]
    File(#[from] SimulationError),
    /// What the parameter file says about the channel.
    #[error(transparent)]
    Parameters(#[from] StoreError),
    /// What the extended model says about the channel, or lacks.
    #[error(transparent)]
    Extended(#[from] DiagnosisError),
    /// Its rig.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The file has no such channel.
    #[error("no channel {channel}; the file has {found}")]
    NoChannel {
        /// The channel.
        channel: ChannelId,
        /// Those that there are.
        found: String,
    },
    /// No time step.
    #[error("a step of {step_s} s is not possible; 0.00001 to 1 s are")]
    Step {
        /// What was asked for, s.
        step_s: f64,
    },
    /// The board's loop does not fit into the step.
    #[error("a step of {step_s} s is not a whole number of loops of the board, which runs at {rate_hz} Hz")]
    Loop {
        /// What was asked for, s.
        step_s: f64,
        /// Loops of the board per second, Hz.
        rate_hz: f64,
    },
    /// A drive for what has none.
    #[error("channel {channel} is a regulator: it follows a set point and has no drive")]
    Regulator {
        /// The channel.
        channel: ChannelId,
    },
    /// A part of the model that cannot be simulated step by step.
    #[error(
        "channel {channel} has a smooth correction, which needs the whole course of a simulation without it; delete [channels.{channel}.correction] from the file to go without it"
    )]
    Correction {
        /// The channel.
        channel: ChannelId,
    },
}

/// A step that is not possible.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum StepError {
    /// An input.
    #[error("{name} is {value}, which no chamber can have")]
    Input {
        /// Its name in [`Inputs`](crate::Inputs), or `pressure_kpa`.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// Not begun.
    #[error("the channel was not started, and no state was restored")]
    NotStarted,
    /// The pressure does not stay finite.
    #[error("the pressure runs away; the inputs are not what the parameters were calibrated with")]
    RunsAway,
    /// Another number of values than the channel's state has.
    #[error("a state of {found} numbers; the channel has {expected}")]
    State {
        /// What was given.
        found: usize,
        /// What the channel has.
        expected: usize,
    },
}
