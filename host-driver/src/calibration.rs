//! What the counts of every channel mean.

use pneudrive_protocol::{CHANNELS, Counts, SensorScale};
use std::collections::BTreeMap;

/// The scale of every channel's sensor: one for all, and others for boards whose channels have been
/// calibrated. Set points and pressures are converted with it; boards know counts only.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Calibration {
    usual: SensorScale,
    boards: BTreeMap<u8, [SensorScale; CHANNELS]>,
}

impl Calibration {
    /// What a vented channel may read above its zero, counts: just below 10 kPa on the nominal
    /// sensor.
    const VENTED_COUNTS: f64 = 11.6;

    /// The scales of a board's channels, instead of those that it had.
    #[must_use]
    pub fn with_board(mut self, board: u8, scales: [SensorScale; CHANNELS]) -> Self {
        self.boards.insert(board, scales);
        self
    }

    /// The scale of channels without their own.
    pub fn usual(&self) -> SensorScale {
        self.usual
    }

    /// The scales of a board's channels 0 to 3.
    pub fn of(&self, board: u8) -> [SensorScale; CHANNELS] {
        self.boards.get(&board).copied().unwrap_or([self.usual; CHANNELS])
    }

    /// The scale of a channel; the usual one for a channel that does not exist.
    pub fn channel(&self, board: u8, channel: usize) -> SensorScale {
        self.of(board).get(channel).copied().unwrap_or(self.usual)
    }

    /// Pressures of a board's readings, kPa gauge.
    pub fn kpa(&self, board: u8, counts: [Counts; CHANNELS]) -> [f64; CHANNELS] {
        let scales = self.of(board);
        std::array::from_fn(|channel| scales[channel].kpa(counts[channel]))
    }

    /// Pressures that a command means, kPa gauge: see [`SensorScale::command_kpa`].
    pub fn command_kpa(&self, board: u8, command: [Counts; CHANNELS]) -> [f64; CHANNELS] {
        let scales = self.of(board);
        std::array::from_fn(|channel| scales[channel].command_kpa(command[channel]))
    }

    /// The largest pressure that any channel of these boards can be commanded, kPa gauge.
    pub fn full_scale_kpa(&self, boards: &[u8]) -> f64 {
        self.scales(boards).map(|scale| scale.full_scale_kpa()).fold(0.0, f64::max)
    }

    /// The count that commands 0 kPa or less to every channel of these boards. 102, that of the
    /// nominal sensor, unless a zero was found below it.
    pub fn vent(&self, boards: &[u8]) -> Counts {
        let zeros = self.scales(boards).map(|scale| Counts::saturating(scale.zero_counts().round() as u16));
        zeros.fold(Counts::ATMOSPHERE, Ord::min)
    }

    /// The highest reading of a vented channel, counts: see
    /// [`SafeStateOptions::vented`](crate::bus::SafeStateOptions::vented).
    pub fn vented(&self, boards: &[u8]) -> Counts {
        let highest = |scale: SensorScale| (scale.zero_counts() + Self::VENTED_COUNTS).round();
        Counts::saturating(self.scales(boards).map(highest).fold(0.0, f64::max) as u16)
    }

    /// Boards with scales of their own.
    pub fn boards(&self) -> impl Iterator<Item = u8> {
        self.boards.keys().copied()
    }

    fn scales(&self, boards: &[u8]) -> impl Iterator<Item = SensorScale> {
        boards.iter().flat_map(|&board| self.of(board))
    }
}

impl From<SensorScale> for Calibration {
    fn from(usual: SensorScale) -> Self {
        Self { usual, boards: BTreeMap::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_calibration_all_is_nominal() {
        let nominal = Calibration::default();
        assert_eq!(nominal.of(3), [SensorScale::ORIGINAL; CHANNELS]);
        assert_eq!(
            (nominal.vent(&[0, 1]), nominal.vented(&[0])),
            (Counts::ATMOSPHERE, Counts::saturating(114))
        );
        assert!((nominal.full_scale_kpa(&[0]) - 689.475_7).abs() < 1e-4);
    }

    #[test]
    fn a_channel_has_its_own_scale_and_0_kpa_is_0_kpa_at_all_of_them() {
        let low = SensorScale::new(95.2, 0.8, 600.0).unwrap();
        let high = SensorScale::new(110.0, 0.9, 700.0).unwrap();
        let usual = SensorScale::ORIGINAL;
        let calibration = Calibration::default().with_board(1, [usual, low, high, usual]);
        assert_eq!(calibration.kpa(1, [Counts::saturating(300); 4])[2], (300.0 - 110.0) * 0.9);
        assert_eq!(calibration.channel(0, 1), usual);
        assert_eq!((calibration.vent(&[0]).get(), calibration.vent(&[0, 1]).get()), (102, 95));
        assert_eq!(calibration.vented(&[0, 1]).get(), 122);
        assert_eq!(calibration.full_scale_kpa(&[0, 1]), 700.0);
        assert_eq!(calibration.command_kpa(1, [Counts::ATMOSPHERE; 4])[2], 0.0);
    }
}
