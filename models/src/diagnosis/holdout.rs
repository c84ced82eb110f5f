//! What an extended model gains on a recording that was not there when it was made.

use crate::data::Recording;
use crate::diagnosis::channel::{ChannelData, Extended, Role, share_draws};
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::estimation::models_of;
use crate::diagnosis::json::Gain;
use crate::diagnosis::preconditions::{Purpose, prepare_for};
use crate::diagnosis::rollout_errors::BlockErrors;
use crate::diagnosis::run::Diagnosis;
use crate::rig::Rig;

impl Diagnosis {
    /// Reduction of the rollouts' RMS error on the test blocks from the base models to the final
    /// ones, all causes together.
    #[must_use]
    pub fn gain(&self) -> Gain {
        let finals = models_of(&self.stages);
        let error = |models: &[Extended]| BlockErrors::of(&self.channels, models, &[Role::Test]);
        error(&self.base).gain(&error(&finals))
    }

    /// Reduction of the rollouts' RMS error from the base models to the final ones (corrections
    /// left out) on another recording of the same rig, all its blocks counted; in each block the
    /// start pressure is taken from the data.
    ///
    /// # Errors
    /// [`DiagnosisError`] when the recording has no channel that can be simulated, or lacks one
    /// that was diagnosed.
    pub fn gain_on(&self, recording: &Recording, rig: &Rig) -> Result<Gain, DiagnosisError> {
        let (mut channels, left_out) = prepare_for(recording, rig, Purpose::Compare)?;
        let ids = |channels: &[ChannelData]| channels.iter().map(|d| d.id).collect::<Vec<_>>();
        if ids(&channels) != ids(&self.channels) {
            return Err(DiagnosisError::NoUsableChannel {
                file: recording.source.file.clone(),
                reasons: format!("its channels are not those that were diagnosed. {}", left_out.join(" ")),
            });
        }
        for block in channels.iter_mut().flat_map(|d| &mut d.blocks) {
            block.role = Role::Test;
        }
        let finals = models_of(&self.stages);
        share_draws(&mut channels, &finals);
        let error = |models: &[Extended]| BlockErrors::of(&channels, models, &[Role::Test]);
        Ok(error(&self.base).gain(&error(&finals)))
    }
}
