use super::commands;
use super::ending::{LOOK_EVERY, Signals};
use super::guard::Rules;
use super::live;
use super::sensors::{self, Reading};
use super::session::Session;
use crate::errors::{CommandError, PneuDriveError, PortError, StaleDataError};
use crate::types::{Array, ArrayLike, Dict, Matrix, Vector};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pneudrive_host::poller::{BoardState, LineRatePolicy, MissedTick, Outcome, Pace, PageShare, Snapshot};
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::CHANNELS;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use std::time::{Duration, Instant};

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
                Pace::Every { period_ns: (1e9 / rate).round() as u64, missed: MissedTick::Skip }
            }
            Some(rate) => {
                let max = Self::RATE_MAX_HZ;
                return Err(CommandError::new_err(format!(
                    "rate_hz is {rate}; it must be above 0 and at most {max}"
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

/// Polls all boards of a controller in the background; made by ``PressureController.poll``.
///
/// Set points may be changed and pressures read at any time, from any thread, without waiting for the bus. When it is stopped,
/// its ``with`` block or its controller's ends, or it is deleted, all boards are commanded to 0 kPa, and the controller can be used by
/// hand again.
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

/// How often a caller that waits looks whether there is a new row: short beside the cycles of a bus, long beside a look.
const LOOK_FOR_ROWS_EVERY: Duration = Duration::from_micros(300);

/// How long the first figures of a run are waited for: the bus thread makes them at the end of its cycle.
const FIGURES_WITHIN: Duration = Duration::from_secs(1);

/// Looks until `found` finds something or `until` has come, running the handlers of signals. Call it without the interpreter's lock.
fn look<T>(every: Duration, until: Instant, mut found: impl FnMut() -> Option<T>) -> PyResult<Option<T>> {
    let mut signals_at = Instant::now() + LOOK_EVERY;
    loop {
        if let Some(found) = found() {
            return Ok(Some(found));
        }
        let now = Instant::now();
        if now >= until {
            return Ok(None);
        }
        if now >= signals_at {
            Signals::Handled.look()?;
            signals_at = now + LOOK_EVERY;
        }
        std::thread::sleep(every);
    }
}

/// A time that Python gave.
fn patience(name: &str, seconds: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(seconds)
        .ok()
        .filter(|patience| patience.as_secs() <= MOST_PATIENCE_S)
        .ok_or_else(|| {
            CommandError::new_err(format!("{name} is {seconds} s; it must be 0 to {MOST_PATIENCE_S} s"))
        })
}

/// A year and a bit: whoever means for ever says None.
const MOST_PATIENCE_S: u64 = 40_000_000;

impl Drop for Poller {
    fn drop(&mut self) {
        if self.session.owner().is_other_process() {
            return;
        }
        let end = || self.session.end("it was deleted").wait(Signals::Left);
        // Nobody can be told of what an interpreter at its end, or an object that is destroyed, could say.
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
    ///     A pressure that cannot or may not be commanded, a wrong shape, no such board, or the boards are vented; the old set points
    ///     stand.
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
    ///     Set points, kPa gauge; four for every board, or one for every channel, if there are no more. All are checked before the
    ///     first is changed.
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
    ///     Measured pressures, kPa gauge; NaN where ``get_pressure_data`` would raise StaleDataError.
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
    ///     Number of a cycle; the returned one is a later one. By default the one that is current when this is called.
    /// timeout : float, default 1.0
    ///     How long to wait at most, s.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``cycle``: its number, from 0; ``t_s``: start of the cycle, s from the first; ``commands_kpa`` and ``pressures_kpa``: shape
    ///     (num_devices, 4), kPa gauge, NaN where a board did not answer in that cycle.
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
    ///     ``t_s``: shape (n,), start of each cycle, s from the first; ``commands_kpa`` and ``pressures_kpa``: shape
    ///     (n, num_devices, 4), kPa gauge, NaN where a board did not answer in that cycle. With the controller's ``sensors`` also
    ///     ``supply_kpa``, shape (n, num_devices), ``acceleration_m_s2`` and ``angular_rate_rad_s``, shape (n, num_devices, 3), NaN where
    ///     they were not read in that cycle.
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

    /// The last readings of the sensors on the boards' I2C connectors, where the controller was made with ``sensors``.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``supply_kpa``: shape (num_devices,), supply pressure, kPa gauge; ``acceleration_m_s2`` and ``angular_rate_rad_s``: shape
    ///     (num_devices, 3), along and about the axes of the IMU, gravity included. NaN where a board has no such part, or it is not live.
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
    ///     ``devices``, ``seconds``, ``baud`` (line rate in effect), ``cycles``, ``exchanges``, ``lost``, ``rejected``, ``missed_ticks``; ``loop_hz`` (``mean``, ``std``, ``min``);
    ///     ``cycle_us`` (``p50``, ``p99``, ``p999``, ``max``); ``cpu_share`` of one core. Figures are those of the last time somebody
    ///     asked; the first call waits for them. None if no cycle ends in the meantime (1 s).
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

    /// Follows set points again after ``vent``, or after a port that was gone has come back. What was commanded before does not return:
    /// all set points are 0 kPa until they are set. Does nothing if the boards are not vented.
    fn release(&self) -> PyResult<()> {
        let session = self.session()?;
        if session.vent().is_vented() {
            session.release();
        }
        Ok(())
    }

    /// Whether 0 kPa is commanded until ``release``: by ``vent``, or because the port was gone and has come back.
    #[getter]
    fn vented(&self) -> PyResult<bool> {
        Ok(self.session()?.vent().is_vented())
    }

    /// Commands 0 kPa to all boards and gives the bus back to the controller. Further calls do nothing.
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
        format!("<Poller of {} boards, {state}, 0 to {full_scale:.0} kPa>", self.devices)
    }
}

/// Why a set point is not taken, and what to do.
const VENTED: &str =
    "all boards are vented (by vent(), or because the port was gone and has come back): call release() first";

fn row_as_dict<'py>(
    py: Python<'py>,
    row: &Snapshot,
    rules: &Rules,
) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
    let matrix = |rows: Vec<Vec<f64>>| {
        PyArray2::from_vec2(py, &rows).map_err(|error| PneuDriveError::new_err(error.to_string()))
    };
    let commands =
        row.boards.iter().map(|one| rules.calibration.command_kpa(one.board, one.command).to_vec());
    let pressures = row.boards.iter().map(|one| match (one.outcome, one.reading) {
        (Outcome::Fresh, Some(reading)) => reading.kpa.to_vec(),
        _ => vec![f64::NAN; CHANNELS],
    });
    let dict = PyDict::new(py);
    dict.set_item("cycle", row.cycle)?;
    dict.set_item("t_s", row.since_start_ns as f64 * 1e-9)?;
    dict.set_item("commands_kpa", matrix(commands.collect())?)?;
    dict.set_item("pressures_kpa", matrix(pressures.collect())?)?;
    Ok(Dict::new(dict))
}

fn as_dict<'py>(py: Python<'py>, statistics: &Statistics) -> PyResult<Dict<'py, Bound<'py, PyAny>>> {
    let loop_hz = PyDict::new(py);
    loop_hz.set_item("mean", statistics.loop_hz.mean)?;
    loop_hz.set_item("std", statistics.loop_hz.std)?;
    loop_hz.set_item("min", statistics.loop_hz.min)?;
    let cycle_us = PyDict::new(py);
    cycle_us.set_item("p50", statistics.cycle_us.p50)?;
    cycle_us.set_item("p99", statistics.cycle_us.p99)?;
    cycle_us.set_item("p999", statistics.cycle_us.p999)?;
    cycle_us.set_item("max", statistics.cycle_us.max)?;
    let dict = PyDict::new(py);
    dict.set_item("devices", statistics.devices)?;
    dict.set_item("seconds", statistics.seconds)?;
    dict.set_item("baud", statistics.baud)?;
    dict.set_item("cycles", statistics.cycles)?;
    dict.set_item("loop_hz", loop_hz)?;
    dict.set_item("cycle_us", cycle_us)?;
    dict.set_item("exchanges", statistics.exchanges)?;
    dict.set_item("lost", statistics.lost)?;
    dict.set_item("rejected", statistics.rejected)?;
    dict.set_item("missed_ticks", statistics.missed_ticks)?;
    dict.set_item("cpu_share", statistics.cpu_share)?;
    Ok(Dict::new(dict))
}
