//! What models of a machine are worth on the parts where causes are chosen.

use super::recordings::MachineChannel;
use super::ties::TiedModel;
use crate::diagnosis::evidence::{Evidence, Predicted};

/// Parts of a recording that are weighed by themselves where there are few recordings.
const PIECES: usize = 4;
/// Recordings that are enough to be weighed as wholes.
const ENOUGH: usize = 5;

/// Of the models of one channel. The units are recordings, or pieces of them where there are few.
#[must_use]
pub fn evidence_of(channel: &MachineChannel, models: &TiedModel) -> Evidence {
    let pieces = pieces(channel.recorded.len());
    let mut evidence = Evidence::default();
    for (data, model) in channel.recorded.iter().zip(&models.models) {
        let predicted = Predicted::of(data, model);
        let terms = predicted.log_terms.concat();
        let length = terms.len().div_ceil(pieces).max(1);
        evidence.log_densities.extend(terms.chunks(length).map(|piece| piece.iter().sum::<f64>()));
        evidence.discrepancy_kpa.push(predicted.discrepancy_kpa);
        evidence.squares.0 += predicted.squares.0;
        evidence.squares.1 += predicted.squares.1;
    }
    evidence
}

/// Parts that each recording is weighed in.
#[must_use]
pub fn pieces(recordings: usize) -> usize {
    if recordings >= ENOUGH { 1 } else { PIECES }
}
