//! What may be commanded: highest set points everywhere, and by hand the fastest changes too. A
//! poller ramps by itself.

use crate::errors::{self, CommandError};
use parking_lot::Mutex;
use pneudrive_host::Calibration;
use pneudrive_host::poller::{BoardCommand, ChannelLimit, Limits, VENTED};
use pneudrive_host::rig::{self, Rig, RigError};
use pyo3::prelude::*;
use std::path::Path;
use std::time::Instant;

/// The most time that one step of a ramp makes up for, s: a pause is no reason to jump. As in the
/// poller's ramps.
const LONGEST_STEP_S: f64 = 0.05;

/// What set points are held to.
#[derive(Debug, Clone)]
pub struct Rules {
    /// Highest set points and fastest changes.
    pub limits: Limits,
    /// What counts mean.
    pub calibration: Calibration,
    /// Boards of the bus.
    pub boards: Vec<u8>,
}

/// Reads a rig file.
///
/// # Errors
/// `DataError` or `FileError` for a file that cannot be used.
pub fn load(path: &Path) -> PyResult<Rig> {
    Rig::load(path).map_err(|error| match error {
        RigError::Open { .. } => errors::FileError::new_err(error.to_string()),
        other => errors::unusable(other),
    })
}

/// What the arguments of `PressureController` mean: of several limits, the strictest holds.
///
/// # Errors
/// `CommandError` for numbers that make no sense, `DataError` for a calibration that no board has.
pub fn rules(
    max_kpa: Option<f64>,
    max_rate_kpa_s: Option<f64>,
    rig: Option<&Rig>,
    devices: u16,
) -> PyResult<Rules> {
    let calibration = rig.map_or(Ok(Calibration::default()), rig::calibration).map_err(errors::unusable)?;
    let limits = rig.map_or(Ok(Limits::default()), rig::limits).map_err(errors::unusable)?;
    let own = ChannelLimit {
        max_kpa: max_kpa.unwrap_or(f64::INFINITY),
        max_rate_kpa_s: max_rate_kpa_s.unwrap_or(f64::INFINITY),
    };
    let limits = limits
        .and(own)
        .map_err(|error| CommandError::new_err(format!("max_kpa, max_rate_kpa_s: {error}")))?;
    Ok(Rules { limits, calibration, boards: (0..=u8::MAX).take(usize::from(devices)).collect() })
}

/// Watches how fast set points are changed by hand.
pub struct RateGuard {
    rules: Rules,
    /// What each board was sent last, and when; `None` before.
    sent: Mutex<Vec<Option<(BoardCommand, Instant)>>>,
}

impl RateGuard {
    /// For so many boards, all at 0 kPa.
    pub fn new(rules: Rules, devices: u16) -> Self {
        Self { rules, sent: Mutex::new(vec![None; usize::from(devices)]) }
    }

    /// Limits and calibration.
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// Remembers what is sent to `board`, unless [`check`](Self::check) refuses it.
    ///
    /// # Errors
    /// As there.
    pub fn send(&self, board: u8, command: BoardCommand) -> Result<(), String> {
        self.check(board, command)?;
        if let Some(last) = self.sent.lock().get_mut(usize::from(board)) {
            *last = Some((command, Instant::now()));
        }
        Ok(())
    }

    /// Whether `command` changes the set points of `board` no faster than allowed. Venting may be
    /// as fast as it likes.
    ///
    /// # Errors
    /// Why not.
    pub fn check(&self, board: u8, command: BoardCommand) -> Result<(), String> {
        let last = self.sent.lock().get(usize::from(board)).copied().flatten();
        let (before, since_s) = match last {
            Some((before, at)) => (before, at.elapsed().as_secs_f64().min(LONGEST_STEP_S)),
            None => (VENTED, LONGEST_STEP_S),
        };
        let Rules { limits, calibration, .. } = &self.rules;
        for (channel, limit) in limits.of(board).iter().enumerate() {
            let scale = calibration.channel(board, channel);
            let (from, to) = (scale.kpa(before[channel]), scale.kpa(command[channel]));
            // Set points are rounded to counts.
            let most = limit.max_rate_kpa_s * since_s + scale.kpa_per_count();
            let vents = command[channel] <= VENTED[channel];
            if !vents && (to - from).abs() > most {
                let rate = limit.max_rate_kpa_s;
                return Err(format!(
                    "board {board}, channel {channel}: from {:.0} to {to:.0} kPa at once is faster than its limit of {rate} kPa/s; \
                     nothing was sent. poll() ramps; by hand, change it in steps",
                    scale.command_kpa(before[channel])
                ));
            }
        }
        Ok(())
    }

    /// All boards are at 0 kPa again.
    pub fn vented(&self) {
        self.sent.lock().fill(None);
    }
}
