//! A serial port, or virtual boards of our own.

use crate::errors::{self, PneuDriveError, PortError};
use pneudrive_host::bus::{Bus, BusOptions, EchoMode};
use pneudrive_protocol::Baud;
use pneudrive_sim::pty::{EmbeddedSim, PtyOptions};
use pneudrive_sim::rig::{RigOptions, Timing};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Where the boards are.
pub struct Port {
    path: PathBuf,
    options: BusOptions,
    /// Virtual boards end when this is dropped. They are talked to through their pty's bytes only.
    _boards: Option<EmbeddedSim>,
}

impl Port {
    /// The name that means virtual boards.
    pub const SIM: &'static str = "sim";

    /// Starts virtual boards if `port` is `"sim"`; opens nothing yet.
    pub fn new(port: PathBuf, devices: u16, options: BusOptions, timing: Timing) -> PyResult<Self> {
        if port.as_os_str() != Self::SIM {
            return Ok(Self { path: port, options, _boards: None });
        }
        let rig =
            RigOptions { boards: usize::from(devices), baud: options.baud, timing, ..RigOptions::default() };
        let boards = EmbeddedSim::start(&rig, &PtyOptions::default())
            .map_err(|error| PneuDriveError::new_err(format!("virtual boards: {error}")))?;
        Ok(Self { path: boards.path().to_owned(), options, _boards: Some(boards) })
    }

    /// Opens it for this process alone.
    pub fn open(&self) -> PyResult<Bus> {
        Bus::open(&self.path, self.options).map_err(errors::open)
    }

    /// Its path; that of the pty for virtual boards.
    pub fn path(&self) -> &std::path::Path {
        &self.path
    }
}

/// The bus settings that the arguments of `PressureController` mean.
pub fn bus_options(baud: u32, timeout_s: Option<f64>) -> PyResult<BusOptions> {
    let mut options = BusOptions {
        baud: Baud::new(baud).map_err(|error| PortError::new_err(error.to_string()))?,
        echo: EchoMode::Detect { unused_board: u8::MAX },
        ..BusOptions::default()
    };
    if let Some(timeout_s) = timeout_s {
        if !(timeout_s > 0.0 && timeout_s <= 60.0) {
            return Err(PortError::new_err(format!(
                "timeout is {timeout_s} s; it must be above 0 and at most 60 s"
            )));
        }
        options.answer_allowance_ns = (timeout_s * 1e9) as u64;
    }
    Ok(options)
}
