//! Set points from a file, as a source of commands.
//!
//! A table (CSV, also compressed) has the columns `t_s` (time after the start, s, from 0 on,
//! strictly increasing) and any `b{n}_cmd{k}_kpa` (board n, channel k, kPa gauge). A recording can
//! be played again: comments and its other columns are ignored, and so are columns of others, which
//! [`Trajectory::ignored`] names. A misspelt command is refused. So can a recording that is a bag.
//! The whole file is checked before anything is sent.
//!
//! Before its first row a trajectory commands nothing: channels keep what is commanded otherwise.

mod bag;
mod error;
mod generate;
mod names;
mod read;

pub(crate) use bag::joint_state;
pub use error::{AboveLimitAt, TrajectoryError};
pub use generate::{Plan, Shape};
pub use names::ColumnName;

use pneudrive_host::Calibration;
use pneudrive_host::poller::{BoardCommand, CommandSource, Limits, SourceStatus};
use pneudrive_protocol::{Counts, SensorScale};

/// What is commanded between two rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// The earlier row's commands, until the later row's time.
    #[default]
    Hold,
    /// On the straight line between the two.
    Linear,
}

/// What happens after the last row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AtEnd {
    /// The run ends.
    #[default]
    Stop,
    /// The last row's commands stay.
    Hold,
    /// The first row follows, and so on for ever: a row at the last row's time is the first one
    /// again.
    Repeat,
}

/// Commands over time for some channels.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    times_ns: Vec<u64>,
    channels: Vec<Channel>,
    ignored: Vec<String>,
}

#[derive(Debug, Clone, PartialEq)]
struct Channel {
    /// Index of the board among those polled.
    board: usize,
    channel: usize,
    /// One value a row, kPa gauge, each checked against the scale.
    kpa: Vec<f64>,
}

impl Channel {
    fn scale(&self, calibration: &Calibration) -> SensorScale {
        scale(calibration, self.board, self.channel)
    }
}

/// Boards are numbered from 0, so that their index is their number.
fn scale(calibration: &Calibration, board: usize, channel: usize) -> SensorScale {
    calibration.channel(u8::try_from(board).unwrap_or(u8::MAX), channel)
}

impl Trajectory {
    /// Time of the last row after the start, s.
    pub fn seconds(&self) -> f64 {
        self.times_ns.last().map_or(0.0, |&ns| ns as f64 * 1e-9)
    }

    /// Time of the first row after the start, s.
    pub fn first_row_s(&self) -> f64 {
        self.times_ns.first().map_or(0.0, |&ns| ns as f64 * 1e-9)
    }

    /// The same trajectory from its first row on, whose time becomes 0: a recording that was begun
    /// in the middle of a run.
    #[must_use]
    pub fn from_first_row(mut self) -> Self {
        let first_ns = self.times_ns.first().copied().unwrap_or(0);
        self.times_ns.iter_mut().for_each(|time_ns| *time_ns -= first_ns);
        self
    }

    /// The same trajectory `factor` times as fast, from the run's start on. At least 1 ns is
    /// between two rows.
    #[must_use]
    pub fn with_speed(mut self, factor: f64) -> Self {
        let mut least = 0;
        for time_ns in &mut self.times_ns {
            *time_ns = ((*time_ns as f64 / factor).round() as u64).max(least);
            least = *time_ns + 1;
        }
        self
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.times_ns.len()
    }

    /// Columns of a table that are neither commands nor a recording's, and do nothing.
    pub fn ignored(&self) -> &[String] {
        &self.ignored
    }

    /// Whether it stays within `limits`; boards are numbered from 0.
    ///
    /// # Errors
    /// The first set point above its channel's limit, with its time.
    pub fn check(&self, limits: &Limits) -> Result<(), AboveLimitAt> {
        for channel in &self.channels {
            let board = u8::try_from(channel.board).unwrap_or(u8::MAX);
            for (&time_ns, &kpa) in self.times_ns.iter().zip(&channel.kpa) {
                limits
                    .check(board, channel.channel, kpa)
                    .map_err(|refused| AboveLimitAt { t_s: time_ns as f64 * 1e-9, refused })?;
            }
        }
        Ok(())
    }

    /// A source that plays it. Channels without a column, and all of them before the first row, get
    /// their value from `others`, one command a board.
    pub fn play(
        self,
        interpolation: Interpolation,
        at_end: AtEnd,
        calibration: impl Into<Calibration>,
        others: Vec<BoardCommand>,
    ) -> TrajectorySource {
        let calibration = calibration.into();
        let scales = self.channels.iter().map(|channel| channel.scale(&calibration)).collect();
        TrajectorySource { trajectory: self, interpolation, at_end, scales, others, row: 0 }
    }
}

/// A trajectory being played.
#[derive(Debug, Clone)]
pub struct TrajectorySource {
    trajectory: Trajectory,
    interpolation: Interpolation,
    at_end: AtEnd,
    /// Of each channel.
    scales: Vec<SensorScale>,
    others: Vec<BoardCommand>,
    /// The last row whose time has come.
    row: usize,
}

impl TrajectorySource {
    /// How far `now_ns` is from this row (0) to the next (1).
    fn progress(&self, now_ns: u64) -> f64 {
        let times = &self.trajectory.times_ns;
        match (self.interpolation, times.get(self.row + 1)) {
            (Interpolation::Linear, Some(&next)) => {
                let from = times[self.row];
                now_ns.saturating_sub(from) as f64 / (next - from) as f64
            }
            _ => 0.0,
        }
    }

    fn counts(&self, channel: &Channel, scale: SensorScale, progress: f64) -> Counts {
        let here = channel.kpa[self.row];
        let next = channel.kpa.get(self.row + 1).copied().unwrap_or(here);
        // Between two values that were checked, so never refused.
        scale.counts(here + progress * (next - here)).unwrap_or(Counts::ATMOSPHERE)
    }
}

impl CommandSource for TrajectorySource {
    fn fill(&mut self, since_start_ns: u64, commands: &mut [BoardCommand]) -> SourceStatus {
        let times = &self.trajectory.times_ns;
        let mut since_start_ns = since_start_ns;
        if let (AtEnd::Repeat, Some(&first), Some(&last)) = (self.at_end, times.first(), times.last())
            && last > first
            && since_start_ns >= last
        {
            since_start_ns = first + (since_start_ns - first) % (last - first);
            // Where it has begun anew, rows are looked for from the first on.
            if times[self.row] > since_start_ns {
                self.row = 0;
            }
        }
        while times.get(self.row + 1).is_some_and(|&next| next <= since_start_ns) {
            self.row += 1;
        }
        let progress = self.progress(since_start_ns);
        for (command, other) in commands.iter_mut().zip(&self.others) {
            *command = *other;
        }
        if self.trajectory.times_ns.first().is_some_and(|&first| since_start_ns < first) {
            return SourceStatus::Continues;
        }
        for (channel, &scale) in self.trajectory.channels.iter().zip(&self.scales) {
            commands[channel.board][channel.channel] = self.counts(channel, scale, progress);
        }
        let at_last_row = self.row + 1 == self.trajectory.times_ns.len();
        let ended = at_last_row && times.last().is_some_and(|&last| since_start_ns >= last);
        if ended && self.at_end == AtEnd::Stop { SourceStatus::Ended } else { SourceStatus::Continues }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pneudrive_host::poller::VENTED;

    const FILE: &str = "t_s,b0_cmd1_kpa,note\n0,0,x\n1,100,\n3,50,y\n";
    const SCALE: SensorScale = SensorScale::ORIGINAL;

    fn play(interpolation: Interpolation, times_s: &[f64]) -> Vec<(f64, SourceStatus)> {
        let trajectory = Trajectory::parse("test.csv", FILE.as_bytes(), 1, SCALE).unwrap();
        let mut source = trajectory.play(interpolation, AtEnd::Stop, SCALE, vec![VENTED]);
        let at = |s: &f64| {
            let mut commands = [VENTED];
            let status = source.fill((s * 1e9) as u64, &mut commands);
            assert_eq!(commands[0][0], Counts::ATMOSPHERE, "the other channels keep their command");
            (SCALE.kpa(commands[0][1]), status)
        };
        times_s.iter().map(at).collect()
    }

    fn near(played: &[(f64, SourceStatus)], expected: &[f64]) {
        for ((kpa, _), expected) in played.iter().zip(expected) {
            assert!((kpa - expected).abs() <= SCALE.kpa_per_count() / 2.0, "{kpa}, expected {expected}");
        }
    }

    #[test]
    fn holding_gives_steps() {
        near(&play(Interpolation::Hold, &[0.0, 0.9, 1.0, 2.9, 3.0]), &[0.0, 0.0, 100.0, 100.0, 50.0]);
    }

    #[test]
    fn lines_pass_through_the_rows() {
        near(&play(Interpolation::Linear, &[0.0, 0.5, 1.0, 2.0, 3.0]), &[0.0, 50.0, 100.0, 75.0, 50.0]);
    }

    #[test]
    fn the_last_row_is_commanded_and_then_the_run_ends() {
        let played = play(Interpolation::Hold, &[2.999, 3.001]);
        assert_eq!([played[0].1, played[1].1], [SourceStatus::Continues, SourceStatus::Ended]);
        near(&played[1..], &[50.0]);
    }

    /// Nothing is commanded early: 5 s is 5 s.
    #[test]
    fn before_its_first_row_a_trajectory_commands_nothing() {
        let text = "t_s,b0_cmd1_kpa\n5,100\n6,50\n";
        let trajectory = || Trajectory::parse("late.csv", text.as_bytes(), 1, SCALE).unwrap();
        assert_eq!(trajectory().first_row_s(), 5.0);
        let command = |trajectory: Trajectory, interpolation, at_s: f64| {
            let others = vec![[SCALE.counts(20.0).unwrap(); 4]];
            let mut source = trajectory.play(interpolation, AtEnd::Stop, SCALE, others);
            let mut commands = [VENTED];
            let status = source.fill((at_s * 1e9) as u64, &mut commands);
            (SCALE.kpa(commands[0][1]).round(), status)
        };
        for interpolation in [Interpolation::Hold, Interpolation::Linear] {
            assert_eq!(command(trajectory(), interpolation, 0.0), (20.0, SourceStatus::Continues));
            assert_eq!(command(trajectory(), interpolation, 4.999), (20.0, SourceStatus::Continues));
            assert_eq!(command(trajectory(), interpolation, 5.0), (100.0, SourceStatus::Continues));
        }
        let at_once = trajectory().from_first_row();
        assert_eq!((at_once.first_row_s(), at_once.seconds()), (0.0, 1.0));
        assert_eq!(command(at_once, Interpolation::Hold, 0.0), (100.0, SourceStatus::Continues));
    }

    #[test]
    fn a_repeated_trajectory_begins_anew_with_its_first_row() {
        let text = "t_s,b0_cmd1_kpa\n1,0\n2,100\n4,50\n";
        let trajectory = Trajectory::parse("f.csv", text.as_bytes(), 1, SCALE).unwrap();
        assert_eq!(trajectory.clone().with_speed(2.0).seconds(), 2.0);
        let mut source = trajectory.play(Interpolation::Hold, AtEnd::Repeat, SCALE, vec![VENTED]);
        let mut at = |s: f64| {
            let mut commands = [VENTED];
            assert_eq!(source.fill((s * 1e9) as u64, &mut commands), SourceStatus::Continues);
            SCALE.kpa(commands[0][1]).round()
        };
        // From 1 to 4 s, then the same again from 4 to 7 s.
        let played: Vec<f64> = [1.5, 2.5, 3.9, 4.0, 4.9, 5.1, 6.9, 7.1, 8.1, 400.5].map(&mut at).into();
        assert_eq!(played, [0.0, 100.0, 100.0, 0.0, 0.0, 100.0, 100.0, 0.0, 100.0, 0.0]);
    }

    /// A slow bus that misses rows altogether goes on with the right one.
    #[test]
    fn rows_can_be_missed() {
        near(&play(Interpolation::Linear, &[0.0, 2.0]), &[0.0, 75.0]);
    }
}
