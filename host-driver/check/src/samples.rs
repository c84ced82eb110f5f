//! What a board answered.

use crate::CHANNELS;

/// Readings of one board over the time of a plan. Rows without a reading are left out.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Samples {
    t_s: Vec<f64>,
    command_kpa: Vec<[f64; CHANNELS]>,
    kpa: Vec<[f64; CHANNELS]>,
}

impl Samples {
    /// Adds a row: its time, s, which does not go back; what was commanded in it, kPa; and what the board answered to that command,
    /// kPa, which it measured before the command had an effect.
    pub fn push(&mut self, t_s: f64, command_kpa: [f64; CHANNELS], kpa: [f64; CHANNELS]) {
        self.t_s.push(t_s);
        self.command_kpa.push(command_kpa);
        self.kpa.push(kpa);
    }

    /// Rows so far.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }

    /// Times and pressures of a channel from `from_s` to before `to_s`.
    pub(crate) fn between(&self, channel: usize, from_s: f64, to_s: f64) -> Vec<(f64, f64)> {
        let from = self.t_s.partition_point(|&t| t < from_s);
        let to = self.t_s.partition_point(|&t| t < to_s).max(from);
        (from..to).map(|row| (self.t_s[row], self.kpa[row][channel])).collect()
    }

    /// When a channel's command came within 1 kPa of `kpa`, at `from_s` or later, and how long it was on its way: the first row with
    /// another command than before, and the first that is there.
    pub(crate) fn commanded(&self, channel: usize, from_s: f64, kpa: f64) -> Option<(f64, f64)> {
        const NEAR_KPA: f64 = 1.0;
        let from = self.t_s.partition_point(|&t| t < from_s);
        let before = self.command_kpa.get(from.checked_sub(1)?)?[channel];
        let rows = from..self.t_s.len();
        let left = rows.clone().find(|&row| (self.command_kpa[row][channel] - before).abs() > NEAR_KPA)?;
        let there = rows.clone().find(|&row| (self.command_kpa[row][channel] - kpa).abs() < NEAR_KPA)?;
        Some((self.t_s[left], self.t_s[there] - self.t_s[left]))
    }
}
