//! What several recordings have of one channel, and how they are split.

use crate::data::{ChannelId, Recording};
use crate::diagnosis::channel::{Block, ChannelData, Role, compared_rows, simulate_coarsely};
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::preconditions::{Purpose, check, prepare_for};
use crate::diagnosis::settings::SETTINGS;
use crate::effects::ChannelInputs;
use crate::rig::Rig;

/// One channel of a machine.
#[derive(Debug, Clone)]
pub struct MachineChannel {
    /// Which one.
    pub id: ChannelId,
    /// What each recording has of it, in the order in which they were given.
    pub recorded: Vec<ChannelData>,
}

impl MachineChannel {
    /// The same without one recording.
    #[must_use]
    pub fn without(&self, recording: usize) -> Self {
        let mut others = self.clone();
        others.recorded.remove(recording);
        others
    }

    /// One recording alone.
    #[must_use]
    pub fn only(&self, recording: usize) -> Self {
        Self { id: self.id, recorded: vec![self.recorded[recording].clone()] }
    }
}

/// The channels of a machine, split and simulated as coarsely as a search may, with remarks on what
/// is left out.
///
/// # Errors
/// [`DiagnosisError`] when a recording has no channel that can be simulated, or others than the
/// first has.
pub fn channels(
    recordings: &[Recording],
    rig: &Rig,
) -> Result<(Vec<MachineChannel>, Vec<String>), DiagnosisError> {
    let mut channels: Vec<MachineChannel> = Vec::new();
    let mut notes = Vec::new();
    for (k, recording) in recordings.iter().enumerate() {
        let (mut prepared, left_out) = prepare_for(recording, rig, Purpose::Compare)?;
        let remarks = check(&recording.source.file, &prepared)?;
        notes.extend(left_out.into_iter().chain(remarks).map(|note| match recordings.len() {
            1 => note,
            _ => format!("{}: {note}", recording.source.file),
        }));
        prepared.iter_mut().for_each(split_in_three);
        simulate_coarsely(&mut prepared, true);
        let ids: Vec<ChannelId> = prepared.iter().map(|data| data.id).collect();
        if k == 0 {
            channels = ids.iter().map(|&id| MachineChannel { id, recorded: Vec::new() }).collect();
        }
        let first: Vec<ChannelId> = channels.iter().map(|channel| channel.id).collect();
        let kind = |data: &ChannelData| (data.plant.model.name(), data.driven_by());
        let alike = ids == first
            && channels
                .iter()
                .zip(&prepared)
                .all(|(c, d)| c.recorded.first().is_none_or(|first| kind(first) == kind(d)));
        if !alike {
            return Err(DiagnosisError::OtherChannels {
                file: recording.source.file.clone(),
                channels: listed(&ids),
                first: recordings[0].source.file.clone(),
                expected: listed(&first),
            });
        }
        for (channel, data) in channels.iter_mut().zip(prepared) {
            channel.recorded.push(data);
        }
    }
    Ok((channels, notes))
}

fn listed(ids: &[ChannelId]) -> String {
    ids.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// A recording is one of several like it: what is to be tested is what comes later, not what lies
/// in between.
pub fn split_in_three(data: &mut ChannelData) {
    data.blocks = in_three(&data.inputs);
    let (rows, spans) = compared_rows(&data.inputs, &data.blocks);
    let inputs = &data.inputs;
    let kpa = |&row: &u32| (inputs.measured_pa[row as usize] - inputs.ambient_pa) * 1e-3;
    data.measured_kpa = rows.iter().map(kpa).collect();
    (data.rows, data.spans) = (rows, spans);
}

/// Parts of a recording that fit and that choose; the rest tests. Several recordings share the
/// curves, so that less of each is enough to fit.
const PARTS: [f64; 2] = [0.45, 0.19];

/// The first part fits, the next chooses, the rest tests. What a start leaves behind is not
/// compared.
fn in_three(inputs: &ChannelInputs) -> Vec<Block> {
    let (rows, first_s) = (inputs.rows(), inputs.time_s[0]);
    let length_s = inputs.duration_s;
    let row_at = |t: f64| inputs.time_s.partition_point(|&x| x < first_s + t - 1e-9).min(rows);
    let select = PARTS[0] * length_s;
    let test = select + PARTS[1] * length_s;
    let ends = [(0.0, select, Role::Fit), (select, test, Role::Select), (test, f64::INFINITY, Role::Test)];
    ends.iter()
        .enumerate()
        .map(|(k, &(from, to, role))| {
            let forgotten = if k == 0 { SETTINGS.block_gap * length_s } else { 0.0 };
            Block { start: row_at(from), compared: row_at(from + forgotten), end: row_at(to), role }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::testing::channel;

    #[test]
    fn a_recording_is_cut_in_the_order_of_time_and_covered() {
        let (mut data, _) = channel(false);
        split_in_three(&mut data);
        let roles: Vec<Role> = data.blocks.iter().map(|b| b.role).collect();
        assert_eq!(roles, [Role::Fit, Role::Select, Role::Test]);
        assert_eq!((data.blocks[0].start, data.blocks[2].end), (0, data.inputs.rows()));
        assert!(data.blocks.windows(2).all(|pair| pair[0].end == pair[1].start));
        assert!(data.blocks[0].compared > 0 && data.blocks[1].compared == data.blocks[1].start);
        let counted: usize = data.spans.iter().map(|s| s.len()).sum();
        assert_eq!((counted, data.rows.len()), (data.measured_kpa.len(), data.measured_kpa.len()));
    }
}
