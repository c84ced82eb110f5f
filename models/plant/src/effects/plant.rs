//! The base model a channel is simulated with, and the board's loop in front of it.

use crate::board::{Board, Law, ticks};
use crate::model::{BaseModel, Parameter, ValveDrive};

/// The board's pressure loop, in pressures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardLoop {
    /// Loops per second, Hz.
    pub rate_hz: f64,
    /// Its law, drive (-1 to 1) from pressures in Pa.
    pub law: Law,
    /// Gauge pressure of the converter's lowest and highest code, Pa.
    pub lowest_pa: f64,
    /// See `lowest_pa`.
    pub highest_pa: f64,
    /// Standard deviation of what the board rounds off where it reports, and not where it controls,
    /// Pa.
    pub rounding_pa: f64,
    /// Loops that are simulated as one, at the pressure that they see on average; at least 1.
    pub loops_per_step: usize,
    /// Number of the course that the sensor's noise takes in the loop: what it saw between the rows
    /// is not recorded.
    pub noise_draw: u64,
}

impl BoardLoop {
    /// The loop of a board, simulated loop by loop.
    #[must_use]
    pub fn new(Board { controller, sensor, .. }: &Board) -> Self {
        let pa_per_count = sensor.pa_per_count();
        let per_pa = |gain: f64| gain / controller.saturation / pa_per_count;
        Self {
            rate_hz: controller.rate_hz,
            law: Law {
                gain: per_pa(controller.kp),
                damping: per_pa(controller.kd),
                weight: controller.filter,
            },
            lowest_pa: sensor.kpa(0.0) * 1e3,
            highest_pa: sensor.kpa(sensor.full_scale_counts()) * 1e3,
            rounding_pa: pa_per_count / 12.0_f64.sqrt(),
            loops_per_step: 1,
            noise_draw: 0,
        }
    }

    /// Loops in an interval of this length (s), at least one.
    #[must_use]
    pub fn ticks(&self, interval_s: f64) -> usize {
        ticks(self.rate_hz, interval_s)
    }

    /// Steps in an interval, each of up to [`loops_per_step`](Self::loops_per_step) loops.
    #[must_use]
    pub fn steps(&self, interval_s: f64) -> usize {
        self.ticks(interval_s).div_ceil(self.loops_per_step)
    }
}

/// The base model, what drives it, and how finely it is simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// Base model.
    pub model: BaseModel,
    /// The board's loop, when it is part of the simulation.
    pub board: Option<BoardLoop>,
    /// Longest integration step, s.
    pub longest_step_s: f64,
    /// Command that counts as full scale where a command takes the place of a drive, gauge Pa.
    pub command_range_pa: f64,
}

impl Plant {
    /// Steps in an interval.
    #[must_use]
    // Rounded up and at least one.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn steps(&self, interval_s: f64) -> usize {
        (interval_s / self.longest_step_s - 1e-6).ceil().max(1.0) as usize
    }

    /// Two valves with a gain each?
    #[must_use]
    pub fn separate(&self) -> bool {
        self.model.valve().is_some_and(|valve| valve.drive == ValveDrive::Separate)
    }

    /// The base model's parameters.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        self.model.parameters()
    }

    /// Position of one of them, if the base model has it.
    #[must_use]
    pub fn position(&self, parameter: &str) -> Option<usize> {
        self.parameters().iter().position(|p| p.name == parameter)
    }
}
