//! What the arguments of `PressureController` mean, before anything is opened.

use super::baud::Baud;
use super::guard::{self, Rules};
use super::port::bus_options;
use crate::errors::{self, CommandError};
use pneudrive_host::bus::BusOptions;
use pneudrive_host::poller::LineRatePolicy;
use pneudrive_host::rig::{self, Rig};
use pneudrive_virtual::Timing;
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use std::ffi::CString;
use std::path::PathBuf;

/// The largest number of times that a board is asked again.
const MOST_RETRIES: u32 = 100;

/// The arguments, as they were given.
pub struct Given {
    pub uart_port: Option<PathBuf>,
    pub num_devices: Option<i64>,
    pub max_devices: i64,
    pub baud: Option<Baud>,
    pub timeout: Option<f64>,
    pub retries: i64,
    pub max_kpa: Option<f64>,
    pub max_rate_kpa_s: Option<f64>,
    pub rig: Option<PathBuf>,
}

/// What they mean, with what a rig file adds.
pub struct Opening {
    pub path: PathBuf,
    pub devices: u16,
    pub options: BusOptions,
    pub rules: Rules,
    pub retries: u32,
    /// Whether a poller asks the boards for a faster line rate.
    pub line_rate: Option<LineRatePolicy>,
}

impl Given {
    /// Reads the rig file and checks everything.
    ///
    /// # Errors
    /// `CommandError` for an argument that makes no sense, `DataError` or `FileError` for a rig
    /// file that cannot be used.
    pub fn checked(self, py: Python<'_>) -> PyResult<Opening> {
        let rig = self.rig.as_deref().map(guard::load).transpose()?;
        let bus = rig.as_ref().map(Rig::bus).unwrap_or_default();
        let missing = |what: &str| {
            CommandError::new_err(format!("no {what} is given, and none by [bus] of a rig file; pass it"))
        };
        let path = self.uart_port.or(bus.port.map(PathBuf::from)).ok_or_else(|| missing("uart_port"))?;
        let boards = self.num_devices.or(bus.boards.map(i64::from)).ok_or_else(|| missing("num_devices"))?;
        let baud = self.baud.map(|baud| baud.0).or(rig.as_ref().and_then(rig::baud)).unwrap_or_default();
        let devices = devices(boards, self.max_devices)?;
        if let Some(rig) = &rig {
            warn_of_left_out(py, rig, self.num_devices.is_some().then_some(devices))?;
        }
        let retries =
            u32::try_from(self.retries).ok().filter(|retries| *retries <= MOST_RETRIES).ok_or_else(|| {
                CommandError::new_err(format!("retries is {}; it must be 0 to {MOST_RETRIES}", self.retries))
            })?;
        let rules = guard::rules(self.max_kpa, self.max_rate_kpa_s, rig.as_ref(), devices)?;
        let options =
            bus_options(&path, baud.first(), self.timeout)?.calibrated(&rules.calibration, &rules.boards);
        Ok(Opening { path, devices, options, rules, retries, line_rate: baud.policy() })
    }
}

/// A rig file that contradicts itself is refused; who passes fewer boards is told of limits that
/// then hold for nothing.
fn warn_of_left_out(py: Python<'_>, rig: &Rig, passed: Option<u16>) -> PyResult<()> {
    let said = passed.map(|devices| (devices, format!("num_devices = {devices}")));
    let given = said.as_ref().map(|(devices, said)| (*devices, said.as_str()));
    let Some(left_out) = rig::left_out(rig, given).map_err(errors::unusable)? else { return Ok(()) };
    let message = CString::new(left_out.to_string())?;
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &message, 1)
}

/// The largest number of boards that can be polled: no address is left to find out about echoes
/// with more.
const MOST_DEVICES: i64 = 255;

fn devices(boards: i64, max_devices: i64) -> PyResult<u16> {
    if !(1..=MOST_DEVICES).contains(&max_devices) {
        let message = format!("max_devices is {max_devices}; it must be 1 to {MOST_DEVICES}");
        return Err(CommandError::new_err(message));
    }
    let few_enough = u16::try_from(boards).ok().filter(|_| (1..=max_devices).contains(&boards));
    few_enough.ok_or_else(|| {
        CommandError::new_err(format!(
            "num_devices is {boards}; it must be 1 to {max_devices}{}",
            if boards > max_devices {
                "; boards with more than a two-way address switch need max_devices=, up to 255"
            } else {
                ""
            }
        ))
    })
}

/// How long bytes of virtual boards take.
///
/// # Errors
/// `CommandError` for another word.
pub fn timing(word: &str) -> PyResult<Timing> {
    match word {
        "wire" => Ok(Timing::Wire),
        "instant" => Ok(Timing::Instant),
        other => {
            Err(CommandError::new_err(format!("timing is {other:?}; it must be \"wire\" or \"instant\"")))
        }
    }
}
