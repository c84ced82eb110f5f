//! Rows to steps: of a fast recording several rows are one step.

use super::sample::{Reading, Sample};

/// A step is at least so long, s: less a little, since rows are not quite evenly spaced.
const STEP_S: f64 = 0.0095;
/// A command that changes by more begins a new step where the board's loop is simulated, kPa: it
/// acts at once.
const JUMP_KPA: f64 = 2.0;
/// Rows in a row without an input, through which the last one is taken to hold.
const HELD_ROWS: u32 = 5;
/// Time between two rows beyond which something is missing: in usual times between rows, and s.
const GAP_PERIODS: f64 = 6.0;
const GAP_S: f64 = 0.03;

/// Mean inputs over a step, and what was measured at its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Bin {
    /// Its start, s.
    pub t_s: f64,
    /// Its length, s.
    pub length_s: f64,
    /// Nothing is known of what was before it.
    pub fresh: bool,
    /// Mean supply pressure, kPa gauge; not a number where it is not recorded.
    pub supply_kpa: f64,
    /// Mean inputs of each channel.
    pub inputs: Vec<Reading>,
    /// Readings at its start.
    pub start: Vec<Reading>,
    /// Readings at its end.
    pub end: Vec<Reading>,
}

/// Puts rows together.
#[derive(Clone)]
pub struct Binning {
    /// Which channels follow a simulated loop of a board.
    in_loop: Vec<bool>,
    /// First row of the step.
    first: Option<Sample>,
    last: Sample,
    /// Time integrals since the first row.
    sums: Vec<Reading>,
    supply_sum: f64,
    missing: Vec<u32>,
    fresh: bool,
    period_s: f64,
}

impl Binning {
    /// Of channels of which some follow a simulated loop.
    pub fn new(in_loop: Vec<bool>) -> Self {
        let channels = in_loop.len();
        Self {
            in_loop,
            first: None,
            last: Sample::default(),
            sums: vec![nothing(); channels],
            supply_sum: 0.0,
            missing: vec![0; channels],
            fresh: true,
            period_s: f64::INFINITY,
        }
    }

    /// Takes a row; returns the step that ends with it, if one does.
    pub fn take(&mut self, mut row: Sample) -> Option<Bin> {
        self.hold(&mut row);
        let lasted = row.t_s - self.last.t_s;
        let has_gap = lasted > GAP_S.max(GAP_PERIODS * self.period_s);
        let Some(first) = self.first.as_ref().filter(|_| lasted > 0.0 && !has_gap) else {
            if !(lasted <= 0.0 && self.first.is_some()) {
                self.begin(row, true);
            }
            return None;
        };
        self.period_s =
            if self.period_s.is_finite() { self.period_s + 0.01 * (lasted - self.period_s) } else { lasted };
        for (sum, reading) in self.sums.iter_mut().zip(&self.last.channels) {
            sum.command_kpa += lasted * reading.command_kpa;
            sum.drive += lasted * reading.drive;
            sum.vent += lasted * reading.vent;
            sum.angle_rad += lasted * reading.angle_rad;
        }
        self.supply_sum += lasted * self.last.supply_kpa;
        let length_s = row.t_s - first.t_s;
        let jumps = self.in_loop.iter().zip(row.channels.iter().zip(&self.last.channels)).any(
            |(in_loop, (now, before))| *in_loop && (now.command_kpa - before.command_kpa).abs() > JUMP_KPA,
        );
        if length_s < STEP_S && !jumps {
            self.last = row;
            return None;
        }
        let share = length_s.recip();
        let mean = |sum: &Reading| Reading {
            pressure_kpa: f64::NAN,
            command_kpa: share * sum.command_kpa,
            drive: share * sum.drive,
            vent: share * sum.vent,
            angle_rad: share * sum.angle_rad,
        };
        let bin = Bin {
            t_s: first.t_s,
            length_s,
            fresh: self.fresh,
            supply_kpa: share * self.supply_sum,
            inputs: self.sums.iter().map(mean).collect(),
            start: first.channels.clone(),
            end: row.channels.clone(),
        };
        self.begin(row, false);
        Some(bin)
    }

    fn begin(&mut self, row: Sample, fresh: bool) {
        self.fresh = fresh;
        self.sums.fill(nothing());
        self.supply_sum = 0.0;
        self.last = row.clone();
        self.first = Some(row);
    }

    /// An input that is missing in a few rows is what it was; pressures are not.
    fn hold(&mut self, row: &mut Sample) {
        for ((now, before), missing) in
            row.channels.iter_mut().zip(&self.last.channels).zip(&mut self.missing)
        {
            let mut any = false;
            let mut keep = |now: &mut f64, before: f64| {
                if now.is_nan() && before.is_finite() {
                    (*now, any) = (before, true);
                }
            };
            if *missing < HELD_ROWS {
                keep(&mut now.command_kpa, before.command_kpa);
                keep(&mut now.drive, before.drive);
                keep(&mut now.vent, before.vent);
                keep(&mut now.angle_rad, before.angle_rad);
            }
            *missing = if any { *missing + 1 } else { 0 };
        }
        if row.supply_kpa.is_nan() && self.last.supply_kpa.is_finite() {
            row.supply_kpa = self.last.supply_kpa;
        }
    }
}

fn nothing() -> Reading {
    Reading { pressure_kpa: f64::NAN, command_kpa: 0.0, drive: 0.0, vent: 0.0, angle_rad: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(t_s: f64, drive: f64, pressure_kpa: f64) -> Sample {
        let reading = Reading { drive, pressure_kpa, command_kpa: 0.0, ..Reading::default() };
        Sample { t_s, supply_kpa: f64::NAN, channels: vec![reading] }
    }

    #[test]
    fn ten_fast_rows_are_one_step_with_their_mean_drive() {
        let mut binning = Binning::new(vec![false]);
        let steps: Vec<Bin> = (0..=20)
            .filter_map(|k| binning.take(row(0.001 * f64::from(k), f64::from(k % 10), f64::from(k))))
            .collect();
        assert_eq!(steps.len(), 2);
        assert!(steps[0].fresh && !steps[1].fresh);
        assert!((steps[1].length_s - 0.01).abs() < 1e-9 && (steps[1].inputs[0].drive - 4.5).abs() < 1e-9);
        assert_eq!((steps[1].start[0].pressure_kpa, steps[1].end[0].pressure_kpa), (10.0, 20.0));
    }

    #[test]
    fn after_missing_time_everything_begins_again() {
        let mut binning = Binning::new(vec![false]);
        let mut steps = Vec::new();
        for t_s in [0.0, 0.01, 0.02, 0.5, 0.51, 0.52] {
            steps.extend(binning.take(row(t_s, 0.0, 0.0)));
        }
        let told: Vec<(f64, bool)> = steps.iter().map(|s| (s.t_s, s.fresh)).collect();
        assert_eq!(told, [(0.0, true), (0.01, false), (0.5, true), (0.51, false)]);
    }

    #[test]
    fn a_drive_is_held_through_five_rows_and_no_more() {
        let mut binning = Binning::new(vec![false]);
        let mut means = Vec::new();
        for k in 0..9 {
            let drive = if k == 0 { 0.3 } else { f64::NAN };
            means.extend(binning.take(row(0.01 * f64::from(k), drive, 0.0)).map(|s| s.inputs[0].drive));
        }
        assert_eq!(means.iter().filter(|d| (**d - 0.3).abs() < 1e-12).count(), 6);
        assert!(means[6].is_nan());
    }

    #[test]
    fn a_command_that_jumps_ends_a_step_of_a_simulated_loop() {
        let ends = |in_loop| {
            let mut binning = Binning::new(vec![in_loop]);
            (0..=20)
                .filter_map(|k| {
                    let mut row = row(0.001 * f64::from(k), 0.0, 0.0);
                    row.channels[0].command_kpa = if k < 4 { 0.0 } else { 100.0 };
                    binning.take(row).map(|step| (1e3 * (step.t_s + step.length_s)).round())
                })
                .collect::<Vec<f64>>()
        };
        assert_eq!(ends(false), [10.0, 20.0]);
        assert_eq!(ends(true), [4.0, 14.0]);
    }
}
