//! The arguments of `PressureController.poll`.

use crate::errors::CommandError;
use pneudrive_host::poller::{LineRatePolicy, Pace, PageShare};
use pyo3::prelude::*;
use std::time::Duration;

/// What a poller is asked to do.
pub struct PollerSettings {
    /// Boards 0 to this, exclusive.
    pub devices: u16,
    /// How often.
    pub pace: Pace,
    /// How much of the past is kept, s.
    pub history_s: f64,
    /// Whether to ask the boards for a faster line rate.
    pub line_rate: Option<LineRatePolicy>,
    /// After which share of the polls boards are asked for their sensors.
    pub sensors: Option<PageShare>,
}

impl PollerSettings {
    const RATE_MAX_HZ: f64 = 100_000.0;
    const HISTORY_MAX_S: f64 = 3600.0;

    /// Checks the arguments of `PressureController.poll`.
    pub fn new(devices: u16, rate_hz: Option<f64>, history_s: f64) -> PyResult<Self> {
        let pace = match rate_hz {
            None => Pace::AsFastAsPossible,
            Some(rate) if rate > 0.0 && rate <= Self::RATE_MAX_HZ => {
                Pace::every(Duration::from_nanos((1e9 / rate).round() as u64))
            }
            Some(rate) => {
                let max = Self::RATE_MAX_HZ;
                return Err(CommandError::new_err(format!(
                    "rate_hz is {rate}; it must be above 0 and at most {max} Hz; without it boards are polled as fast as the wire allows"
                )));
            }
        };
        if !(0.0..=Self::HISTORY_MAX_S).contains(&history_s) {
            let max = Self::HISTORY_MAX_S;
            return Err(CommandError::new_err(format!("history_s is {history_s}; it must be 0 to {max} s")));
        }
        Ok(Self { devices, pace, history_s, line_rate: None, sensors: None })
    }
}
