use super::commands;
use super::ending::{LOOK_EVERY, Signals};
use super::figures::{as_dict, row_as_dict};
use super::live;
use super::sensors::{self, Reading};
use super::session::Session;
use super::waiting::{FIGURES_WITHIN, LOOK_FOR_ROWS_EVERY, MOST_PATIENCE_S, look, patience};
use crate::errors::{CommandError, PneuDriveError, PortError, StaleDataError};
use crate::types::{Array, ArrayLike, Dict, Matrix, Vector};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pneudrive_host::poller::BoardState;
use pneudrive_protocol::CHANNELS;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use std::time::Instant;

/// Polls all boards of a controller in the background; made by ``PressureController.poll``.
///
/// Set points may be changed and pressures read at any time, from any thread, without waiting for
/// the bus. When it is stopped, its ``with`` block or its controller's ends, or it is deleted, all
/// boards are commanded to 0 kPa, and the controller can be used by hand again.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Poller {
    devices: u16,
    session: Arc<Session>,
}

impl Poller {
    /// Of a run that has started.
    pub fn new(session: Arc<Session>, devices: u16) -> Self {
        Self { devices, session }
    }

    /// Refuses in a forked child.
    fn session(&self) -> PyResult<&Session> {
        self.session.owner().check("poller")?;
        Ok(&self.session)
    }

    /// Why it polls no more, if so.
    fn why_ended(session: &Session, py: Python<'_>) -> PyResult<Option<String>> {
        if session.is_polling() {
            return Ok(None);
        }
        if session.why_ended().is_none() {
            // It has ended by itself, and comes to its end at once.
            py.detach(|| session.end(session.natural_end()).wait(Signals::Handled))?;
        }
        Ok(session.why_ended())
    }
}

impl Drop for Poller {
    fn drop(&mut self) {
        if self.session.owner().is_other_process() {
            return;
        }
        let end = || self.session.end("it was deleted").wait(Signals::Left);
        // Nobody can be told of what an interpreter at its end, or an object that is destroyed,
        // could say.
        let _ = Python::try_attach(|py| py.detach(end));
    }
}

#[pymethods]
impl Poller {
    /// Changes the set points of one board, from its next exchange on.
    ///
    /// Parameters
    /// ----------
    /// device : int
    ///     Board number, from 0.
    /// pressures : array_like of float, shape (4,)
    ///     Set points of channels 0 to 3, kPa gauge.
    ///
    /// Raises
    /// ------
    /// CommandError
    ///     A pressure that cannot or may not be commanded, a wrong shape, no such board, or the
    ///     boards are vented; the old set points stand.
    /// PortError
    ///     The poller has ended.
    #[pyo3(signature = (device: "int", pressures))]
    fn set_pressure_commands(&self, py: Python<'_>, device: i64, pressures: ArrayLike<'_>) -> PyResult<()> {
        let session = self.session()?;
        let board = commands::board(device, self.devices)?;
        let counts = commands::counts(board, &pressures.0, session.rules())?;
        if let Some(why) = Self::why_ended(session, py)? {
            return Err(PortError::new_err(format!("this poller has ended: {why}")));
        }
        if session.vent().is_vented() {
            return Err(CommandError::new_err(VENTED));
        }
        session.set(board, counts).map_err(CommandError::new_err)
    }

    /// Changes the set points of all boards, from their next exchanges on.
    ///
    /// Parameters
    /// ----------
    /// pressures : array_like of float, shape (num_devices, 4), (4,) or ()
    ///     Set points, kPa gauge; four for every board, or one for every channel, if there are no
    ///     more. All are checked before the first is changed.
    ///
    /// Raises
    /// ------
    /// CommandError, PortError
    ///     As for ``set_pressure_commands``; the old set points stand.
    fn set_all(&self, py: Python<'_>, pressures: ArrayLike<'_>) -> PyResult<()> {
        let session = self.session()?;
        let commands = commands::of_all(self.devices, &pressures.0, session.rules())?;
        if let Some(why) = Self::why_ended(session, py)? {
            return Err(PortError::new_err(format!("this poller has ended: {why}")));
        }
        if session.vent().is_vented() {
            return Err(CommandError::new_err(VENTED));
        }
        let mut commands = commands.into_iter();
        commands.try_for_each(|(board, counts)| session.set(board, counts).map_err(CommandError::new_err))
    }

    /// The newest pressures of all boards.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray of float64, shape (num_devices, 4)
    ///     Measured pressures, kPa gauge; NaN where ``get_pressure_data`` would raise
    ///     StaleDataError.
    fn get_all<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        let session = self.session()?;
        let rows = session.latest().map(|latest| latest.boards).unwrap_or_default();
        let kpa = |board: usize| {
            let row = rows.get(board).filter(|row| row.state == BoardState::Present);
            row.and_then(|row| row.reading).map_or([f64::NAN; CHANNELS], |reading| reading.kpa)
        };
        let kpa: Vec<Vec<f64>> = (0..usize::from(self.devices)).map(|board| kpa(board).to_vec()).collect();
        // The rows are equally long.
        Ok(Array(PyArray2::from_vec2(py, &kpa).map_err(|error| PneuDriveError::new_err(error.to_string()))?))
    }

    /// Waits for a cycle of the bus and returns it.
    ///
    /// Parameters
    /// ----------
    /// after : int, optional
    ///     Number of a cycle; the returned one is a later one. By default the one that is current
    ///     when this is called.
    /// timeout : float, default 1.0
    ///     How long to wait at most, s.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``cycle``: its number, from 0; ``t_s``: start of the cycle, s from the first;
    ///     ``commands_kpa`` and ``pressures_kpa``: shape (num_devices, 4), kPa gauge, NaN where a
    ///     board did not answer in that cycle.
    ///
    /// Raises
    /// ------
    /// PortError
    ///     The poller has ended.
    /// PneuDriveError
    ///     No new cycle in that time.
    #[pyo3(signature = (after=None, *, timeout=1.0))]
    fn wait<'py>(
        &self,
        py: Python<'py>,
        after: Option<u64>,
        timeout: f64,
    ) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
        let session = self.session()?;
        let until = Instant::now() + patience("timeout", timeout)?;
        let after = after.or_else(|| session.latest().and_then(|latest| latest.cycle));
        let row = py.detach(|| {
            look(LOOK_FOR_ROWS_EVERY, until, || match session.latest() {
                Some(latest) if latest.cycle > after => Some(Some(latest)),
                _ if !session.is_polling() => Some(None),
                _ => None,
            })
        })?;
        match row {
            Some(Some(row)) => row_as_dict(py, &row, session.rules()),
            Some(None) => {
                let why = Self::why_ended(session, py)?.unwrap_or_default();
                Err(PortError::new_err(format!("this poller has ended: {why}")))
            }
            None => Err(PneuDriveError::new_err(format!("no cycle of the bus ended within {timeout} s"))),
        }
    }

    /// Waits until polling ends: because a trajectory has come to its end, or by ``stop``.
    ///
    /// Parameters
    /// ----------
    /// timeout : float, optional
    ///     How long to wait at most, s; for ever by default.
    ///
    /// Returns
    /// -------
    /// bool
    ///     Whether it has ended.
    ///
    /// Raises
    /// ------
    /// PortError
    ///     The port failed while polling.
    ///
    /// Warns
    /// -----
    /// VentWarning
    ///     A board did not confirm 0 kPa.
    #[pyo3(signature = (timeout=None))]
    fn join(&self, py: Python<'_>, timeout: Option<f64>) -> PyResult<bool> {
        let session = self.session()?;
        let until = Instant::now() + patience("timeout", timeout.unwrap_or(MOST_PATIENCE_S as f64))?;
        let ended = py.detach(|| look(LOOK_EVERY, until, || (!session.is_polling()).then_some(())))?;
        if ended.is_none() {
            return Ok(false);
        }
        let vented = py.detach(|| session.end(session.natural_end()).wait(Signals::Handled))?;
        live::tell(py, session.tell().then_some(&vented))?;
        Ok(true)
    }

    /// The newest pressures of one board.
    ///
    /// Parameters
    /// ----------
    /// device : int
    ///     Board number, from 0.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray of float64, shape (4,)
    ///     Measured pressures of channels 0 to 3, kPa gauge.
    ///
    /// Raises
    /// ------
    /// StaleDataError
    ///     The board did not answer in the last cycle in which it was asked, or has never answered.
    #[pyo3(signature = (device: "int"))]
    fn get_pressure_data<'py>(&self, py: Python<'py>, device: i64) -> PyResult<Vector<'py>> {
        let board = commands::board(device, self.devices)?;
        let session = self.session()?;
        let row = session.latest().and_then(|latest| latest.boards.into_iter().nth(usize::from(board)));
        let current = row.filter(|row| row.state == BoardState::Present).and_then(|row| row.reading);
        if let Some(reading) = current {
            return Ok(Array(PyArray1::from_slice(py, &reading.kpa)));
        }
        let why = match Self::why_ended(session, py)? {
            Some(why) => format!("this poller has ended: {why}"),
            None => "it did not answer when it was last asked".to_owned(),
        };
        Err(StaleDataError::new_err((format!("board {board}: no current pressures; {why}"), board)))
    }

    /// What happened in the time that is kept.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``t_s``: shape (n,), start of each cycle, s from the first; ``commands_kpa`` and
    ///     ``pressures_kpa``: shape (n, num_devices, 4), kPa gauge, NaN where a board did not
    ///     answer in that cycle. With the controller's ``sensors`` also ``supply_kpa``, ``chip_c``
    ///     and ``rail_v``, shape (n, num_devices), ``acceleration_m_s2`` and
    ///     ``angular_rate_rad_s``, shape (n, num_devices, 3), NaN where they were not read in that
    ///     cycle.
    fn history<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, Vector<'py>>> {
        let session = self.session()?;
        let samples = py.detach(|| session.history().samples());
        let shape = [samples.len(), usize::from(self.devices), CHANNELS];
        let commands = PyArray3::zeros(py, shape, false);
        let pressures = PyArray3::zeros(py, shape, false);
        {
            let (mut commands, mut pressures) = (commands.readwrite(), pressures.readwrite());
            let (mut commands, mut pressures) = (commands.as_array_mut(), pressures.as_array_mut());
            for (n, sample) in samples.iter().enumerate() {
                for (board, (sent, got)) in sample.commands.iter().zip(&sample.pressures).enumerate() {
                    for channel in 0..CHANNELS {
                        commands[[n, board, channel]] = sent[channel];
                        pressures[[n, board, channel]] = got[channel];
                    }
                }
            }
        }
        let history = PyDict::new(py);
        let times: Vec<f64> = samples.iter().map(|sample| sample.t_s).collect();
        history.set_item("t_s", PyArray1::from_vec(py, times))?;
        history.set_item("commands_kpa", commands)?;
        history.set_item("pressures_kpa", pressures)?;
        if session.history().has_sensors() {
            sensors::add_to(py, &history, &samples, usize::from(self.devices))?;
        }
        Ok(Dict::new(history))
    }

    /// The last readings of the sensors on the boards' I2C connectors, where the controller was
    /// made with ``sensors``.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``supply_kpa``: shape (num_devices,), supply pressure, kPa gauge; ``acceleration_m_s2``
    ///     and ``angular_rate_rad_s``: shape (num_devices, 3), along and about the axes of the IMU,
    ///     gravity included; ``chip_c`` and ``rail_v``: shape (num_devices,), temperature of the
    ///     board's chip, degrees Celsius, and voltage of its connector's 5 V, both asked for once a
    ///     second. NaN where a board has no such part, or it is not live.
    fn get_sensors<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
        let session = self.session()?;
        let rows = session.latest().map(|latest| latest.boards).unwrap_or_default();
        let reading = |board: usize| {
            let row = rows.get(board).filter(|row| row.state == BoardState::Present);
            row.map_or(Reading::NONE, |row| Reading::last(&row.sensors))
        };
        let readings: Vec<_> = (0..usize::from(self.devices)).map(reading).collect();
        sensors::as_dict(py, &readings)
    }

    /// What the run has been like.
    ///
    /// Returns
    /// -------
    /// dict or None
    ///     ``devices``, ``seconds``, ``baud`` (line rate in effect), ``cycles``, ``exchanges``,
    ///     ``lost``, ``rejected``, ``missed_ticks``; ``loop_hz`` (``mean``, ``std``, ``min``);
    ///     ``cycle_us`` (``p50``, ``p99``, ``p999``, ``max``); ``cpu_share`` of one core. Figures
    ///     are those of the last time somebody asked; the first call waits for them. None if no
    ///     cycle ends in the meantime (1 s).
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Option<Dict<'py, Bound<'py, PyAny>>>> {
        let session = self.session()?;
        let until = Instant::now() + FIGURES_WITHIN;
        let statistics = py.detach(|| {
            look(LOOK_FOR_ROWS_EVERY, until, || match session.statistics() {
                None if session.is_polling() => None,
                figures => Some(figures),
            })
        })?;
        statistics.flatten().map(|statistics| as_dict(py, &statistics)).transpose()
    }

    /// Commands 0 kPa to all boards at once, until ``release``; polling goes on.
    ///
    /// Raises
    /// ------
    /// PortError
    ///     The poller has ended; its boards were commanded 0 kPa then.
    fn vent(&self, py: Python<'_>) -> PyResult<()> {
        let session = self.session()?;
        session.vent().vent();
        match Self::why_ended(session, py)? {
            Some(why) => Err(PortError::new_err(format!("this poller has ended: {why}"))),
            None => Ok(()),
        }
    }

    /// Follows set points again after ``vent``, or after a port that was gone has come back. What
    /// was commanded before does not return: all set points are 0 kPa until they are set. Does
    /// nothing if the boards are not vented.
    fn release(&self) -> PyResult<()> {
        let session = self.session()?;
        if session.vent().is_vented() {
            session.release();
        }
        Ok(())
    }

    /// Whether 0 kPa is commanded until ``release``: by ``vent``, or because the port was gone and
    /// has come back.
    #[getter]
    fn vented(&self) -> PyResult<bool> {
        Ok(self.session()?.vent().is_vented())
    }

    /// Commands 0 kPa to all boards and gives the bus back to the controller. Further calls do
    /// nothing.
    ///
    /// Raises
    /// ------
    /// PortError
    ///     The port failed while polling.
    ///
    /// Warns
    /// -----
    /// VentWarning
    ///     A board did not confirm 0 kPa.
    fn stop(&self, py: Python<'_>) -> PyResult<()> {
        let session = self.session()?;
        let vented = py.detach(|| session.end("it was stopped").wait(Signals::Handled))?;
        live::tell(py, session.tell().then_some(&vented))
    }

    fn __enter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    #[pyo3(signature = (exc_type, _exc_value, _traceback))]
    fn __exit__(
        &self,
        py: Python<'_>,
        exc_type: &Bound<'_, PyAny>,
        _exc_value: &Bound<'_, PyAny>,
        _traceback: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        live::leave_block(self.stop(py), py, exc_type)
    }

    fn __repr__(&self) -> String {
        let session = &self.session;
        let state = if session.owner().is_other_process() {
            "of another process".to_owned()
        } else if session.is_polling() {
            if session.vent().is_vented() { "vented until released" } else { "polling" }.to_owned()
        } else {
            session.why_ended().map_or_else(|| "failed".to_owned(), |why| format!("ended: {why}"))
        };
        let rules = session.rules();
        let full_scale = rules.calibration.full_scale_kpa(&rules.boards);
        format!("<Poller of {}, {state}, 0 to {full_scale:.0} kPa>", commands::counted(self.devices))
    }
}

/// Why a set point is not taken, and what to do.
const VENTED: &str =
    "all boards are vented (by vent(), or because the port was gone and has come back): call release() first";
