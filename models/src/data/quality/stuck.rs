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
/// A chamber that is empty or full really rests: at the ends of the recording's range the drive or command must push
/// away from the end for this share of the run.
const PUSHED_AWAY: f64 = 0.5;

/// What the valve was told, for the judgement whether the pressure should have moved.
pub(crate) struct Told<'a> {
    pub command_kpa: Option<&'a [f32]>,
    pub drive: Option<&'a Drive>,
}

/// Marks runs of exact repeats during which the channel was told to move.
pub(crate) fn mark_stuck(
    id: ChannelId,
    time_s: &[f64],
    line: &[u32],
    values: &[f32],
    told: &Told<'_>,
    flags: &mut [Flags],
) -> Option<Finding> {
    let (low, high) = range_of(values);
    let mut spans: Vec<Span> = Vec::new();
    let mut count = 0;
    for run in equal_runs(values) {
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
        if !told.should_have_moved(&run, value, high - low, end) {
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

impl Told<'_> {
    fn should_have_moved(&self, run: &Range<usize>, value: f32, range_kpa: f32, end: Option<End>) -> bool {
        let moved = |column: &[f32]| {
            let (low, high) = range_of(&column[run.clone()]);
            high - low
        };
        let share = |hit: &mut dyn FnMut(usize) -> bool| {
            run.clone().filter(|row| hit(*row)).count() as f64 / run.len() as f64
        };
        // The drive says more than the command, where there is one.
        match (self.drive, self.command_kpa) {
            (Some(drive), _) => {
                let (moved, push) = match drive {
                    Drive::Spool(u) => (moved(u), Box::new(|row: usize| u[row]) as Box<dyn Fn(usize) -> f32>),
                    Drive::Separate { fill, vent } => {
                        let push = |row: usize| fill[row] - vent[row];
                        (moved(fill).max(moved(vent)), Box::new(push) as Box<dyn Fn(usize) -> f32>)
                    }
                };
                moved >= DRIVE_MOVED
                    && match end {
                        None => true,
                        Some(End::Low) => share(&mut |row| push(row) > DRIVE_MOVED) >= PUSHED_AWAY,
                        Some(End::High) => share(&mut |row| push(row) < -DRIVE_MOVED) >= PUSHED_AWAY,
                    }
            }
            (None, Some(command)) => {
                // A channel that never moved at all has no range of its own: the command's stands in.
                let scale = if range_kpa > 0.0 { range_kpa } else { moved(command) };
                let far = COMMAND_MOVED * scale;
                far > 0.0
                    && moved(command) >= far
                    && match end {
                        None => true,
                        Some(End::Low) => share(&mut |row| command[row] - value > far) >= PUSHED_AWAY,
                        Some(End::High) => share(&mut |row| value - command[row] > far) >= PUSHED_AWAY,
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
