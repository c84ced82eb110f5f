//! The base model a channel is simulated with, and the board's loop in front of it.

use crate::model::{FlowFunction, Gas, Linear, Model, Nonlinear, Parameter, ValveDrive};

/// Which base model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// Valve and chamber.
    Nonlinear(ValveDrive),
    /// Regulator with its own loop.
    Linear,
}

/// The board's pressure loop, in pressures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardLoop {
    /// Loops per second, Hz.
    pub rate_hz: f64,
    /// Drive per pascal of error.
    pub gain_per_pa: f64,
    /// Drive per pascal of change between two loops.
    pub damping_per_pa: f64,
    /// Weight of the previous sample, 0 to 1.
    pub filter: f64,
    /// Gauge pressure of the converter's lowest and highest code, Pa.
    pub lowest_pa: f64,
    /// See `lowest_pa`.
    pub highest_pa: f64,
    /// Standard deviation of what the board rounds off where it reports, and not where it controls, Pa.
    pub rounding_pa: f64,
    /// Loops that are simulated as one, at the pressure that they see on average; at least 1.
    pub loops_per_step: usize,
    /// Number of the course that the sensor's noise takes in the loop: what it saw between the rows is not recorded.
    pub noise_draw: u64,
}

impl BoardLoop {
    /// Loops in an interval, at least one.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // rounded and at least one
    pub fn ticks(&self, interval_s: f64) -> usize {
        (interval_s * self.rate_hz).round().max(1.0) as usize
    }

    /// Steps in an interval, each of up to [`loops_per_step`](Self::loops_per_step) loops.
    #[must_use]
    pub fn steps(&self, interval_s: f64) -> usize {
        self.ticks(interval_s).div_ceil(self.loops_per_step)
    }
}

/// The base model with what is fixed about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// Base model.
    pub kind: Kind,
    /// Air.
    pub gas: Gas,
    /// Nominal flow function of the ports.
    pub flow: FlowFunction,
    /// Nominal critical ratio.
    pub critical_ratio: f64,
    /// Discharge coefficient, fixed.
    pub discharge_coefficient: f64,
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
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // rounded up and at least one
    pub fn steps(&self, interval_s: f64) -> usize {
        (interval_s / self.longest_step_s - 1e-6).ceil().max(1.0) as usize
    }

    /// Name of the base model.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self.kind {
            Kind::Nonlinear(_) => "nonlinear",
            Kind::Linear => "linear",
        }
    }

    /// Two valves with a gain each?
    #[must_use]
    pub fn separate(&self) -> bool {
        self.kind == Kind::Nonlinear(ValveDrive::Separate)
    }

    /// The base model's parameters.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        match self.kind {
            Kind::Nonlinear(drive) => Nonlinear { drive, ..Nonlinear::default() }.parameters(),
            Kind::Linear => Linear::default().parameters(),
        }
    }

    /// Position of the weight of the volume's rate among them.
    #[must_use]
    pub fn volume_weight(&self) -> usize {
        if self.separate() { 7 } else { 6 }
    }

    /// Position of the width of the valve's corner among them.
    #[must_use]
    pub fn corner(&self) -> Option<usize> {
        (self.kind != Kind::Linear).then(|| self.volume_weight() - 1)
    }

    /// Factor from an area in mm^2 by a volume in m^3 to a rate in 1/s.
    #[must_use]
    pub fn conductance(&self) -> f64 {
        self.gas.filling_speed() * self.discharge_coefficient * 1e-6
    }
}
