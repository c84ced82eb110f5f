//! The few rows of inputs that a step can see: the one before it, its own, and two after.

use std::sync::Arc;

use pneudrive_model::effects::{ChannelInputs, DriveInput, Series};

use crate::inputs::{Inputs, REPEATS_AFTER, REPEATS_END, REPEATS_START};

/// The row whose interval is simulated.
pub const NOW: usize = 1;
/// The row at its end.
pub const NEXT: usize = 2;
/// Rows there are.
pub const ROWS: usize = 4;

const PA_PER_KPA: f64 = 1e3;

/// Inputs of a step, in place of a recording's.
pub struct Window {
    /// As the simulation takes them.
    pub inputs: ChannelInputs,
    /// What is known of the neighbours, or nothing; the other of the two is in `inputs`.
    opposite: Series,
    sampled_before: Series,
    fresh: Arc<[usize]>,
    running: Arc<[usize]>,
    step_s: f64,
}

impl Window {
    /// Of a channel that is simulated with these inputs otherwise.
    pub fn new(template: &ChannelInputs, step_s: f64) -> Self {
        let rows = || -> Series { vec![0.0; ROWS].into() };
        let drive = match &template.drive {
            DriveInput::Spool(_) => DriveInput::Spool(rows()),
            DriveInput::Separate { .. } => DriveInput::Separate { fill: rows(), vent: rows() },
            other => other.clone(),
        };
        let every = |value: f64| -> Series { vec![value; ROWS].into() };
        Self {
            inputs: ChannelInputs {
                time_s: rows(),
                interval_s: every(step_s),
                duration_s: f64::INFINITY,
                starts: Arc::from([0]),
                anchors: Arc::from([]),
                drive,
                command_pa: every(template.ambient_pa),
                supply_pa: every(template.ambient_pa),
                volume_m3: every(1e-4),
                volume_rate_m3_s: rows(),
                measured_pa: every(template.ambient_pa),
                usable: vec![true; ROWS].into(),
                opposite_pa: Series::default(),
                sampled_before_pa: Series::default(),
                neighbour_drive: Series::default(),
                others_draw: rows(),
                noise_pa: template.noise_pa,
                ambient_pa: template.ambient_pa,
            },
            opposite: rows(),
            sampled_before: rows(),
            fresh: Arc::from([0, NOW]),
            running: Arc::from([0]),
            step_s,
        }
    }

    /// Is the channel in front of its first step?
    pub fn set_fresh(&mut self, fresh: bool) {
        self.inputs.starts = Arc::clone(if fresh { &self.fresh } else { &self.running });
    }

    /// The pressure that the channel begins at, gauge.
    pub fn set_start(&mut self, kpa: f64) {
        let pa = self.inputs.ambient_pa + PA_PER_KPA * kpa;
        Arc::make_mut(&mut self.inputs.measured_pa)[NOW] = pa;
        // Another one: nothing repeats before the first step.
        Arc::make_mut(&mut self.inputs.measured_pa)[0] = pa - 1.0;
    }

    /// The set point of the step before, kPa gauge.
    pub fn set_point_before(&self) -> f64 {
        (self.inputs.command_pa[0] - self.inputs.ambient_pa) / PA_PER_KPA
    }

    /// Sets it.
    pub fn set_point_was(&mut self, kpa: f64) {
        Arc::make_mut(&mut self.inputs.command_pa)[0] = self.inputs.ambient_pa + PA_PER_KPA * kpa;
    }

    /// Takes the inputs of a step that begins at `time_s`.
    pub fn set(&mut self, time_s: f64, given: &Inputs) {
        let ambient_pa = self.inputs.ambient_pa;
        let absolute = |kpa: f64| ambient_pa + PA_PER_KPA * kpa;
        let now = |series: &mut Series, value: f64| Arc::make_mut(series)[NOW] = value;
        let inputs = &mut self.inputs;
        now(&mut inputs.time_s, time_s);
        Arc::make_mut(&mut inputs.time_s)[NEXT] = time_s + self.step_s;
        match &mut inputs.drive {
            DriveInput::Spool(u) => now(u, given.fill),
            DriveInput::Separate { fill, vent } => {
                now(fill, given.fill);
                now(vent, given.vent);
            }
            DriveInput::Controlled | DriveInput::Command => {}
        }
        now(&mut inputs.command_pa, absolute(given.set_point_kpa));
        now(&mut inputs.supply_pa, absolute(given.supply_kpa));
        now(&mut inputs.volume_m3, given.volume_m3);
        now(&mut inputs.volume_rate_m3_s, given.volume_rate_m3_s);
        now(&mut inputs.others_draw, given.others_draw);
        know(&mut inputs.opposite_pa, &mut self.opposite, given.opposite_kpa);
        know(&mut inputs.sampled_before_pa, &mut self.sampled_before, given.sampled_before_kpa);
        // The effect asks whether measured samples are equal.
        let measured = Arc::make_mut(&mut inputs.measured_pa);
        for (row, bit) in [(NOW, REPEATS_START), (NEXT, REPEATS_END), (NEXT + 1, REPEATS_AFTER)] {
            measured[row] = measured[row - 1] + if given.repeats & bit == 0 { 1.0 } else { 0.0 };
        }
    }
}

/// Puts what is known at the start and the end of a step (kPa) in its place, or nothing.
fn know(series: &mut Series, spare: &mut Series, [start, end]: [f64; 2]) {
    let known = start.is_finite() && end.is_finite();
    if known == series.is_empty() {
        std::mem::swap(series, spare);
    }
    if known {
        let rows = Arc::make_mut(series);
        (rows[NOW], rows[NEXT]) = (PA_PER_KPA * start, PA_PER_KPA * end);
    }
}
