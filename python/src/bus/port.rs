//! A serial port, or virtual boards of our own.

use super::interruptible::{Interrupt, Interruptible};
use super::link::Bus;
use crate::errors::{self, CommandError};
use pneudrive_host::bus::BusOptions;
use pneudrive_host::line::{OpenError, SerialOptions, SerialPort};
use pneudrive_protocol::Baud;
use pneudrive_virtual::{Timing, VirtualBoards, VirtualError, VirtualOptions, is_sim};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Where the boards are.
pub struct Port {
    path: PathBuf,
    options: BusOptions,
    /// They end when this is dropped.
    _boards: Option<VirtualBoards>,
}

impl Port {
    /// Starts virtual boards if `port` is `"sim"`; opens nothing yet.
    pub fn new(port: PathBuf, devices: u16, options: BusOptions, timing: Timing) -> PyResult<Self> {
        if !is_sim(&port) {
            return Ok(Self { path: port, options, _boards: None });
        }
        let wanted = VirtualOptions::new(devices, options.baud).timing(timing);
        let boards = VirtualBoards::start(&wanted).map_err(|error| match error {
            VirtualError::NotBuilt => errors::PortError::new_err(error.to_string()),
            other => errors::PneuDriveError::new_err(other.to_string()),
        })?;
        Ok(Self { path: boards.path().to_owned(), options, _boards: Some(boards) })
    }

    /// Opens it for this process alone. Call it without the interpreter's lock.
    ///
    /// # Errors
    /// `PortError`, or what a signal's handler raised meanwhile.
    pub fn open(&self, interrupt: &Interrupt) -> PyResult<Bus> {
        let serial = SerialOptions::default().baud(self.options.baud).spin(self.options.spin);
        let port = SerialPort::open(&self.path, serial).map_err(|error| match error {
            OpenError::NotFound { port } => errors::PortError::new_err(format!(
                "{}: no such port; is the adapter plugged in? (look at /dev/serial/by-id, or pass \"sim\" for virtual boards)",
                port.display()
            )),
            other => errors::open(other.into()),
        })?;
        let line = Interruptible::new(port, interrupt.clone());
        Bus::new(line, self.options).map_err(|error| interrupt.take().unwrap_or_else(|| errors::open(error)))
    }

    /// Its path; that of the pty for virtual boards.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// The bus settings that the arguments of `PressureController` mean.
pub fn bus_options(port: &Path, baud: u32, timeout_s: Option<f64>) -> PyResult<BusOptions> {
    let baud = Baud::new(baud).map_err(|error| CommandError::new_err(format!("baud: {error}")))?;
    let mut options = BusOptions::default().baud(baud);
    if is_sim(port) {
        options.answer_allowance = BusOptions::VIRTUAL_ALLOWANCE;
    }
    if let Some(timeout_s) = timeout_s {
        if !(timeout_s > 0.0 && timeout_s <= 60.0) {
            return Err(CommandError::new_err(format!(
                "timeout is {timeout_s} s; it must be above 0 and at most 60 s"
            )));
        }
        options.answer_allowance = Duration::from_secs_f64(timeout_s);
    }
    Ok(options)
}
