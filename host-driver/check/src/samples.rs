//! What a board answered.

use crate::CHANNELS;

/// Readings of one board over the time of a plan. Rows without a reading are left out.
///
/// When a row was asked for is known only as long as the program ran: where the next row is late,
/// the program may have stood still between looking at the clock and sending. Such a row's time is
/// not trusted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Samples {
    t_s: Vec<f64>,
    command_kpa: Vec<[f64; CHANNELS]>,
    kpa: Vec<[f64; CHANNELS]>,
}

/// A row that follows after more than so many usual times between rows is late.
const LATE: f64 = 1.6;

impl Samples {
    /// Adds a row: its time, s, which does not go back; what was commanded in it, kPa; and what the
    /// board answered to that command, kPa, which it measured before the command had an effect.
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

    /// Usual time between two rows, s: the median. Not a number for fewer than two rows.
    pub(crate) fn period_s(&self) -> f64 {
        let mut between: Vec<f64> = self.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if between.is_empty() {
            return f64::NAN;
        }
        let middle = between.len() / 2;
        *between.select_nth_unstable_by(middle, f64::total_cmp).1
    }

    /// As [`between`](Self::between), without the rows whose time is not trusted.
    pub(crate) fn timed(&self, channel: usize, from_s: f64, to_s: f64, period_s: f64) -> Vec<(f64, f64)> {
        let from = self.t_s.partition_point(|&t| t < from_s);
        let to = self.t_s.partition_point(|&t| t < to_s).max(from);
        let rows = (from..to).filter(|&row| !self.is_before_late(row, period_s));
        rows.map(|row| (self.t_s[row], self.kpa[row][channel])).collect()
    }

    /// Whether the time of the row nearest to `at_s` is not trusted.
    pub(crate) fn is_late_at(&self, at_s: f64, period_s: f64) -> bool {
        let row = self.t_s.partition_point(|&t| t < at_s - 0.5 * period_s);
        self.is_before_late(row, period_s)
    }

    /// The longest time without a row from `from_s` to `to_s`, s.
    pub(crate) fn longest_gap_s(&self, from_s: f64, to_s: f64) -> f64 {
        let from = self.t_s.partition_point(|&t| t < from_s).saturating_sub(1);
        let to = (self.t_s.partition_point(|&t| t < to_s) + 1).min(self.t_s.len());
        self.t_s[from..to].windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
    }

    fn is_before_late(&self, row: usize, period_s: f64) -> bool {
        let next = self.t_s.get(row + 1).zip(self.t_s.get(row));
        next.is_some_and(|(next, this)| next - this > LATE * period_s)
    }

    /// When a channel's command came within 1 kPa of `kpa`, at `from_s` or later, and how long it
    /// was on its way: the first row with another command than before, and the first that is there.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_before_a_gap_has_no_trusted_time() {
        let mut samples = Samples::default();
        for t_s in [0.0, 0.002, 0.004, 0.006, 0.016, 0.018, 0.020] {
            samples.push(t_s, [0.0; CHANNELS], [t_s; CHANNELS]);
        }
        let period_s = samples.period_s();
        assert!((period_s - 0.002).abs() < 1e-9);
        let timed: Vec<f64> = samples.timed(1, 0.001, 0.019, period_s).iter().map(|(t, _)| *t).collect();
        assert_eq!(timed, [0.002, 0.004, 0.016, 0.018]);
        assert!(samples.is_late_at(0.006, period_s) && !samples.is_late_at(0.016, period_s));
        assert!((samples.longest_gap_s(0.002, 0.005) - 0.002).abs() < 1e-9);
        assert!((samples.longest_gap_s(0.010, 0.012) - 0.010).abs() < 1e-9);
    }
}
