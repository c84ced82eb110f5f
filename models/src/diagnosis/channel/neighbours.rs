//! What a channel can see of its neighbours: the chamber opposite, and the channel that is sampled
//! before it.

use super::data::ChannelData;
use crate::data::{ChannelId, Recording};
use crate::effects::Series;

/// Rows on each side over which the pressure opposite is averaged.
const SMOOTH_ROWS: usize = 2;

/// Pressures of some channels, kPa gauge, one value a row, none missing.
#[derive(Debug, Clone, Default)]
pub struct Pressures(Vec<(ChannelId, Series)>);

impl Pressures {
    /// As measured, the last value held where one is missing. Channels without measured pressures
    /// stay at `unmeasured_kpa`, or are left out without it.
    #[must_use]
    pub fn measured(recording: &Recording, unmeasured_kpa: Option<f64>) -> Self {
        let of = |channel: &crate::data::Channel| -> Option<(ChannelId, Series)> {
            let Some(pressure) = &channel.pressure_kpa else {
                return unmeasured_kpa.map(|kpa| (channel.id, vec![kpa; recording.rows()].into()));
            };
            let mut last = 0.0;
            let hold = |p: &f32| {
                if p.is_finite() {
                    last = f64::from(*p);
                }
                last
            };
            Some((channel.id, pressure.iter().map(hold).collect()))
        };
        Self(recording.channels.iter().filter_map(of).collect())
    }

    /// As simulated.
    #[must_use]
    pub fn simulated(channels: Vec<(ChannelId, Series)>) -> Self {
        Self(channels)
    }

    fn of(&self, board: u8, channel: u8) -> Option<&[f64]> {
        let found = self.0.iter().find(|(id, _)| (id.board, id.channel) == (board, channel));
        found.map(|(_, kpa)| &kpa[..])
    }

    /// Smoothed pressure of the chamber on the other side of the joint, gauge Pa; empty when it is
    /// not known.
    #[must_use]
    pub fn opposite_pa(&self, id: ChannelId) -> Series {
        let Some(kpa) = self.of(id.board, id.channel ^ 1) else {
            return Series::default();
        };
        let mean = |k: usize| {
            let window = &kpa[k.saturating_sub(SMOOTH_ROWS)..(k + SMOOTH_ROWS + 1).min(kpa.len())];
            1e3 * window.iter().sum::<f64>() / window.len() as f64
        };
        (0..kpa.len()).map(mean).collect()
    }

    /// Pressure of the channel that the converter samples before this one, gauge Pa; channel 0
    /// follows the board's last. Empty when it is not known.
    #[must_use]
    pub fn sampled_before_pa(&self, id: ChannelId) -> Series {
        let last = self.0.iter().filter(|(other, _)| other.board == id.board).map(|(o, _)| o.channel).max();
        let before = if id.channel == 0 { last.unwrap_or(0) } else { id.channel - 1 };
        match self.of(id.board, before) {
            Some(kpa) if before != id.channel => kpa.iter().map(|p| p * 1e3).collect(),
            _ => Series::default(),
        }
    }

    /// Puts these in the place of what a channel knew of its neighbours, where it knew anything.
    pub fn put_into(&self, data: &mut ChannelData) {
        if !data.inputs.opposite_pa.is_empty() {
            data.inputs.opposite_pa = self.opposite_pa(data.id);
        }
        if !data.inputs.sampled_before_pa.is_empty() {
            data.inputs.sampled_before_pa = self.sampled_before_pa(data.id);
        }
    }
}
