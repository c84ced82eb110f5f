//! A sensor that repeats one value exactly while the valve is told to move the pressure.

use std::ops::Range;

use super::finding::{Finding, FindingKind, Span, counted, rows_text};
use crate::{ChannelId, Drive, Flags};

/// Shortest run of equal samples that can be a stuck sensor: longer than a stale sample or two on
/// the bus.
const LEAST_SAMPLES: usize = 20;
/// Shortest duration of such a run, s: longer than dead time and lag of a slow valve and a long
/// tube.
const LEAST_S: f64 = 0.5;
/// The drive (full range 2) must have moved by this much during the run.
const DRIVE_MOVED: f32 = 0.3;
/// The command must have moved by this share of the channel's own pressure range.
const COMMAND_MOVED: f32 = 0.1;
/// And by so many of the sensor's steps: a valve with overlap leaves an error of a few in peace.
const COMMAND_MOVED_STEPS: f32 = 8.0;
/// A chamber that is empty or full really rests: at the ends of the recording's range the drive or
/// command must push away from the end for this share of the run.
const PUSHED_AWAY: f64 = 0.5;

/// What the valve was told, for the judgement whether the pressure should have moved.
pub(crate) struct Told<'a> {
    pub command_kpa: Option<&'a [f32]>,
    pub drive: Option<&'a Drive>,
}

/// Marks runs of exact repeats that go on although the channel was told to move.
///
/// A pressure that is held repeats one count exactly, for seconds where there is little noise, and
/// up to the first samples after the next step of the set point, which the chamber cannot have
/// followed yet. So a run is no evidence before the channel has had [`LEAST_S`] to follow what it
/// was told.
pub(crate) fn mark_stuck(
    id: ChannelId,
    time_s: &[f64],
    line: &[u32],
    values: &[f32],
    told: &Told<'_>,
    flags: &mut [Flags],
) -> Option<Finding> {
    let (low, high) = range_of(values);
    let runs = equal_runs(values);
    let step_kpa = if runs.is_empty() { 0.0 } else { step_of(values) };
    let mut spans: Vec<Span> = Vec::new();
    let mut count = 0;
    for run in runs {
        let last = run.end - 1;
        if run.len() < LEAST_SAMPLES || time_s[last] - time_s[run.start] < LEAST_S {
            continue;
        }
        let value = values[run.start];
        let end = if high > low && value <= low {
            Some(End::Low)
        } else if high > low && value >= high {
            Some(End::High)
        } else {
            None
        };
        let followed = time_s[run.clone()].partition_point(|t_s| *t_s <= time_s[last] - LEAST_S);
        let followed = run.start..run.start + followed.min(run.len() - LEAST_SAMPLES);
        let scale = Scale { range_kpa: high - low, step_kpa };
        if !told.should_have_moved(&run, followed, value, scale, end) {
            continue;
        }
        count += run.len();
        spans.push(Span {
            first_row: line[run.start],
            last_row: line[last],
            from_s: time_s[run.start],
            to_s: time_s[last],
        });
        for flag in &mut flags[run] {
            flag.insert(Flags::STUCK);
        }
    }
    if count == 0 {
        return None;
    }
    let sentence = format!(
        "{}: {} exact repeats while the valve was told to move ({}): a stuck sensor or a frozen reading; nothing is compared with the simulation there.",
        id.pressure_column(),
        counted(count, "sample"),
        rows_text(&spans)
    );
    Some(Finding::new(FindingKind::StuckSensor, Some(id), count, spans, sentence))
}

#[derive(Clone, Copy)]
enum End {
    Low,
    High,
}

/// What is much for a channel.
#[derive(Clone, Copy)]
struct Scale {
    /// From its lowest to its highest reading.
    range_kpa: f32,
    /// Between two neighbouring readings; 0 if there is one only.
    step_kpa: f32,
}

impl Told<'_> {
    /// `followed`: the rows of the run that the pressure had the time to follow before the run
    /// ended.
    fn should_have_moved(
        &self,
        run: &Range<usize>,
        followed: Range<usize>,
        value: f32,
        Scale { range_kpa, step_kpa }: Scale,
        end: Option<End>,
    ) -> bool {
        let moved_in = |rows: &Range<usize>, column: &[f32]| {
            let (low, high) = range_of(&column[rows.clone()]);
            high - low
        };
        let share = |rows: &Range<usize>, hit: &dyn Fn(usize) -> bool| {
            rows.clone().filter(|row| hit(*row)).count() as f64 / rows.len().max(1) as f64
        };
        // Either it moved in time, or it pushed all the while: then it may have moved at the end
        // only.
        let was_told = |column: &[f32], much: f32, pushes: &dyn Fn(usize) -> bool| {
            moved_in(&followed, column) >= much
                || (moved_in(run, column) >= much && share(&followed, pushes) >= PUSHED_AWAY)
        };
        // The drive says more than the command, where there is one.
        match (self.drive, self.command_kpa) {
            (Some(drive), _) => {
                let push = |row: usize| match drive {
                    Drive::Spool(u) => u[row],
                    Drive::Separate { fill, vent } => fill[row] - vent[row],
                };
                let pushes = |row: usize| push(row).abs() > DRIVE_MOVED;
                let was_told = match drive {
                    Drive::Spool(u) => was_told(u, DRIVE_MOVED, &pushes),
                    Drive::Separate { fill, vent } => {
                        was_told(fill, DRIVE_MOVED, &pushes) || was_told(vent, DRIVE_MOVED, &pushes)
                    }
                };
                was_told
                    && match end {
                        None => true,
                        Some(End::Low) => share(run, &|row| push(row) > DRIVE_MOVED) >= PUSHED_AWAY,
                        Some(End::High) => share(run, &|row| push(row) < -DRIVE_MOVED) >= PUSHED_AWAY,
                    }
            }
            (None, Some(command)) => {
                // A channel that never moved at all has no range of its own: the command's stands
                // in.
                let scale = if range_kpa > 0.0 { range_kpa } else { moved_in(run, command) };
                let far = (COMMAND_MOVED * scale).max(COMMAND_MOVED_STEPS * step_kpa);
                far > 0.0
                    && was_told(command, far, &|row| (command[row] - value).abs() > far)
                    && match end {
                        None => true,
                        Some(End::Low) => share(run, &|row| command[row] - value > far) >= PUSHED_AWAY,
                        Some(End::High) => share(run, &|row| value - command[row] > far) >= PUSHED_AWAY,
                    }
            }
            (None, None) => false,
        }
    }
}

/// Maximal runs of bitwise equal, present values.
fn equal_runs(values: &[f32]) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut start = 0;
    for row in 1..=values.len() {
        // Exact repeats are the question here, not nearness.
        let ends = row == values.len() || values[row].to_bits() != values[start].to_bits();
        if ends {
            if !values[start].is_nan() && row - start >= LEAST_SAMPLES {
                runs.push(start..row);
            }
            start = row;
        }
    }
    runs
}

/// Smallest and largest present value; (0, 0) when all are missing.
fn range_of(values: &[f32]) -> (f32, f32) {
    let (low, high) = values
        .iter()
        .filter(|v| !v.is_nan())
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// The smallest difference between two readings, which is the sensor's resolution where it is
/// coarse enough to repeat itself.
fn step_of(values: &[f32]) -> f32 {
    let mut sorted: Vec<f32> = values.iter().copied().filter(|value| !value.is_nan()).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    sorted.dedup();
    let smallest = sorted.windows(2).map(|pair| pair[1] - pair[0]).fold(f32::INFINITY, f32::min);
    if smallest.is_finite() { smallest } else { 0.0 }
}

#[cfg(test)]
mod tests;
