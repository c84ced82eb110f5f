use super::commands::{self, SCALE};
use super::poller::{Poller, PollerSettings};
use super::port::{Port, Timing, bus_options};
use crate::errors::{self, CommandError, NoAnswerError, PneuDriveError, PortError, StaleDataError};
use crate::types::{Array, ArrayLike, Matrix, Vector};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pneudrive_host::bus::{Answer, Bus};
use pneudrive_protocol::{CHANNELS, Counts};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Host of up to 256 boards with four chambers each, on one serial port.
///
/// Parameters
/// ----------
/// uart_port : str or os.PathLike
///     Serial port, such as ``"/dev/ttyUSB0"``, or ``"sim"`` for virtual boards with chambers behind them.
/// num_devices : int
///     Boards on the bus; their address switches are set to 0, 1, ... 1 to 255.
/// baud : int, default 1_000_000
///     Line rate.
/// timeout : float, optional
///     How long a board may think before it answers, s; 0.002 by default. The wire's time is added.
/// timing : {"wire", "instant"}, default "wire"
///     Only for ``"sim"``: whether bytes take as long as on a wire.
///
/// Raises
/// ------
/// PortError
///     The port does not exist, is used by another process, or may not be opened.
///
/// Notes
/// -----
/// Usable as a context manager: at the end all boards are commanded to 0 kPa and the port is closed. All methods may be called
/// from several threads; exchanges then wait for each other.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct PressureController {
    port: Port,
    devices: u16,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// `None` while a poller has the bus, and after `close`.
    bus: Option<Bus>,
    closed: bool,
    readings: Vec<Option<[f64; CHANNELS]>>,
}

impl PressureController {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs `work` with the open bus, without the interpreter's lock.
    fn with_bus<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Bus, &mut Vec<Option<[f64; CHANNELS]>>) -> PyResult<T> + Send,
    ) -> PyResult<T> {
        py.detach(|| {
            let mut state = self.lock();
            if state.closed {
                return Err(PortError::new_err("this controller is closed"));
            }
            let State { bus, readings, .. } = &mut *state;
            let bus = match bus {
                Some(bus) => bus,
                // A poller gives the bus back by closing the port.
                None => bus.insert(self.port.open()?),
            };
            work(bus, readings)
        })
    }

    fn exchange(&self, py: Python<'_>, board: u8, commands: [Counts; CHANNELS]) -> PyResult<[f64; CHANNELS]> {
        self.with_bus(py, |bus, readings| {
            // Whatever happens, the old pressures are no longer the current ones.
            readings[usize::from(board)] = None;
            let answer = bus.exchange(board, commands).map_err(|error| errors::exchange(board, &error))?;
            let kpa = kpa(&answer);
            readings[usize::from(board)] = Some(kpa);
            Ok(kpa)
        })
    }
}

#[pymethods]
impl PressureController {
    #[new]
    #[pyo3(signature = (uart_port, num_devices, *, baud=1_000_000, timeout=None, timing="wire"))]
    fn new(
        py: Python<'_>,
        uart_port: PathBuf,
        num_devices: i64,
        baud: u32,
        timeout: Option<f64>,
        timing: &str,
    ) -> PyResult<Self> {
        let devices = u16::try_from(num_devices)
            .ok()
            .filter(|devices| (1..=255).contains(devices))
            .ok_or_else(|| {
                CommandError::new_err(format!(
                    "num_devices is {num_devices}; it must be 1 to 255 (4 with the usual address switch)"
                ))
            })?;
        let timing = match timing {
            "wire" => Timing::Wire,
            "instant" => Timing::Instant,
            other => {
                return Err(CommandError::new_err(format!(
                    "timing is {other:?}; it must be \"wire\" or \"instant\""
                )));
            }
        };
        let options = bus_options(baud, timeout)?;
        py.detach(|| {
            let port = Port::new(uart_port, devices, options, timing)?;
            let bus = port.open()?;
            let state = State { bus: Some(bus), closed: false, readings: vec![None; usize::from(devices)] };
            Ok(Self { port, devices, state: Mutex::new(state) })
        })
    }

    /// Asks every board whether it is there, by commanding 0 kPa, until all have answered.
    ///
    /// Parameters
    /// ----------
    /// timeout : float, default 5.0
    ///     How long to go on asking, s.
    ///
    /// Returns
    /// -------
    /// bool
    ///     True. A board that did not answer is an exception.
    ///
    /// Raises
    /// ------
    /// NoAnswerError
    ///     A board did not answer in time; ``board`` is the first such board's number.
    #[pyo3(signature = (timeout=5.0))]
    fn ping_devices(&self, py: Python<'_>, timeout: f64) -> PyResult<bool> {
        let patience = Duration::try_from_secs_f64(timeout)
            .map_err(|_| CommandError::new_err(format!("timeout is {timeout} s; it must be 0 or more")))?;
        let deadline = Instant::now() + patience;
        let mut missing: Vec<u8> = (0..=u8::MAX).take(usize::from(self.devices)).collect();
        loop {
            let mut still_missing = Vec::new();
            for &board in &missing {
                match self.exchange(py, board, [Counts::ATMOSPHERE; CHANNELS]) {
                    Ok(_) => {}
                    Err(error) if error.is_instance_of::<PortError>(py) => return Err(error),
                    Err(_) => still_missing.push(board),
                }
                py.check_signals()?;
            }
            missing = still_missing;
            let Some(&first) = missing.first() else { return Ok(true) };
            if Instant::now() >= deadline {
                let message = format!(
                    "no answer from {} of {} boards ({missing:?}) within {timeout} s; check power, wiring and address switches",
                    missing.len(),
                    self.devices
                );
                return Err(NoAnswerError::new_err((message, first)));
            }
            py.detach(|| std::thread::sleep(Duration::from_millis(10)));
        }
    }

    /// Commands four pressures to one board and receives its four pressures.
    ///
    /// Parameters
    /// ----------
    /// device : int
    ///     Board number, from 0.
    /// pressures : array_like of float, shape (4,)
    ///     Set points of channels 0 to 3, kPa gauge, 0 to 689.4757.
    ///
    /// Raises
    /// ------
    /// CommandError
    ///     A pressure that cannot be commanded, a wrong shape, or no such board; nothing was sent.
    /// NoAnswerError, GarbledAnswerError
    ///     The exchange failed; ``get_pressure_data`` then has nothing to give.
    #[pyo3(signature = (device: "int", pressures))]
    fn set_pressure_commands(&self, py: Python<'_>, device: i64, pressures: ArrayLike<'_>) -> PyResult<()> {
        let board = commands::board(device, self.devices)?;
        let counts = commands::counts(board, &pressures.0)?;
        self.exchange(py, board, counts).map(|_| ())
    }

    /// The pressures that one board sent in its last exchange.
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
    ///     The last exchange with this board failed, or there was none yet.
    #[pyo3(signature = (device: "int"))]
    fn get_pressure_data<'py>(&self, py: Python<'py>, device: i64) -> PyResult<Vector<'py>> {
        let board = commands::board(device, self.devices)?;
        let reading = self.lock().readings.get(usize::from(board)).copied().flatten();
        match reading {
            Some(kpa) => Ok(Array(PyArray1::from_slice(py, &kpa))),
            None => Err(StaleDataError::new_err((
                format!(
                    "board {board}: no current pressures, because its last exchange failed or there was none yet"
                ),
                board,
            ))),
        }
    }

    /// Commands all boards, one after the other, and receives all pressures.
    ///
    /// Parameters
    /// ----------
    /// pressures : array_like of float, shape (num_devices, 4)
    ///     Set points, kPa gauge. All are checked before the first is sent.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray of float64, shape (num_devices, 4)
    ///     Measured pressures, kPa gauge.
    ///
    /// Raises
    /// ------
    /// CommandError
    ///     Nothing was sent.
    /// NoAnswerError, GarbledAnswerError
    ///     The first exchange that failed; the boards after it were still commanded.
    fn exchange_all<'py>(&self, py: Python<'py>, pressures: ArrayLike<'py>) -> PyResult<Matrix<'py>> {
        let rows = pressures.0.try_iter()?.collect::<PyResult<Vec<_>>>()?;
        if rows.len() != usize::from(self.devices) {
            return Err(CommandError::new_err(format!(
                "expected pressures of shape ({}, {CHANNELS}), got {} rows",
                self.devices,
                rows.len()
            )));
        }
        let boards = 0..=u8::MAX;
        let checked = boards.zip(&rows).map(|(board, row)| Ok((board, commands::counts(board, row)?)));
        let checked = checked.collect::<PyResult<Vec<_>>>()?;
        let mut first_failure = None;
        let measured = PyArray2::zeros(py, [rows.len(), CHANNELS], false);
        for (board, counts) in checked {
            match self.exchange(py, board, counts) {
                Ok(kpa) => {
                    for (channel, value) in kpa.into_iter().enumerate() {
                        measured.readwrite().as_array_mut()[[usize::from(board), channel]] = value;
                    }
                }
                Err(error) if error.is_instance_of::<PortError>(py) => return Err(error),
                Err(error) => first_failure = first_failure.or(Some(error)),
            }
        }
        first_failure.map_or(Ok(Array(measured)), Err)
    }

    /// Polls all boards in the background, at a fixed rate or as fast as possible.
    ///
    /// Parameters
    /// ----------
    /// rate_hz : float, optional
    ///     Cycles per second; as fast as possible by default.
    /// history_s : float, default 60.0
    ///     How much of the past to keep, s.
    ///
    /// Returns
    /// -------
    /// Poller
    ///     Has the bus until it is stopped; use it as a context manager.
    #[pyo3(signature = (rate_hz=None, *, history_s=60.0))]
    fn poll(&self, py: Python<'_>, rate_hz: Option<f64>, history_s: f64) -> PyResult<Poller> {
        let settings = PollerSettings::new(self.devices, rate_hz, history_s)?;
        py.detach(|| {
            let mut state = self.lock();
            if state.closed {
                return Err(PortError::new_err("this controller is closed"));
            }
            state.readings.fill(None);
            let bus = match state.bus.take() {
                Some(bus) => bus,
                None => self.port.open()?,
            };
            Poller::start(bus, settings)
        })
    }

    /// Commands 0 kPa to all boards and closes the port. Further calls do nothing.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| {
            let mut state = self.lock();
            state.closed = true;
            state.readings.fill(None);
            let Some(mut bus) = state.bus.take() else { return Ok(()) };
            let boards = (0..=u8::MAX).take(usize::from(self.devices));
            bus.make_safe(boards).map_err(|error| errors::line(&error))?;
            Ok(())
        })
    }

    /// Number of boards.
    #[getter]
    fn num_devices(&self) -> u16 {
        self.devices
    }

    /// The port's path; for virtual boards that of their pty.
    #[getter]
    fn port(&self) -> PathBuf {
        self.port.path().to_owned()
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
        // An exception on its way says more than that the port is gone, too.
        match self.close(py) {
            Err(error) if exc_type.is_none() || !error.is_instance_of::<PneuDriveError>(py) => Err(error),
            _ => Ok(()),
        }
    }

    fn __repr__(&self) -> String {
        let state = if self.lock().closed { ", closed" } else { "" };
        format!("<PressureController {:?}, {} boards{state}>", self.port.path(), self.devices)
    }
}

fn kpa(answer: &Answer) -> [f64; CHANNELS] {
    answer.pressures.map(|counts| SCALE.kpa(counts))
}
