//! The few rows of inputs that a step can see, in place of a recording's.

use std::sync::Arc;

use crate::effects::{ChannelInputs, DriveInput, Series};

/// The row whose interval is simulated.
pub const NOW: usize = 1;
/// The row at its end.
pub const NEXT: usize = 2;
const ROWS: usize = 4;

/// Inputs of one step of one channel. Pressures are absolute and in Pa where nothing else is said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepInputs {
    /// Start of the step, s.
    pub t_s: f64,
    /// Length of the step, s.
    pub length_s: f64,
    /// Mean drives: of the spool (or the fill valve) and of the vent valve.
    pub drive: [f64; 2],
    /// Command.
    pub command_pa: f64,
    /// Supply.
    pub supply_pa: f64,
    /// Mean volume, m^3.
    pub volume_m3: f64,
    /// Its rate, m^3/s.
    pub volume_rate_m3_s: f64,
    /// Measured pressure at the start and at the end.
    pub measured_pa: [f64; 2],
    /// Gauge pressure of the chamber opposite at the start and at the end; not a number where it is
    /// not known.
    pub opposite_pa: [f64; 2],
    /// The same of the channel sampled before.
    pub sampled_before_pa: [f64; 2],
    /// Flow that the other channels draw, mm^2 Pa.
    pub others_draw: f64,
}

/// Inputs as a simulation takes them.
#[derive(Clone)]
pub struct Window {
    /// The rows.
    pub inputs: ChannelInputs,
    fresh: Arc<[usize]>,
    running: Arc<[usize]>,
}

impl Window {
    /// Of a channel that is simulated with these inputs otherwise.
    pub fn new(template: &ChannelInputs) -> Self {
        let every = |value: f64| -> Series { vec![value; ROWS].into() };
        let drive = match &template.drive {
            DriveInput::Spool(_) => DriveInput::Spool(every(0.0)),
            DriveInput::Separate { .. } => DriveInput::Separate { fill: every(0.0), vent: every(0.0) },
            other => other.clone(),
        };
        Self {
            inputs: ChannelInputs {
                time_s: every(0.0),
                interval_s: every(0.01),
                duration_s: f64::INFINITY,
                starts: Arc::from([0]),
                anchors: Arc::from([]),
                drive,
                command_pa: every(template.ambient_pa),
                supply_pa: every(template.supply_pa[0]),
                volume_m3: every(template.volume_m3[0]),
                volume_rate_m3_s: every(0.0),
                measured_pa: every(template.ambient_pa),
                usable: vec![true; ROWS].into(),
                opposite_pa: Series::default(),
                sampled_before_pa: Series::default(),
                neighbour_drive: Series::default(),
                others_draw: every(0.0),
                noise_pa: template.noise_pa,
                ambient_pa: template.ambient_pa,
            },
            fresh: Arc::from([0, NOW]),
            running: Arc::from([0]),
        }
    }

    /// The command of the step before acts until the first loop of the next: keeps it.
    pub fn end_step(&mut self) {
        let commands = Arc::make_mut(&mut self.inputs.command_pa);
        commands[NOW - 1] = commands[NOW];
        let measured = Arc::make_mut(&mut self.inputs.measured_pa);
        measured[NOW - 1] = measured[NOW];
    }

    /// Takes the inputs of a step; `fresh` where nothing is known of what was before.
    pub fn set(&mut self, step: &StepInputs, fresh: bool) {
        let now = |series: &mut Series, value: f64| Arc::make_mut(series)[NOW] = value;
        let inputs = &mut self.inputs;
        inputs.starts = Arc::clone(if fresh { &self.fresh } else { &self.running });
        now(&mut inputs.time_s, step.t_s);
        Arc::make_mut(&mut inputs.time_s)[NEXT] = step.t_s + step.length_s;
        now(&mut inputs.interval_s, step.length_s);
        match &mut inputs.drive {
            DriveInput::Spool(u) => now(u, step.drive[0]),
            DriveInput::Separate { fill, vent } => {
                now(fill, step.drive[0]);
                now(vent, step.drive[1]);
            }
            DriveInput::Controlled | DriveInput::Command => {}
        }
        now(&mut inputs.command_pa, step.command_pa);
        now(&mut inputs.supply_pa, step.supply_pa);
        now(&mut inputs.volume_m3, step.volume_m3);
        now(&mut inputs.volume_rate_m3_s, step.volume_rate_m3_s);
        now(&mut inputs.others_draw, step.others_draw);
        let measured = Arc::make_mut(&mut inputs.measured_pa);
        [measured[NOW], measured[NEXT]] = step.measured_pa;
        // Whether it repeats is not known yet: another one.
        measured[NEXT + 1] = step.measured_pa[1] + 1.0;
        know(&mut inputs.opposite_pa, step.opposite_pa);
        know(&mut inputs.sampled_before_pa, step.sampled_before_pa);
    }
}

/// Puts what is known at the start and the end of a step in its place, or nothing.
fn know(series: &mut Series, [start, end]: [f64; 2]) {
    if !(start.is_finite() && end.is_finite()) {
        if !series.is_empty() {
            *series = Series::default();
        }
        return;
    }
    if series.is_empty() {
        *series = vec![start; ROWS].into();
    }
    let rows = Arc::make_mut(series);
    (rows[NOW], rows[NEXT]) = (start, end);
}
