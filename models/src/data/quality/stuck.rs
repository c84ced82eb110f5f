//! A sensor that repeats one value exactly while the valve is told to move the pressure.

use std::ops::Range;

use super::finding::{Finding, FindingKind, Span, counted, rows_text};
use crate::data::{ChannelId, Drive, Flags};

/// Shortest run of equal samples that can be a stuck sensor: longer than a stale sample or two on the bus.
const LEAST_SAMPLES: usize = 20;
/// Shortest duration of such a run, s: longer than dead time and lag of a slow valve and a long tube.
const LEAST_S: f64 = 0.5;
/// The drive (full range 2) must have moved by this much during the run.
const DRIVE_MOVED: f32 = 0.3;
/// The command must have moved by this share of the channel's own pressure range.
const COMMAND_MOVED: f32 = 0.1;
/// And by so many of the sensor's steps: a valve with overlap leaves an error of a few in peace.
const COMMAND_MOVED_STEPS: f32 = 8.0;
/// A chamber that is empty or full really rests: at the ends of the recording's range the drive or command must push
/// away from the end for this share of the run.
const PUSHED_AWAY: f64 = 0.5;

/// What the valve was told, for the judgement whether the pressure should have moved.
pub(crate) struct Told<'a> {
    pub command_kpa: Option<&'a [f32]>,
    pub drive: Option<&'a Drive>,
}

/// Marks runs of exact repeats that go on although the channel was told to move.
///
/// A pressure that is held repeats one count exactly, for seconds where there is little noise, and up to the first samples after
/// the next step of the set point, which the chamber cannot have followed yet. So a run is no evidence before the channel has had
/// [`LEAST_S`] to follow what it was told.
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
    /// `followed`: the rows of the run that the pressure had the time to follow before the run ended.
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
        // Either it moved in time, or it pushed all the while: then it may have moved at the end only.
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
                // A channel that never moved at all has no range of its own: the command's stands in.
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

/// The smallest difference between two readings, which is the sensor's resolution where it is coarse enough to repeat itself.
fn step_of(values: &[f32]) -> f32 {
    let mut sorted: Vec<f32> = values.iter().copied().filter(|value| !value.is_nan()).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    sorted.dedup();
    let smallest = sorted.windows(2).map(|pair| pair[1] - pair[0]).fold(f32::INFINITY, f32::min);
    if smallest.is_finite() { smallest } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ID: ChannelId = ChannelId { board: 0, channel: 0 };

    /// 10 s at 100 Hz: a sine of pressure and a drive that leads it.
    fn wave() -> (Vec<f64>, Vec<u32>, Vec<f32>, Vec<f32>) {
        let time: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let line: Vec<u32> = (2..1002).collect();
        let pressure = time.iter().map(|t| (100.0 + 50.0 * t.sin()) as f32).collect();
        let drive = time.iter().map(|t| t.cos() as f32).collect();
        (time, line, pressure, drive)
    }

    #[test]
    fn a_frozen_reading_is_masked() {
        let (time, line, mut pressure, drive) = wave();
        let value = pressure[300];
        pressure[300..400].fill(value);
        let drive = Drive::Spool(drive);
        let told = Told { command_kpa: None, drive: Some(&drive) };
        let mut flags = vec![Flags::NONE; 1000];
        let finding = mark_stuck(ID, &time, &line, &pressure, &told, &mut flags).expect("it is stuck");
        assert_eq!(finding.count, 100);
        assert!(flags[300..400].iter().all(|f| f.contains(Flags::STUCK)));
        assert!(!flags[299].contains(Flags::STUCK) && !flags[400].contains(Flags::STUCK));
    }

    #[test]
    fn a_chamber_at_rest_is_not_stuck() {
        let (time, line, mut pressure, _) = wave();
        pressure.fill(120.0);
        let told = Told { command_kpa: Some(&vec![120.0; 1000]), drive: None };
        let mut flags = vec![Flags::NONE; 1000];
        assert_eq!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags), None);
    }

    const COUNT_KPA: f64 = 0.841_645;

    /// Time, lines, pressure, command, drive.
    type Staircase = (Vec<f64>, Vec<u32>, Vec<f32>, Vec<f32>, Vec<f32>);

    /// 24 s at 100 Hz of a loop that holds levels two counts low, behind 20 ms of dead time and a lag of 50 ms, without noise.
    /// The pressure is in whole counts.
    fn staircase(levels_kpa: [f64; 8]) -> Staircase {
        let time: Vec<f64> = (0..2400).map(|k| 0.01 * f64::from(k)).collect();
        let command: Vec<f64> = (0..2400).map(|k| levels_kpa[k / 300]).collect();
        let (mut kpa, mut pressure, mut drive) = (levels_kpa[0] - 2.0 * COUNT_KPA, Vec::new(), Vec::new());
        for row in 0..2400_usize {
            kpa += (command[row.saturating_sub(2)] - 2.0 * COUNT_KPA - kpa) * 0.01 / 0.05;
            let reading = (kpa / COUNT_KPA).round() * COUNT_KPA;
            pressure.push(reading as f32);
            drive.push(((command[row] - reading) / COUNT_KPA / 40.0).clamp(-1.0, 1.0) as f32);
        }
        (time, (2..2402).collect(), pressure, command.iter().map(|kpa| *kpa as f32).collect(), drive)
    }

    /// Holds are constant, and the first samples after the next step still are.
    #[test]
    fn holds_between_steps_are_not_stuck() {
        let (time, line, pressure, command, drive) =
            staircase([100.0, 200.0, 100.0, 150.0, 120.0, 180.0, 60.0, 100.0]);
        let holding = equal_runs(&pressure).iter().map(Range::len).sum::<usize>();
        assert!(holding > 2000, "{holding} of 2400 rows are exact repeats");
        let drive = Drive::Spool(drive);
        for told in [
            Told { command_kpa: Some(&command), drive: None },
            Told { command_kpa: Some(&command), drive: Some(&drive) },
        ] {
            let mut flags = vec![Flags::NONE; 2400];
            assert_eq!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags), None);
            assert!(flags.iter().all(|flag| *flag == Flags::NONE));
        }
    }

    /// The same, but from 7 s on nothing changes any more: the hold that was under way, and what should have followed.
    #[test]
    fn a_sensor_that_freezes_in_a_hold_is_stuck() {
        let (time, line, mut pressure, command, drive) =
            staircase([100.0, 200.0, 100.0, 150.0, 120.0, 180.0, 60.0, 100.0]);
        let value = pressure[700];
        pressure[700..1600].fill(value);
        let drive = Drive::Spool(drive);
        for told in [
            Told { command_kpa: Some(&command), drive: None },
            Told { command_kpa: Some(&command), drive: Some(&drive) },
        ] {
            let mut flags = vec![Flags::NONE; 2400];
            mark_stuck(ID, &time, &line, &pressure, &told, &mut flags).expect("it is stuck");
            assert!(flags[700..1600].iter().all(|flag| flag.contains(Flags::STUCK)));
            assert!(flags[1600..].iter().all(|flag| *flag == Flags::NONE));
        }
    }

    /// Valves have overlap: a set point that moves by less than a few counts need not move anything.
    #[test]
    fn small_signals_within_a_valves_overlap_are_not_stuck() {
        let (time, line, mut pressure, _, _) = staircase([100.0; 8]);
        pressure[0] += COUNT_KPA as f32;
        let command: Vec<f32> = time.iter().map(|t_s| (100.0 + 1.5 * t_s.sin()) as f32).collect();
        let told = Told { command_kpa: Some(&command), drive: None };
        let mut flags = vec![Flags::NONE; 2400];
        assert_eq!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags), None);
    }

    #[test]
    fn an_empty_chamber_that_is_vented_is_not_stuck_but_one_that_is_filled_is() {
        let (time, line, mut pressure, _) = wave();
        pressure[..500].fill(0.0);
        let venting: Vec<f32> = (0..1000).map(|k| if k % 100 < 50 { -1.0 } else { -0.2 }).collect();
        let mut flags = vec![Flags::NONE; 1000];
        let drive = Drive::Spool(venting.clone());
        let told = Told { command_kpa: None, drive: Some(&drive) };
        assert_eq!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags), None);
        let drive = Drive::Spool(venting.iter().map(|u| -u).collect());
        let told = Told { command_kpa: None, drive: Some(&drive) };
        assert!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags).is_some());
    }

    #[test]
    fn a_sensor_that_never_moves_is_stuck() {
        let (time, line, mut pressure, drive) = wave();
        pressure.fill(33.0);
        let command: Vec<f32> = drive.iter().map(|u| 100.0 * u).collect();
        let told = Told { command_kpa: Some(&command), drive: None };
        let mut flags = vec![Flags::NONE; 1000];
        assert_eq!(mark_stuck(ID, &time, &line, &pressure, &told, &mut flags).map(|f| f.count), Some(1000));
    }
}
