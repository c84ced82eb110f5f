use super::baud::Baud;
use super::by_hand;
use super::commands;
use super::ending::Signals;
use super::link::{Link, POLLED, held_by_us};
use super::live;
use super::opening::{self, Given, Opening};
use super::poller::Poller;
use super::poller_settings::PollerSettings;
use super::port::Port;
use super::sensors;
use super::session::Session;
use super::trajectory;
use crate::errors::StaleDataError;
use crate::types::{Array, ArrayLike, Matrix, Vector};
use numpy::PyArray1;
use pneudrive_host::poller::{LineRatePolicy, PageShare};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// Host of up to 255 boards with four chambers each, on one serial port.
///
/// Parameters
/// ----------
/// uart_port : str or os.PathLike, optional
///     Serial port, such as ``"/dev/ttyUSB0"``, or ``"sim"`` for virtual boards with chambers
///     behind them; that of ``rig`` by default.
/// num_devices : int, optional
///     Boards on the bus; their address switches are set to 0, 1, ... 1 to ``max_devices``; as many
///     as ``rig`` says by default.
/// max_devices : int, default 4
///     Most boards that are accepted, 1 to 255: 4 have an address on the boards' two-way switch.
/// baud : int or "auto", optional
///     Line rate, bit/s; that of ``rig``, or 1_000_000 by default. ``"auto"`` polls at the fastest
///     that all boards agree to, up to 3_000_000, and goes back on errors; by hand it is 1_000_000.
/// timeout : float, optional
///     How long a board may think before it answers, s; the wire's time, by the line rate, is
///     added. By default 0.002, and 0.02 for ``"sim"``, whose boards share the machine's cores.
/// retries : int, default 3
///     How often a board that did not answer is asked again before an exception says so, 0 to 100.
///     A desktop that is busy for some milliseconds makes an answer late.
/// max_kpa : float, optional
///     Highest set point of every channel, kPa gauge: what is above it is refused.
/// max_rate_kpa_s : float, optional
///     Fastest change of every set point, kPa/s, rising or falling; venting is not slowed down. A
///     poller ramps what is faster; by hand it is refused.
/// rig : str or os.PathLike, optional
///     Rig file (TOML, docs/rig.md) with port, boards, line rate, calibration of the sensors, and
///     limits. Of several limits the strictest holds.
/// resume : bool, default False
///     Whether a poller follows its set points again, by a ramp, after a port that was gone has
///     come back. Otherwise boards stay vented until ``Poller.release`` is called.
/// sensors : float, optional
///     After which share of its polls, above 0 to 1, a poller asks boards for a page of the sensors
///     on their I2C connector (supply pressure, IMU) as well; none by default. Each page takes the
///     bus as long as a poll.
/// timing : {"wire", "instant"}, default "wire"
///     Only for ``"sim"``: whether bytes take as long as on a wire.
///
/// Raises
/// ------
/// PortError
///     The port does not exist, is used by another process, or may not be opened.
/// CommandError
///     An argument that makes no sense.
/// DataError, FileError
///     The rig file cannot be used or read.
///
/// Notes
/// -----
/// All boards are commanded to 0 kPa and the port is closed when the ``with`` block ends, by
/// ``close``, when the controller is deleted, and when the interpreter ends (also by ``sys.exit``,
/// an exception or Ctrl-C). A poller is ended by the same. Python cannot do so when it is killed,
/// as by SIGTERM unless a handler calls ``sys.exit``: then boards vent by their own command
/// timeout, and boards without one keep their pressure. A forked child cannot use the controller,
/// and its end changes nothing.
///
/// All methods may be called from several threads; exchanges then wait for each other. Ctrl-C ends
/// every wait.
#[pyclass(frozen, module = "pneudrive_py")]
pub struct PressureController {
    link: Arc<Link>,
    retries: u32,
    resume: bool,
    timeout_s: f64,
    line_rate: Option<LineRatePolicy>,
    sensors: Option<PageShare>,
}

impl PressureController {
    /// Refuses in a forked child.
    fn link(&self) -> PyResult<&Link> {
        self.link.owner().check("controller")?;
        Ok(&self.link)
    }

    /// Settings of a poller.
    fn polled(&self, rate_hz: Option<f64>, history_s: f64) -> PyResult<PollerSettings> {
        let settings = PollerSettings::new(self.link.devices(), rate_hz, history_s)?;
        Ok(PollerSettings { line_rate: self.line_rate, sensors: self.sensors, ..settings })
    }
}

impl Drop for PressureController {
    fn drop(&mut self) {
        if self.link.owner().is_other_process() {
            return;
        }
        let close = || self.link.close("its controller was deleted", Signals::Left);
        // Nobody can be told of what an interpreter at its end, or an object that is destroyed,
        // could say.
        let _ = Python::try_attach(|py| py.detach(close));
    }
}

#[pymethods]
impl PressureController {
    #[new]
    #[pyo3(signature = (uart_port=None, num_devices=None, *, max_devices=4, baud=None, timeout=None, retries=3, max_kpa=None, max_rate_kpa_s=None, rig=None, resume=false, sensors=None, timing="wire"))]
    #[allow(clippy::too_many_arguments)] // keywords of the Python class
    fn new(
        py: Python<'_>,
        uart_port: Option<PathBuf>,
        num_devices: Option<i64>,
        max_devices: i64,
        baud: Option<Baud>,
        timeout: Option<f64>,
        retries: i64,
        max_kpa: Option<f64>,
        max_rate_kpa_s: Option<f64>,
        rig: Option<PathBuf>,
        resume: bool,
        sensors: Option<f64>,
        timing: &str,
    ) -> PyResult<Self> {
        let given = Given {
            uart_port,
            num_devices,
            max_devices,
            baud,
            timeout,
            retries,
            max_kpa,
            max_rate_kpa_s,
            rig,
        };
        let Opening { path, devices, options, rules, retries, line_rate } = given.checked(py)?;
        let timing = opening::timing(timing)?;
        let sensors = sensors::share(sensors)?;
        let timeout_s = options.answer_allowance.as_secs_f64();
        if live::has(py, &path) {
            return Err(held_by_us(&path));
        }
        let link = py.detach(|| Link::open(Port::new(path, devices, options, timing)?, devices, rules))?;
        let link = Arc::new(link);
        live::add(py, &link);
        Ok(Self { link, retries, resume, timeout_s, line_rate, sensors })
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
        by_hand::ping(py, self.link()?, timeout)?;
        Ok(true)
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
    ///     A pressure that cannot or may not be commanded, a change that is too fast, a wrong
    ///     shape, or no such board; nothing was sent.
    /// NoAnswerError, GarbledAnswerError
    ///     The exchange failed; ``get_pressure_data`` then has nothing to give.
    #[pyo3(signature = (device: "int", pressures))]
    fn set_pressure_commands(&self, py: Python<'_>, device: i64, pressures: ArrayLike<'_>) -> PyResult<()> {
        let board = commands::board(device, self.link.devices())?;
        let counts = commands::counts(board, &pressures.0, self.link.rules())?;
        by_hand::exchange(py, self.link()?, board, counts, self.retries)?;
        Ok(())
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
    ///     The last exchange with this board failed, there was none yet, or the controller is
    ///     closed.
    #[pyo3(signature = (device: "int"))]
    fn get_pressure_data<'py>(&self, py: Python<'py>, device: i64) -> PyResult<Vector<'py>> {
        let link = self.link()?;
        let board = commands::board(device, link.devices())?;
        if let Some(kpa) = link.reading(board) {
            return Ok(Array(PyArray1::from_slice(py, &kpa)));
        }
        let why = match link.is_polled() {
            true => POLLED,
            false if link.is_closed() => "no current pressures, because this controller is closed",
            false => "no current pressures, because its last exchange failed or there was none yet",
        };
        Err(StaleDataError::new_err((format!("board {board}: {why}"), board)))
    }

    /// Commands all boards, one after the other, and receives all pressures.
    ///
    /// Parameters
    /// ----------
    /// pressures : array_like of float, shape (num_devices, 4), (4,) or ()
    ///     Set points, kPa gauge; four for every board, or one for every channel, if there are no
    ///     more. All are checked before the first is sent.
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
        let link = self.link()?;
        let checked = commands::of_all(link.devices(), &pressures.0, link.rules())?;
        for (board, counts) in &checked {
            link.check_rate(*board, *counts)?;
        }
        by_hand::exchange_all(py, link, checked, self.retries).map(Array)
    }

    /// Commands all boards, one after the other: ``exchange_all`` without its result. A ``Poller``
    /// has the same method.
    ///
    /// Parameters
    /// ----------
    /// pressures : array_like of float, shape (num_devices, 4), (4,) or ()
    ///     Set points, kPa gauge.
    ///
    /// Raises
    /// ------
    /// CommandError, NoAnswerError, GarbledAnswerError
    ///     As for ``exchange_all``.
    fn set_all(&self, py: Python<'_>, pressures: ArrayLike<'_>) -> PyResult<()> {
        self.exchange_all(py, pressures).map(|_| ())
    }

    /// The pressures that all boards sent in their last exchanges.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray of float64, shape (num_devices, 4)
    ///     Measured pressures, kPa gauge; NaN where ``get_pressure_data`` would raise
    ///     StaleDataError.
    fn get_all<'py>(&self, py: Python<'py>) -> PyResult<Matrix<'py>> {
        let link = self.link()?;
        Ok(Array(by_hand::readings(py, link)))
    }

    /// Plays a trajectory: polls all boards in the background, with commands that change over time.
    ///
    /// Parameters
    /// ----------
    /// trajectory : mapping from str to array_like of float, shape (rows,), or path
    ///     ``t_s`` (s, from 0 on, increasing) and any of ``b0_cmd0_kpa`` and so on (board 0,
    ///     channel 0; kPa gauge). A DataFrame or a Recording does as well; so does the path of a
    ///     CSV file or, of a recording, an MCAP file. Channels without a column stay at 0 kPa. All
    ///     of it is checked before anything is sent: a column that looks like a misspelt command
    ///     (``b0_cdm0_kpa``) is refused, those that no recording has are named in a UserWarning.
    /// rate_hz : float, optional
    ///     Cycles per second; as fast as possible by default.
    /// interpolation : {"hold", "linear"}, default "hold"
    ///     Between two rows: the earlier one's commands, or the straight line.
    /// at_end : {"stop", "hold", "repeat"}, default "stop"
    ///     After the last row: 0 kPa and the poller's end, that row's commands, or the first row
    ///     again.
    /// speed : float, default 1.0
    ///     How many times as fast, 0.001 to 1000.
    /// history_s : float, optional
    ///     How much of the past to keep, s, at most 3600; the whole trajectory by default.
    ///
    /// Returns
    /// -------
    /// Poller
    ///     Its ``join`` waits for the end. Set points can be given by hand only after its ``vent``
    ///     and ``release``.
    ///
    /// Raises
    /// ------
    /// DataError, FileError
    ///     The trajectory cannot be used or read; the message names row and column.
    /// CommandError
    ///     A set point above a limit, or an argument that makes no sense.
    /// PortError
    ///     The controller is closed or polled already.
    #[pyo3(signature = (trajectory, rate_hz=None, *, interpolation="hold", at_end="stop", speed=1.0, history_s=None))]
    #[allow(clippy::too_many_arguments)] // keywords of the Python method
    fn play(
        &self,
        py: Python<'_>,
        trajectory: &Bound<'_, PyAny>,
        rate_hz: Option<f64>,
        interpolation: &str,
        at_end: &str,
        speed: f64,
        history_s: Option<f64>,
    ) -> PyResult<Poller> {
        let link = self.link()?;
        let played = trajectory::read(trajectory, link.devices(), link.rules())?;
        let played = trajectory::at_speed(played, speed)?;
        let history_s = history_s.unwrap_or(trajectory::kept_s(&played));
        let settings = self.polled(rate_hz, history_s)?;
        let source = trajectory::source(played, interpolation, at_end, link.devices(), link.rules())?;
        let start = |bus| Session::start(bus, &settings, link.rules(), self.resume, Some(source));
        let session = py.detach(|| link.poll(start))?;
        Ok(Poller::new(session, link.devices()))
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
    ///     Has the bus until it ends: by its ``stop``, by the end of its ``with`` block or of the
    ///     controller's, or when either of the two is deleted. Meanwhile the controller cannot be
    ///     used by hand.
    ///
    /// Raises
    /// ------
    /// PortError
    ///     The controller is closed or polled already.
    #[pyo3(signature = (rate_hz=None, *, history_s=60.0))]
    fn poll(&self, py: Python<'_>, rate_hz: Option<f64>, history_s: f64) -> PyResult<Poller> {
        let link = self.link()?;
        let settings = self.polled(rate_hz, history_s)?;
        let start = |bus| Session::start(bus, &settings, link.rules(), self.resume, None);
        let session = py.detach(|| link.poll(start))?;
        Ok(Poller::new(session, link.devices()))
    }

    /// Ends a poller, commands 0 kPa to all boards and closes the port. Further calls do nothing.
    ///
    /// Raises
    /// ------
    /// PortError
    ///     The port failed before the boards were commanded 0 kPa.
    ///
    /// Warns
    /// -----
    /// VentWarning
    ///     A board did not confirm 0 kPa.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let link = self.link()?;
        let vented = py.detach(|| link.close("its controller was closed", Signals::Handled))?;
        live::tell(py, vented.as_ref())
    }

    /// Number of boards.
    #[getter]
    fn num_devices(&self) -> u16 {
        self.link.devices()
    }

    /// How long a board may think before it answers, s.
    #[getter]
    fn timeout(&self) -> f64 {
        self.timeout_s
    }

    /// The port's path; for virtual boards that of their pty.
    #[getter]
    fn port(&self) -> PathBuf {
        self.link.path().to_owned()
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
        live::leave_block(self.close(py), py, exc_type)
    }

    fn __repr__(&self) -> String {
        let link = &self.link;
        let state = match link.owner().is_other_process() {
            true => ", of another process",
            false if link.is_closed() => ", closed",
            false if link.is_polled() => ", polled",
            false => "",
        };
        format!("<PressureController {:?}, {}{state}>", link.path(), commands::counted(link.devices()))
    }
}
