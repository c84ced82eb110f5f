//! When the next cycle starts.

use crate::time::saturating_ns;
use std::time::Duration;

/// How often the boards are polled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pace {
    /// One cycle after the other.
    #[default]
    AsFastAsPossible,
    /// At absolute deadlines: start + k period.
    Every {
        /// Time between two starts.
        period: Duration,
        /// What happens to starts that were missed because a cycle took too long.
        missed: MissedTick,
    },
}

impl Pace {
    /// A start every `period`; those that were missed are left out.
    pub const fn every(period: Duration) -> Self {
        Self::Every { period, missed: MissedTick::Skip }
    }
}

/// What happens to starts that were missed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MissedTick {
    /// They are left out; the next cycle starts on the grid again. Set points and rows stay in
    /// phase with the clock.
    #[default]
    Skip,
    /// They are made up for, one cycle right after the other, until the grid is reached. The number
    /// of cycles stays right.
    CatchUp,
    /// The grid moves: the next cycle starts at once and the following ones a period after it.
    Shift,
}

#[derive(Debug, Clone)]
pub(super) struct Schedule {
    /// The period, ns, and what happens to missed starts; `None` for as fast as possible.
    grid: Option<(u64, MissedTick)>,
    next_ns: u64,
    missed: u64,
}

impl Schedule {
    pub(super) fn new(pace: Pace, start_ns: u64) -> Self {
        let grid = match pace {
            Pace::AsFastAsPossible => None,
            Pace::Every { period, missed } => Some((saturating_ns(period), missed)),
        };
        Self { grid, next_ns: start_ns, missed: 0 }
    }

    /// Starts that could not be kept.
    pub(super) fn missed(&self) -> u64 {
        self.missed
    }

    /// A cycle starts at `now_ns` (at or after the last result of this function): when the one
    /// after it should.
    pub(super) fn next_start(&mut self, now_ns: u64) -> u64 {
        let Some((period_ns, missed)) = self.grid else { return now_ns };
        let start_ns = self.next_ns;
        self.next_ns = start_ns + period_ns;
        let late_ns = now_ns.saturating_sub(self.next_ns);
        let skipped = late_ns / period_ns.max(1) + 1;
        if now_ns > self.next_ns {
            match missed {
                MissedTick::Skip => {
                    self.missed += skipped;
                    self.next_ns += skipped * period_ns;
                }
                MissedTick::CatchUp => self.missed += 1,
                MissedTick::Shift => {
                    self.missed += skipped;
                    self.next_ns = now_ns;
                }
            }
        }
        self.next_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Starts of cycles of which the third takes 3.5 periods, at 10 ns a period.
    fn starts(missed: MissedTick) -> (Vec<u64>, u64) {
        let mut schedule = Schedule::new(Pace::Every { period: Duration::from_nanos(10), missed }, 100);
        let mut now = 100;
        let starts = (0..7)
            .map(|cycle| {
                let start = now;
                now += if cycle == 2 { 35 } else { 2 };
                now = now.max(schedule.next_start(now));
                start
            })
            .collect();
        (starts, schedule.missed())
    }

    #[test]
    fn skipping_stays_on_the_grid() {
        assert_eq!(starts(MissedTick::Skip), (vec![100, 110, 120, 160, 170, 180, 190], 3));
    }

    #[test]
    fn catching_up_keeps_the_number() {
        // Late at 130, 140 and 150 (155, 157, 159), back on the grid at 160.
        assert_eq!(starts(MissedTick::CatchUp), (vec![100, 110, 120, 155, 157, 159, 161], 4));
    }

    #[test]
    fn shifting_moves_the_grid() {
        assert_eq!(starts(MissedTick::Shift), (vec![100, 110, 120, 155, 165, 175, 185], 3));
    }
}
