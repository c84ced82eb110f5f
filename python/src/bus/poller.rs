use super::commands::{self, SCALE};
use super::history::History;
use crate::errors::{CommandError, PneuDriveError, PortError, StaleDataError};
use crate::types::{Array, ArrayLike, Dict, Vector};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pneudrive_host::bus::Bus;
use pneudrive_host::poller::{self as host, BoardState, MissedTick, Pace, PollerOptions, SetPoints};
use pneudrive_host::statistics::Statistics;
use pneudrive_protocol::CHANNELS;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What a poller is asked to do.
pub struct PollerSettings {
    devices: u16,
    pace: Pace,
    history_s: f64,
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
        Ok(Self { devices, pace, history_s })
    }
}

/// Polls all boards of a controller in the background; made by ``PressureController.poll``.
///
/// Set points may be changed and pressures read at any time, from any thread, without waiting for the bus. When it is stopped
/// (or its ``with`` block ends) all boards are commanded to 0 kPa, and the controller can be used by hand again.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct Poller {
    devices: u16,
    set_points: SetPoints,
    history: History,
    running: Mutex<Run>,
}

enum Run {
    Polling(host::Poller),
    Ended {
        statistics: Statistics,
        failure: Option<String>,
    },
    /// An observer panicked, or stopping is under way.
    Lost,
}

impl Poller {
    /// Starts polling on a thread of its own.
    pub fn start(bus: Bus, settings: PollerSettings) -> PyResult<Self> {
        let set_points = SetPoints::new(usize::from(settings.devices));
        let history = History::new(settings.history_s);
        let options = PollerOptions { pace: settings.pace, ..PollerOptions::for_devices(settings.devices) };
        let observers: Vec<Box<dyn host::Observer>> = vec![Box::new(history.writer())];
        let poller = host::Poller::start(bus, options, Box::new(set_points.clone()), observers)
            .map_err(|error| PneuDriveError::new_err(format!("no thread for the poller: {error}")))?;
        Ok(Self { devices: settings.devices, set_points, history, running: Mutex::new(Run::Polling(poller)) })
    }

    fn lock(&self) -> MutexGuard<'_, Run> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn end(&self) -> PyResult<()> {
        let mut run = self.lock();
        if !matches!(*run, Run::Polling(_)) {
            return Ok(());
        }
        let Run::Polling(poller) = std::mem::replace(&mut *run, Run::Lost) else { return Ok(()) };
        let finished = poller.stop().ok_or_else(|| PneuDriveError::new_err("the polling thread failed"))?;
        let failure = finished.error.map(|error| error.to_string());
        *run = Run::Ended { statistics: finished.statistics, failure: failure.clone() };
        failure.map_or(Ok(()), |message| Err(PortError::new_err(message)))
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
    #[pyo3(signature = (device: "int", pressures))]
    fn set_pressure_commands(&self, device: i64, pressures: ArrayLike<'_>) -> PyResult<()> {
        let board = commands::board(device, self.devices)?;
        let counts = commands::counts(board, &pressures.0)?;
        if let Run::Ended { failure, .. } = &*self.lock() {
            let why = failure.as_deref().unwrap_or("it was stopped");
            return Err(PortError::new_err(format!("this poller has ended: {why}")));
        }
        self.set_points
            .set(usize::from(board), counts)
            .map_err(|error| CommandError::new_err(error.to_string()))
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
        let row = match &*self.lock() {
            Run::Polling(poller) => poller.latest().boards.into_iter().nth(usize::from(board)),
            _ => None,
        };
        match row.filter(|row| row.state == BoardState::Present).and_then(|row| row.reading) {
            Some(reading) => Ok(Array(PyArray1::from_slice(py, &reading.kpa))),
            None => Err(StaleDataError::new_err((
                format!("board {board}: no current pressures; it did not answer when it was last asked"),
                board,
            ))),
        }
    }

    /// What happened in the time that is kept.
    ///
    /// Returns
    /// -------
    /// dict
    ///     ``t_s``: shape (n,), start of each cycle, s from the first; ``commands_kpa`` and ``pressures_kpa``: shape
    ///     (n, num_devices, 4), kPa gauge, NaN where a board did not answer in that cycle.
    fn history<'py>(&self, py: Python<'py>) -> PyResult<Dict<'py, Vector<'py>>> {
        let samples = py.detach(|| self.history.samples());
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
        Ok(Dict::new(history))
    }

    /// What the run has been like.
    ///
    /// Returns
    /// -------
    /// dict or None
    ///     ``seconds``, ``cycles``, ``exchanges``, ``lost``, ``rejected``, ``missed_ticks``; ``loop_hz`` (``mean``, ``std``, ``min``);
    ///     ``cycle_us`` (``p50``, ``p99``, ``p999``, ``max``); ``cpu_share`` of one core. None before the first figures.
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Option<Dict<'py, Bound<'py, PyAny>>>> {
        let statistics = match &*self.lock() {
            Run::Polling(poller) => poller.statistics(),
            Run::Ended { statistics, .. } => Some(statistics.clone()),
            Run::Lost => None,
        };
        statistics.map(|statistics| as_dict(py, &statistics)).transpose()
    }

    /// Commands 0 kPa to all boards and gives the bus back to the controller. Further calls do nothing.
    ///
    /// Raises
    /// ------
    /// PortError
    ///     The port failed while polling.
    fn stop(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| self.end())
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
        match self.stop(py) {
            Err(error) if exc_type.is_none() => Err(error),
            _ => Ok(()),
        }
    }

    fn __repr__(&self) -> String {
        let state = match &*self.lock() {
            Run::Polling(poller) if !poller.is_finished() => "polling",
            Run::Polling(_) => "failed",
            _ => "stopped",
        };
        let full_scale = SCALE.full_scale_kpa();
        format!("<Poller of {} boards, {state}, 0 to {full_scale:.0} kPa>", self.devices)
    }
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
