//! Why a recording cannot be simulated.

use crate::data::{ChannelId, DataError, InputError};
use crate::diagnosis::DiagnosisError;
use crate::store::StoreError;

/// A simulation that is not possible.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// The parameter file.
    #[error(transparent)]
    Parameters(#[from] StoreError),
    /// The extended model, or what it lacks in the recording or the rig.
    #[error(transparent)]
    Extended(#[from] DiagnosisError),
    /// The recording or the rig lacks something.
    #[error(transparent)]
    Inputs(#[from] InputError),
    /// The recording.
    #[error(transparent)]
    Recording(#[from] DataError),
    /// The pressure does not stay finite.
    #[error(
        "channel {channel}: the simulation runs away; the inputs or the rig are not what the parameters were fitted with"
    )]
    RunsAway {
        /// The channel.
        channel: ChannelId,
    },
}
