"""
The compiled part of `pneudrive_py`; import that.
"""

from _typeshed import SupportsGetItem
from collections.abc import Iterator
from numpy import bool_, float64
from numpy.typing import ArrayLike, DTypeLike, NDArray
from os import PathLike
from pathlib import Path
from typing import Any, Final, SupportsFloat, SupportsIndex, final
__version__: Final[str]

__all__ = ["__version__", "_record", "_run_program", "Comparison", "Diagnosis", "ExtendedModel", "Fit", "Parameters", "Poller", "PressureController", "Recording", "Rig", "Simulation", "Stepper", "batch_gradient", "compare", "diagnose", "effects", "fit", "load", "model_parameters", "simulate", "simulate_batch"]

@final
class Comparison:
    """
    Models fitted on one part of a recording and judged on the rest.
    """
    def __reduce__(self, /) -> tuple[Any, tuple[bytes]]: ...
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str: ...
    @staticmethod
    def _unpickle(state: bytes) -> Comparison: ...
    def html(self, /) -> str:
        """
        The page with tables and plots, one self-contained HTML file's content.
        """
    def plot(self, /, channel: Any | None = None, **options) -> Any:
        """
        Draws the measured pressures of the judging part and every model's (needs matplotlib): see ``pneudrive_py.plots.comparison``, which takes the same keywords.

        Returns
        -------
        matplotlib.figure.Figure
        """
    @property
    def ranking(self, /) -> list[str]:
        """
        Models, best first by the rollout error on the judging part.
        """
    def residuals(self, /, channel: str, model: str) -> dict[str, NDArray[float64]]:
        """
        Measured and simulated pressures of one model on one channel, over the judging part where they can be compared.

        Parameters
        ----------
        channel : str
            Such as ``"b0c1"``.
        model : str
            ``"linear"``, ``"nonlinear"`` or ``"parametric"``.

        Returns
        -------
        dict
            ``t_s``, ``measured_kpa``, ``simulated_kpa`` and ``residual_kpa`` (measured - simulated): float64 arrays of shape
            (compared rows,).
        """
    def save(self, /, path: str | PathLike[str]) -> None:
        """
        Writes the page to a file.

        Raises
        ------
        FileError
            It cannot be written.
        """
    @property
    def table(self, /) -> dict[str, Any]:
        """
        One row per channel and model, as ``pandas.DataFrame`` takes it: columns ``channel``, ``model``, ``rollout_rmse_kpa``,
        ``rollout_r2``, ``rollout_iae_kpa_s``, ``one_step_r2``, ``error`` (why there is no result, else ``None``).
        """
    def to_dict(self, /) -> Any:
        """
        Everything, as dictionaries.
        """
    def trace(self, /, channel: str, model: str) -> tuple[NDArray[float64], NDArray[float64]]:
        """
        The rollout of one model over the judging part.

        Parameters
        ----------
        channel : str
            Such as ``"b0c1"``.
        model : str
            ``"linear"``, ``"nonlinear"`` or ``"parametric"``.

        Returns
        -------
        time_s : numpy.ndarray of float64, shape (rows,)
        pressure_kpa : numpy.ndarray of float64, shape (rows,)
            kPa gauge; NaN where nothing was simulated.
        """

@final
class Diagnosis:
    """
    What a simulation gets wrong in a recording, why, and what modelling it gains.
    """
    def __reduce__(self, /) -> tuple[Any, tuple[bytes]]: ...
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str: ...
    @staticmethod
    def _unpickle(state: bytes) -> Diagnosis: ...
    @property
    def alternatives(self, /) -> Any:
        """
        Explanations of the recordings, the most probable first: dictionaries with ``causes`` (ids of effects, ``"none"``,
        ``"something_else"``), ``probability`` and ``select_rmse_kpa``, kPa.
        """
    @property
    def causes(self, /) -> Any:
        """
        The causes that were named, in the order of the gain: dictionaries with ``effect``, ``channels``, ``equivalent`` (effects
        that explain the recording as well), ``parameters`` (``value``, ``ci95``, ``unit``), ``by_channel`` (the same, channel by channel),
        ``p_value``, ``gain``, and ``probability`` (of all ``alternatives`` with it, 0 to 1) where explanations were weighed.
        """
    @property
    def channels(self, /) -> list[str]:
        """
        Names of the channels.
        """
    @property
    def extended_model(self, /) -> ExtendedModel:
        """
        The model with the causes: ``simulate`` and ``diagnose(reference=...)`` take it. Of several recordings of one machine the first's.
        """
    @property
    def extended_models(self, /) -> dict[str, ExtendedModel]:
        """
        The models with the causes by the names of the files that ``save`` writes: ``extended.toml``, or of several recordings of one
        machine one for each, such as ``extended-arm1.toml``, in the order of the recordings. ``simulate(recording, model)`` gives the
        residuals of one; any of them as ``diagnose(machine=...)`` says what valves, supply and sensor are.
        """
    def html(self, /) -> str:
        """
        The page with tables and plots, one self-contained HTML file's content.
        """
    @property
    def machine(self, /) -> Any:
        """
        The machine, where several recordings of one or one of a known one were diagnosed as such, else ``None``: ``known`` (were
        valves, supply and sensor given?), ``joint_rmse_before_kpa``, ``joint_rmse_after_kpa`` and ``recordings``, a list of
        dictionaries with ``file``, errors and discrepancies (kPa), ``load`` (by channel; ``value``, ``ci95``, ``unit``) and
        ``extended_model``, a key of ``extended_models``.
        """
    @property
    def notes(self, /) -> list[str]:
        """
        What was noticed about the data.
        """
    def plot(self, /, channel: Any | None = None, **options) -> Any:
        """
        Draws measured pressures and the residuals without and with the causes, test blocks shaded; of a machine the errors and loads of
        its recordings (needs matplotlib): see ``pneudrive_py.plots.diagnosis``, which takes the same keywords.

        Returns
        -------
        matplotlib.figure.Figure
        """
    @property
    def report_dict(self, /) -> Any:
        """
        The whole of ``report.json`` as a dictionary.
        """
    def residuals(self, /, channel: str) -> dict[str, Any]:
        """
        Measured pressures of one channel and residuals, where they were compared.

        Parameters
        ----------
        channel : str
            Such as ``"b0c1"``.

        Returns
        -------
        dict
            ``t_s`` (from the start of the recording), ``measured_kpa``, and the residuals (measured - simulated, kPa) ``base`` of the model
            without the causes and ``extended`` with them: float64 arrays of shape (compared rows,). ``role``: array of str, what the row
            was used for: ``"fit"`` (parameters), ``"select"`` (causes) or ``"test"`` (the gain, nothing else).

        Raises
        ------
        DataError
            There is no such channel, or a machine was diagnosed: ``simulate`` with one of ``extended_models`` gives its residuals.
        """
    def save(self, /, folder: str | PathLike[str]) -> None:
        """
        Writes ``report.html``, ``report.json`` and ``extended_models`` into a folder, as ``pneudrive-model diagnose`` does, and
        ``next_experiment.csv`` where another recording would tell rivals apart.

        Raises
        ------
        FileError
            They cannot be written.
        """
    @property
    def sentence(self, /) -> str:
        """
        What was found, in a sentence.
        """
    @property
    def verdict(self, /) -> Any:
        """
        In a word: ``"adequate"``, ``"explained"``, ``"partly_explained"`` or ``"unexplained"``.
        """

@final
class ExtendedModel:
    """
    A model with the effects that a diagnosis found, for the channels of one rig.

    ``Diagnosis.extended_model``, or what ``ExtendedModel.load`` reads. ``simulate`` simulates it; as ``diagnose(reference=...)`` it is
    what a later recording of the same rig is compared with.
    """
    def __reduce__(self, /) -> tuple[Any, tuple[bytes]]: ...
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str: ...
    @staticmethod
    def _unpickle(state: bytes) -> ExtendedModel: ...
    @property
    def channels(self, /) -> list[str]:
        """
        Names of the channels, such as ``"b0c1"``.
        """
    def effects(self, /, channel: str) -> dict[str, dict[str, float]]:
        """
        Effects at work in a channel, and by name their parameters in the units of ``effects``.
        """
    @staticmethod
    def load(path: str | PathLike[str]) -> ExtendedModel:
        """
        Reads ``extended.toml`` of a diagnosis, or a parameter file that ``Parameters.save`` wrote: a model without effects.

        Raises
        ------
        DataError
            It is neither, or holds what a diagnosis does not simulate.
        FileError
            It cannot be read.
        """
    @property
    def model(self, /) -> str:
        """
        The base model: ``"nonlinear"`` or ``"linear"``.
        """
    @property
    def rig(self, /) -> Rig:
        """
        The rig that it was fitted with.
        """
    def save(self, /, path: str | PathLike[str]) -> None:
        """
        Writes the file (TOML), which ``pneudrive-model simulate`` and ``diagnose --reference`` read too.

        Raises
        ------
        FileError
            It cannot be written.
        """
    def to_dict(self, /) -> Any:
        """
        All that the file holds, as dictionaries.
        """
    def to_toml(self, /) -> str:
        """
        The file's text (TOML).
        """
    def values(self, /, channel: str) -> dict[str, float]:
        """
        Parameters of a channel's base model by name, in the units of ``model_parameters``.
        """

@final
class Fit:
    """
    The fit of one model to the channels of a recording.
    """
    def __reduce__(self, /) -> tuple[Any, tuple[bytes]]: ...
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str: ...
    @staticmethod
    def _unpickle(state: bytes) -> Fit: ...
    @property
    def channels(self, /) -> list[str]:
        """
        Names of the fitted channels.
        """
    def covariance(self, /, channel: str) -> tuple[list[str], NDArray[float64]]:
        """
        Names of a channel's free parameters, and their covariance.

        Returns
        -------
        names : list of str
        covariance : numpy.ndarray of float64, shape (free, free)
            In the parameters' units, corrected for correlated residuals; infinite where the data determine nothing.
        """
    @property
    def fit_seconds(self, /) -> float:
        """
        Length of the part that was fitted, s, from the first row on.
        """
    @property
    def fitted(self, /) -> dict[str, dict[str, Any] | None]:
        """
        Errors of the rollouts on the fitted part, by channel: dictionaries with ``r2``, ``rmse_kpa``, ``mae_kpa``,
        ``iae_kpa_s`` (integral of the absolute error), ``largest_kpa``, ``samples``, ``seconds``.
        """
    @property
    def held_out(self, /) -> dict[str, dict[str, Any] | None]:
        """
        The same on the rest of the recording; ``None`` where everything was fitted.
        """
    @property
    def parameters(self, /) -> Parameters:
        """
        The parameters, as ``simulate`` takes them.
        """
    def plot(self, /, channels: Any | None = None, **options) -> Any:
        """
        Draws measured and simulated pressures, the fitted part shaded, and their difference (needs matplotlib): see ``pneudrive_py.plots.fit``, which takes the same keywords.

        Returns
        -------
        matplotlib.figure.Figure
        """
    @property
    def recording(self, /) -> Recording:
        """
        The recording that was fitted.
        """
    def residuals(self, /, channel: str) -> Any:
        """
        Measured and simulated pressures of one channel where they can be compared.

        Parameters
        ----------
        channel : str
            Such as ``"b0c1"``.

        Returns
        -------
        dict
            ``t_s``, ``measured_kpa``, ``simulated_kpa`` and ``residual_kpa`` (measured - simulated): float64 arrays of shape
            (compared rows,); ``role``: array of str, ``"fit"`` where the parameters were fitted and ``"held out"`` where they were not.
        """
    def save(self, /, path: str | PathLike[str]) -> None:
        """
        Writes the parameters to a file (TOML), as ``Parameters.save``.
        """
    def to_dict(self, /) -> dict[str, Any]:
        """
        Everything about the fits, by channel: parameters with intervals, starts, what is not determined and why.
        """

@final
class Parameters:
    """
    Fitted parameters of one or more channels, with the rig they were fitted with and where they came from.
    """
    def __reduce__(self, /) -> tuple[Any, tuple[bytes]]: ...
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str: ...
    @staticmethod
    def _unpickle(state: bytes) -> Parameters: ...
    def array(self, /, channel: str) -> NDArray[float64]:
        """
        The same as a float64 array of shape (parameters,), as ``simulate_batch`` takes it.
        """
    @property
    def channels(self, /) -> list[str]:
        """
        Names of the channels, such as ``"b0c1"``.
        """
    @staticmethod
    def load(path: str | PathLike[str]) -> Parameters:
        """
        Reads a parameter file (TOML), such as ``save`` or ``pneudrive-model fit`` wrote.

        Raises
        ------
        DataError
            It is no parameter file.
        FileError
            It cannot be read.
        """
    def model(self, /, channel: str) -> str:
        """
        The model of a channel: ``"linear"``, ``"nonlinear"`` or ``"parametric"``.
        """
    @property
    def rig(self, /) -> Rig:
        """
        The rig that the parameters were fitted with.
        """
    def save(self, /, path: str | PathLike[str]) -> None:
        """
        Writes a parameter file (TOML), which ``pneudrive-model simulate`` reads too.

        Raises
        ------
        FileError
            It cannot be written.
        """
    def to_dict(self, /) -> Any:
        """
        All that the file holds, as dictionaries.
        """
    def values(self, /, channel: str) -> dict[str, float]:
        """
        The parameters of a channel by name, in the model's order and units (see ``model_parameters``).
        """

@final
class Poller:
    """
    Polls all boards of a controller in the background; made by ``PressureController.poll``.

    Set points may be changed and pressures read at any time, from any thread, without waiting for the bus. When it is stopped,
    its ``with`` block or its controller's ends, or it is deleted, all boards are commanded to 0 kPa, and the controller can be used by
    hand again.
    """
    def __enter__(self, /) -> Poller: ...
    def __exit__(self, /, exc_type: Any, _exc_value: Any, _traceback: Any) -> None: ...
    def __repr__(self, /) -> str: ...
    def get_all(self, /) -> NDArray[float64]:
        """
        The newest pressures of all boards.

        Returns
        -------
        numpy.ndarray of float64, shape (num_devices, 4)
            Measured pressures, kPa gauge; NaN where ``get_pressure_data`` would raise StaleDataError.
        """
    def get_pressure_data(self, /, device: "int") -> NDArray[float64]:
        """
        The newest pressures of one board.

        Parameters
        ----------
        device : int
            Board number, from 0.

        Returns
        -------
        numpy.ndarray of float64, shape (4,)
            Measured pressures of channels 0 to 3, kPa gauge.

        Raises
        ------
        StaleDataError
            The board did not answer in the last cycle in which it was asked, or has never answered.
        """
    def get_sensors(self, /) -> dict[str, Any]:
        """
        The last readings of the sensors on the boards' I2C connectors, where the controller was made with ``sensors``.

        Returns
        -------
        dict
            ``supply_kpa``: shape (num_devices,), supply pressure, kPa gauge; ``acceleration_m_s2`` and ``angular_rate_rad_s``: shape
            (num_devices, 3), along and about the axes of the IMU, gravity included; ``chip_c`` and ``rail_v``: shape (num_devices,),
            temperature of the board's chip, degrees Celsius, and voltage of its connector's 5 V, both asked for once a second. NaN where a
            board has no such part, or it is not live.
        """
    def history(self, /) -> dict[str, NDArray[float64]]:
        """
        What happened in the time that is kept.

        Returns
        -------
        dict
            ``t_s``: shape (n,), start of each cycle, s from the first; ``commands_kpa`` and ``pressures_kpa``: shape
            (n, num_devices, 4), kPa gauge, NaN where a board did not answer in that cycle. With the controller's ``sensors`` also
            ``supply_kpa``, ``chip_c`` and ``rail_v``, shape (n, num_devices), ``acceleration_m_s2`` and ``angular_rate_rad_s``, shape
            (n, num_devices, 3), NaN where they were not read in that cycle.
        """
    def join(self, /, timeout: SupportsFloat | SupportsIndex | None = None) -> bool:
        """
        Waits until polling ends: because a trajectory has come to its end, or by ``stop``.

        Parameters
        ----------
        timeout : float, optional
            How long to wait at most, s; for ever by default.

        Returns
        -------
        bool
            Whether it has ended.

        Raises
        ------
        PortError
            The port failed while polling.

        Warns
        -----
        VentWarning
            A board did not confirm 0 kPa.
        """
    def release(self, /) -> None:
        """
        Follows set points again after ``vent``, or after a port that was gone has come back. What was commanded before does not return:
        all set points are 0 kPa until they are set. Does nothing if the boards are not vented.
        """
    def set_all(self, /, pressures: ArrayLike) -> None:
        """
        Changes the set points of all boards, from their next exchanges on.

        Parameters
        ----------
        pressures : array_like of float, shape (num_devices, 4), (4,) or ()
            Set points, kPa gauge; four for every board, or one for every channel, if there are no more. All are checked before the
            first is changed.

        Raises
        ------
        CommandError, PortError
            As for ``set_pressure_commands``; the old set points stand.
        """
    def set_pressure_commands(self, /, device: "int", pressures: ArrayLike) -> None:
        """
        Changes the set points of one board, from its next exchange on.

        Parameters
        ----------
        device : int
            Board number, from 0.
        pressures : array_like of float, shape (4,)
            Set points of channels 0 to 3, kPa gauge.

        Raises
        ------
        CommandError
            A pressure that cannot or may not be commanded, a wrong shape, no such board, or the boards are vented; the old set points
            stand.
        PortError
            The poller has ended.
        """
    def statistics(self, /) -> dict[str, Any] | None:
        """
        What the run has been like.

        Returns
        -------
        dict or None
            ``devices``, ``seconds``, ``baud`` (line rate in effect), ``cycles``, ``exchanges``, ``lost``, ``rejected``, ``missed_ticks``; ``loop_hz`` (``mean``, ``std``, ``min``);
            ``cycle_us`` (``p50``, ``p99``, ``p999``, ``max``); ``cpu_share`` of one core. Figures are those of the last time somebody
            asked; the first call waits for them. None if no cycle ends in the meantime (1 s).
        """
    def stop(self, /) -> None:
        """
        Commands 0 kPa to all boards and gives the bus back to the controller. Further calls do nothing.

        Raises
        ------
        PortError
            The port failed while polling.

        Warns
        -----
        VentWarning
            A board did not confirm 0 kPa.
        """
    def vent(self, /) -> None:
        """
        Commands 0 kPa to all boards at once, until ``release``; polling goes on.

        Raises
        ------
        PortError
            The poller has ended; its boards were commanded 0 kPa then.
        """
    @property
    def vented(self, /) -> bool:
        """
        Whether 0 kPa is commanded until ``release``: by ``vent``, or because the port was gone and has come back.
        """
    def wait(self, /, after: SupportsIndex | None = None, *, timeout: SupportsFloat | SupportsIndex = 1.0) -> dict[str, Any]:
        """
        Waits for a cycle of the bus and returns it.

        Parameters
        ----------
        after : int, optional
            Number of a cycle; the returned one is a later one. By default the one that is current when this is called.
        timeout : float, default 1.0
            How long to wait at most, s.

        Returns
        -------
        dict
            ``cycle``: its number, from 0; ``t_s``: start of the cycle, s from the first; ``commands_kpa`` and ``pressures_kpa``: shape
            (num_devices, 4), kPa gauge, NaN where a board did not answer in that cycle.

        Raises
        ------
        PortError
            The poller has ended.
        PneuDriveError
            No new cycle in that time.
        """

@final
class PressureController:
    """
    Host of up to 255 boards with four chambers each, on one serial port.

    Parameters
    ----------
    uart_port : str or os.PathLike, optional
        Serial port, such as ``"/dev/ttyUSB0"``, or ``"sim"`` for virtual boards with chambers behind them; that of ``rig`` by default.
    num_devices : int, optional
        Boards on the bus; their address switches are set to 0, 1, ... 1 to ``max_devices``; as many as ``rig`` says by default.
    max_devices : int, default 4
        Most boards that are accepted, 1 to 255: 4 have an address on the boards' two-way switch.
    baud : int or "auto", optional
        Line rate, bit/s; that of ``rig``, or 1_000_000 by default. ``"auto"`` polls at the fastest that all boards agree to, up to
        3_000_000, and goes back on errors; by hand it is 1_000_000.
    timeout : float, optional
        How long a board may think before it answers, s; the wire's time, by the line rate, is added. By default 0.002, and 0.02 for
        ``"sim"``, whose boards share the machine's cores.
    retries : int, default 3
        How often a board that did not answer is asked again before an exception says so, 0 to 100. A desktop that is busy for some
        milliseconds makes an answer late.
    max_kpa : float, optional
        Highest set point of every channel, kPa gauge: what is above it is refused.
    max_rate_kpa_s : float, optional
        Fastest change of every set point, kPa/s, rising or falling; venting is not slowed down. A poller ramps what is faster; by hand
        it is refused.
    rig : str or os.PathLike, optional
        Rig file (TOML, docs/rig.md) with port, boards, line rate, calibration of the sensors, and limits. Of several limits the
        strictest holds.
    resume : bool, default False
        Whether a poller follows its set points again, by a ramp, after a port that was gone has come back. Otherwise boards stay
        vented until ``Poller.release`` is called.
    sensors : float, optional
        After which share of its polls, above 0 to 1, a poller asks boards for a page of the sensors on their I2C connector (supply pressure,
        IMU) as well; none by default. Each page takes the bus as long as a poll.
    timing : {"wire", "instant"}, default "wire"
        Only for ``"sim"``: whether bytes take as long as on a wire.

    Raises
    ------
    PortError
        The port does not exist, is used by another process, or may not be opened.
    CommandError
        An argument that makes no sense.
    DataError, FileError
        The rig file cannot be used or read.

    Notes
    -----
    All boards are commanded to 0 kPa and the port is closed when the ``with`` block ends, by ``close``, when the controller is
    deleted, and when the interpreter ends (also by ``sys.exit``, an exception or Ctrl-C). A poller is ended by the same. Python cannot
    do so when it is killed, as by SIGTERM unless a handler calls ``sys.exit``: then boards vent by their own command timeout, and
    boards without one keep their pressure. A forked child cannot use the controller, and its end changes nothing.

    All methods may be called from several threads; exchanges then wait for each other. Ctrl-C ends every wait.
    """
    def __enter__(self, /) -> PressureController: ...
    def __exit__(self, /, exc_type: Any, _exc_value: Any, _traceback: Any) -> None: ...
    def __new__(cls, /, uart_port: str | PathLike[str] | None = None, num_devices: SupportsIndex | None = None, *, max_devices: SupportsIndex = 4, baud: SupportsIndex | str | None = None, timeout: SupportsFloat | SupportsIndex | None = None, retries: SupportsIndex = 3, max_kpa: SupportsFloat | SupportsIndex | None = None, max_rate_kpa_s: SupportsFloat | SupportsIndex | None = None, rig: str | PathLike[str] | None = None, resume: bool = False, sensors: SupportsFloat | SupportsIndex | None = None, timing: str = "wire") -> PressureController: ...
    def __repr__(self, /) -> str: ...
    def close(self, /) -> None:
        """
        Ends a poller, commands 0 kPa to all boards and closes the port. Further calls do nothing.

        Raises
        ------
        PortError
            The port failed before the boards were commanded 0 kPa.

        Warns
        -----
        VentWarning
            A board did not confirm 0 kPa.
        """
    def exchange_all(self, /, pressures: ArrayLike) -> NDArray[float64]:
        """
        Commands all boards, one after the other, and receives all pressures.

        Parameters
        ----------
        pressures : array_like of float, shape (num_devices, 4), (4,) or ()
            Set points, kPa gauge; four for every board, or one for every channel, if there are no more. All are checked before the
            first is sent.

        Returns
        -------
        numpy.ndarray of float64, shape (num_devices, 4)
            Measured pressures, kPa gauge.

        Raises
        ------
        CommandError
            Nothing was sent.
        NoAnswerError, GarbledAnswerError
            The first exchange that failed; the boards after it were still commanded.
        """
    def get_all(self, /) -> NDArray[float64]:
        """
        The pressures that all boards sent in their last exchanges.

        Returns
        -------
        numpy.ndarray of float64, shape (num_devices, 4)
            Measured pressures, kPa gauge; NaN where ``get_pressure_data`` would raise StaleDataError.
        """
    def get_pressure_data(self, /, device: "int") -> NDArray[float64]:
        """
        The pressures that one board sent in its last exchange.

        Parameters
        ----------
        device : int
            Board number, from 0.

        Returns
        -------
        numpy.ndarray of float64, shape (4,)
            Measured pressures of channels 0 to 3, kPa gauge.

        Raises
        ------
        StaleDataError
            The last exchange with this board failed, there was none yet, or the controller is closed.
        """
    @property
    def num_devices(self, /) -> int:
        """
        Number of boards.
        """
    def ping_devices(self, /, timeout: SupportsFloat | SupportsIndex = 5.0) -> bool:
        """
        Asks every board whether it is there, by commanding 0 kPa, until all have answered.

        Parameters
        ----------
        timeout : float, default 5.0
            How long to go on asking, s.

        Returns
        -------
        bool
            True. A board that did not answer is an exception.

        Raises
        ------
        NoAnswerError
            A board did not answer in time; ``board`` is the first such board's number.
        """
    def play(self, /, trajectory: Any, rate_hz: SupportsFloat | SupportsIndex | None = None, *, interpolation: str = "hold", at_end: str = "stop", speed: SupportsFloat | SupportsIndex = 1.0, history_s: SupportsFloat | SupportsIndex | None = None) -> Poller:
        """
        Plays a trajectory: polls all boards in the background, with commands that change over time.

        Parameters
        ----------
        trajectory : mapping from str to array_like of float, shape (rows,), or path
            ``t_s`` (s, from 0 on, increasing) and any of ``b0_cmd0_kpa`` and so on (board 0, channel 0; kPa gauge). A DataFrame or a
            Recording does as well; so does the path of a CSV file or, of a recording, an MCAP file. Channels without a column stay at
            0 kPa. All of it is checked before anything is sent: a column that looks like a misspelt command (``b0_cdm0_kpa``) is refused, those
            that no recording has are named in a UserWarning.
        rate_hz : float, optional
            Cycles per second; as fast as possible by default.
        interpolation : {"hold", "linear"}, default "hold"
            Between two rows: the earlier one's commands, or the straight line.
        at_end : {"stop", "hold", "repeat"}, default "stop"
            After the last row: 0 kPa and the poller's end, that row's commands, or the first row again.
        speed : float, default 1.0
            How many times as fast, 0.001 to 1000.
        history_s : float, optional
            How much of the past to keep, s, at most 3600; the whole trajectory by default.

        Returns
        -------
        Poller
            Its ``join`` waits for the end. Set points can be given by hand only after its ``vent`` and ``release``.

        Raises
        ------
        DataError, FileError
            The trajectory cannot be used or read; the message names row and column.
        CommandError
            A set point above a limit, or an argument that makes no sense.
        PortError
            The controller is closed or polled already.
        """
    def poll(self, /, rate_hz: SupportsFloat | SupportsIndex | None = None, *, history_s: SupportsFloat | SupportsIndex = 60.0) -> Poller:
        """
        Polls all boards in the background, at a fixed rate or as fast as possible.

        Parameters
        ----------
        rate_hz : float, optional
            Cycles per second; as fast as possible by default.
        history_s : float, default 60.0
            How much of the past to keep, s.

        Returns
        -------
        Poller
            Has the bus until it ends: by its ``stop``, by the end of its ``with`` block or of the controller's, or when either of the
            two is deleted. Meanwhile the controller cannot be used by hand.

        Raises
        ------
        PortError
            The controller is closed or polled already.
        """
    @property
    def port(self, /) -> Path:
        """
        The port's path; for virtual boards that of their pty.
        """
    def set_all(self, /, pressures: ArrayLike) -> None:
        """
        Commands all boards, one after the other: ``exchange_all`` without its result. A ``Poller`` has the same method.

        Parameters
        ----------
        pressures : array_like of float, shape (num_devices, 4), (4,) or ()
            Set points, kPa gauge.

        Raises
        ------
        CommandError, NoAnswerError, GarbledAnswerError
            As for ``exchange_all``.
        """
    def set_pressure_commands(self, /, device: "int", pressures: ArrayLike) -> None:
        """
        Commands four pressures to one board and receives its four pressures.

        Parameters
        ----------
        device : int
            Board number, from 0.
        pressures : array_like of float, shape (4,)
            Set points of channels 0 to 3, kPa gauge, 0 to 689.4757.

        Raises
        ------
        CommandError
            A pressure that cannot or may not be commanded, a change that is too fast, a wrong shape, or no such board; nothing was
            sent.
        NoAnswerError, GarbledAnswerError
            The exchange failed; ``get_pressure_data`` then has nothing to give.
        """
    @property
    def timeout(self, /) -> float:
        """
        How long a board may think before it answers, s.
        """

@final
class Recording:
    """
    Measured data after checking: time increases, doubtful samples are masked and named.

    Made by ``load`` or ``Recording.from_columns``. Columns have the names of the file format, such as ``b0_p1_kpa`` for the
    pressure of board 0, channel 1. Pressures are in kPa gauge, times in s, angles in rad, drives from -1 (vent) to 1 (fill).

    It behaves as a table whose rows are counted and whose columns are named, as a DataFrame does: ``recording["b0_p1_kpa"]`` is a
    column, a float64 array of shape (rows,); ``in``, ``for``, ``keys``, ``values``, ``items`` and ``get`` are about columns; ``len`` is
    the number of rows. ``dict(recording)`` holds all columns. It cannot be changed; it can be pickled.
    """
    def __contains__(self, column: Any, /) -> bool: ...
    def __getitem__(self, column: str, /) -> NDArray[float64]: ...
    def __iter__(self, /) -> Iterator: ...
    def __len__(self, /) -> int: ...
    def __reduce__(self, /) -> tuple[Any, tuple[bytes]]: ...
    def __repr__(self, /) -> str: ...
    def _ipython_key_completions_(self, /) -> list[str]: ...
    def _repr_html_(self, /) -> str: ...
    @staticmethod
    def _unpickle(state: bytes) -> Recording: ...
    def between(self, /, start_s: SupportsFloat | SupportsIndex | None = None, stop_s: SupportsFloat | SupportsIndex | None = None) -> Recording:
        """
        The rows of a stretch of time.

        Parameters
        ----------
        start_s, stop_s : float, optional
            From the first row at or after ``start_s`` to the last before ``stop_s``, on the scale of ``time_s``; by default from the
            first row, and to the last.

        Returns
        -------
        Recording
            Times stay what they are; masked samples stay masked.

        Raises
        ------
        DataError
            Fewer than two rows are left.
        """
    @property
    def channels(self, /) -> list[str]:
        """
        Names of the channels, such as ``"b0c1"``: board 0, channel 1.
        """
    @property
    def columns(self, /) -> list[str]:
        """
        Names of the columns that are there, time first.
        """
    @property
    def duration_s(self, /) -> float:
        """
        Time from the first row to the last, s.
        """
    @property
    def events(self, /) -> Any:
        """
        What happened while it was recorded, as the file says: dictionaries with ``t_s`` (s, as ``time_s``), ``kind`` and ``text``. Empty
        where the file says nothing.
        """
    @property
    def file(self, /) -> str:
        """
        The file it was read from, or the name it was given.
        """
    @staticmethod
    def from_columns(columns: Any, *, rig: Rig | str | PathLike[str] | None = None, channels: SupportsGetItem[int, str] | None = None, name: str = "columns") -> Recording:
        """
        A recording from arrays.

        Parameters
        ----------
        columns : mapping from str to array_like of float, shape (rows,)
            Columns of the file format: ``t_s``, ``b0_cmd0_kpa``, ``b0_p0_kpa``, ``b0_u0`` and so on. NaN is a missing value.
            A pandas DataFrame does as well.
        rig : Rig or path, optional
            With its sensors, samples at a sensor's limit are found and masked.
        channels : sequence of str, optional
            Channels to keep, such as ``["b0c0"]``; all by default.
        name : str, default "columns"
            What messages call it; they count rows as a file's, the header being row 1.

        Returns
        -------
        Recording

        Raises
        ------
        DataError
            No time, no channel, columns of different lengths, values outside the possible.
        """
    @staticmethod
    def from_history(history: dict, *, rig: Rig | str | PathLike[str] | None = None, channels: SupportsGetItem[int, str] | None = None) -> Recording:
        """
        A recording from what ``Poller.history`` returns: commands and pressures of all boards, cycle by cycle.

        Parameters
        ----------
        history : dict
            ``t_s`` of shape (cycles,), ``commands_kpa`` and ``pressures_kpa`` of shape (cycles, boards, 4), and if it is there ``supply_kpa``
            of shape (cycles, boards).
        rig, channels
            As for ``from_columns``.
        """
    def get(self, /, column: str, default: Any | None = None) -> Any | None:
        """
        A column, or ``default`` where there is none of this name.
        """
    def html(self, /) -> str:
        """
        The page that ``pneudrive-model show`` writes, one self-contained HTML file's content: figures of every channel, plots, events.
        """
    def items(self, /) -> list[tuple[str, NDArray[float64]]]:
        """
        Names and columns.
        """
    def keys(self, /) -> list[str]:
        """
        Names of the columns, as ``columns``.
        """
    def plot(self, /, channels: Any | None = None, **options) -> Any:
        """
        Draws set points and usable pressures (needs matplotlib): see ``pneudrive_py.plots.recording``, which takes the same keywords.

        Returns
        -------
        matplotlib.figure.Figure
        """
    @property
    def quality(self, /) -> list[str]:
        """
        What was noticed about the data, in sentences; masked samples among it.
        """
    @property
    def rate_hz(self, /) -> float:
        """
        Nominal sampling rate, Hz.
        """
    def resample(self, /, rate_hz: SupportsFloat | SupportsIndex) -> Recording:
        """
        The recording at another rate.

        Parameters
        ----------
        rate_hz : float
            Rows per second; they begin anew where time is missing.

        Returns
        -------
        Recording
            Pressures, supply and angles lie on the line between their neighbours, commands and drives hold; what is masked on either
            side is masked. Nothing is filtered: what is faster than half the new rate folds over.

        Raises
        ------
        DataError
            A rate that makes no sense for this recording.
        """
    def save(self, /, path: str | PathLike[str]) -> None:
        """
        Writes the recording to a file: ``.csv``, ``.csv.gz`` or ``.csv.zst``.

        Raises
        ------
        FileError
            The file cannot be written.
        """
    @property
    def time_s(self, /) -> NDArray[float64]:
        """
        Time of each row, s; float64 array of shape (rows,).
        """
    def to_dataframe(self, /) -> Any:
        """
        All columns as a ``pandas.DataFrame`` whose index is the time, s (needs pandas).
        """
    def to_dict(self, /) -> dict[str, NDArray[float64]]:
        """
        All columns by name, as ``pandas.DataFrame`` takes them.
        """
    def to_xarray(self, /) -> Any:
        """
        Pressures, set points and drives as an ``xarray.Dataset`` (needs xarray) with dimensions ``t_s`` and ``channel``, units in the
        attributes; ``usable`` says which pressures may be used.
        """
    def usable(self, /, channel: str) -> NDArray[bool_]:
        """
        Which rows of a channel's pressure may be used: neither missing nor saturated nor stuck.

        Parameters
        ----------
        channel : str
            Such as ``"b0c1"``.

        Returns
        -------
        numpy.ndarray of bool, shape (rows,)
        """
    def values(self, /) -> list[NDArray[float64]]:
        """
        The columns, in the order of ``keys``.
        """

@final
class Rig:
    """
    What a machine is made of: supply, chambers, valves, the boards' control loop, sensors.

    Parameters
    ----------
    **tables : dict
        The tables of a rig file, such as ``supply={"pressure_kpa": 550.0}``: ``supply``, ``ambient``, ``chamber``, ``valve``,
        ``controller``, ``sensor``, and ``boards`` with what boards and channels have of their own, as in
        ``boards={"0": {"channels": {"3": {"chamber": {"volume_m3": 1e-4}}}}}``. All are optional; keys carry their units. See
        ``Rig.load`` for files.

    Raises
    ------
    DataError
        An unknown table or key, or a value outside its range.
    """
    def __eq__(self, other: object, /) -> bool: ...
    def __new__(cls, /, **tables) -> Rig: ...
    def __reduce__(self, /) -> tuple[Any, tuple[str]]:
        """
        Rigs can be sent to other processes.
        """
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str: ...
    def at(self, /, channel: str) -> Rig:
        """
        The machine as one channel has it: of each table the channel's own, else its board's, else that of all.

        Parameters
        ----------
        channel : str
            Such as ``"b0c1"``.

        Returns
        -------
        Rig
            Without ``boards``.
        """
    @staticmethod
    def load(path: str | PathLike[str]) -> Rig:
        """
        Reads a rig file.

        Parameters
        ----------
        path : str or os.PathLike
            A TOML file.

        Returns
        -------
        Rig

        Raises
        ------
        DataError
            An unknown table or key, or a value outside its range; the message names it.
        FileError
            The file cannot be read.
        """
    @staticmethod
    def parse(text: str, name: str = "rig") -> Rig:
        """
        A rig from the text of a rig file.

        Parameters
        ----------
        text : str
            TOML.
        name : str, default "rig"
            What error messages call it.
        """
    def to_dict(self, /) -> Any:
        """
        The tables as a dictionary of dictionaries.
        """
    def to_toml(self, /) -> str:
        """
        The rig file's text (TOML).
        """

@final
class Simulation:
    """
    Simulated pressures of the channels of a recording.
    """
    def __reduce__(self, /) -> tuple[Any, tuple[bytes]]: ...
    def __repr__(self, /) -> str: ...
    def _repr_html_(self, /) -> str: ...
    @staticmethod
    def _unpickle(state: bytes) -> Simulation: ...
    @property
    def band_holds(self, /) -> dict[str, float | None]:
        """
        Share of the measured pressures that the band holds, by channel: 0 to 1, ``None`` where there is no band or nothing was measured.
        """
    @property
    def band_kpa(self, /) -> NDArray[float64]:
        """
        The 95 % band around each simulated pressure, kPa gauge; float64 array of shape (rows, channels, 2): lowest and highest. The models of
        ``diagnose`` have one; NaN for those of a fit, and where the inputs are missing.
        """
    @property
    def channels(self, /) -> list[str]:
        """
        Names of the channels, in the order of ``pressure_kpa``.
        """
    def plot(self, /, channels: Any | None = None, **options) -> Any:
        """
        Draws measured and simulated pressures, and their difference (needs matplotlib): see ``pneudrive_py.plots.simulation``, which takes the same keywords.

        Returns
        -------
        matplotlib.figure.Figure
        """
    @property
    def pressure_kpa(self, /) -> NDArray[float64]:
        """
        Simulated pressures, kPa gauge; float64 array of shape (rows, channels), NaN where the inputs are missing.
        """
    @property
    def recording(self, /) -> Recording:
        """
        The recording with simulated pressures in place of the measured ones.
        """
    def residuals(self, /, channel: str) -> dict[str, NDArray[float64]]:
        """
        Measured and simulated pressures of one channel where they can be compared: where the measured one may be used.

        Parameters
        ----------
        channel : str
            Such as ``"b0c1"``.

        Returns
        -------
        dict
            ``t_s``, ``measured_kpa``, ``simulated_kpa`` and ``residual_kpa`` (measured - simulated): float64 arrays of shape
            (compared rows,).
        """
    @property
    def scores(self, /) -> dict[str, dict[str, Any] | None]:
        """
        Errors against the measured pressures, by channel: dictionaries as in ``Fit.fitted``, ``None`` where nothing was measured.
        """
    @property
    def time_s(self, /) -> NDArray[float64]:
        """
        Time of each row, s; float64 array of shape (rows,).
        """

@final
class Stepper:
    """
    Calibrated channels, simulated step by step: a plant for a controller, or a model that a controller looks ahead with.

    A step is what ``simulate`` does between two rows of a recording, with the same numbers, effects of a diagnosis included. Each channel is
    simulated for itself: what other channels do to it (``chamber_coupling``, ``sensor_crosstalk``, ``supply_sag`` by others) is left
    out. It can be pickled and copied, uses no threads of its own, and may be used in a forked child.

    Parameters
    ----------
    model : Parameters or ExtendedModel
        Such as ``fit(...).parameters`` or ``diagnose(...).extended_model``; one without a smooth correction.
    channels : sequence of str, optional
        Such as ``["b0c0", "b0c1"]``; by default all of the model's.
    step_s : float, default 0.01
        Length of a step, 1e-5 to 1 s; a whole number of the board's loops where a set point drives.
    control : {"calibrated", "drive", "set_point"}, default "calibrated"
        What a step is given: the valve's drive, or a set point that the board's loop inside follows (the model's rig needs
        ``[controller]`` and ``[sensor]``); by default what drove the channel when it was calibrated.

    Raises
    ------
    DataError
        No such channel, or a step or a control that the model cannot have.
    """
    def __new__(cls, /, model: Parameters | ExtendedModel, *, channels: SupportsGetItem[int, str] | None = None, step_s: SupportsFloat | SupportsIndex = 0.01, control: str = "calibrated") -> Stepper: ...
    def __reduce__(self, /) -> tuple[Any, tuple[bytes]]: ...
    def __repr__(self, /) -> str: ...
    @staticmethod
    def _unpickle(state: bytes) -> Stepper: ...
    @property
    def channels(self, /) -> list[str]:
        """
        Names of the channels, in the order of all arrays.
        """
    @property
    def control(self, /) -> str:
        """
        ``"calibrated"``, ``"drive"`` or ``"set_point"``.
        """
    @property
    def drive(self, /) -> NDArray[float64]:
        """
        Drives of the valves in the last step, -1 to 1, fill minus vent of separate ones; float64 array of shape (channels,), NaN of the
        linear model.
        """
    @property
    def pressure_kpa(self, /) -> NDArray[float64]:
        """
        Pressures in the chambers, kPa gauge; float64 array of shape (channels,).
        """
    @property
    def reading_kpa(self, /) -> NDArray[float64]:
        """
        What the boards report, kPa gauge; float64 array of shape (channels,).
        """
    def start(self, /, pressure_kpa: ArrayLike | None = None) -> None:
        """
        Begins at rest, at time 0.

        Parameters
        ----------
        pressure_kpa : array_like of float, shape () or (channels,), default 0.0
            kPa gauge.
        """
    @property
    def state(self, /) -> NDArray[float64]:
        """
        The whole state, a float64 array of shape (n,): with it a stepper of the same model, channels, step and control goes on with the same
        numbers.
        """
    @state.setter
    def state(self, /, state: ArrayLike) -> None: ...
    def step(self, /, *, drive: ArrayLike | None = None, fill: ArrayLike | None = None, vent: ArrayLike | None = None, set_point_kpa: ArrayLike | None = None, supply_kpa: ArrayLike | None = None, volume_m3: ArrayLike | None = None, volume_rate_m3_s: ArrayLike | None = None) -> NDArray[float64]:
        """
        Advances by a step over which the inputs hold.

        Parameters
        ----------
        drive : array_like of float, shape () or (channels,), optional
            Of spool valves, -1 (vent) to 1 (fill).
        fill, vent : array_like of float, shape () or (channels,), optional
            Of separate valves, 0 (closed) to 1 (open).
        set_point_kpa : array_like of float, shape () or (channels,), optional
            For channels that follow set points, kPa gauge. As on the bus, the board follows it from its second loop in the step on.
        supply_kpa : array_like of float, shape () or (channels,), optional
            Mean supply pressure over the step, kPa gauge; by default the rig's.
        volume_m3 : array_like of float, shape () or (channels,), optional
            Mean chamber volume over the step, m^3; by default the rig's, of the straight joint.
        volume_rate_m3_s : array_like of float, shape () or (channels,), default 0.0
            Its rate, m^3/s.

        Returns
        -------
        numpy.ndarray of float64, shape (channels,)
            Pressures in the chambers at the end of the step, kPa gauge.

        Raises
        ------
        DataError
            An input that is missing, not possible, or not used by any channel: nothing was advanced. A pressure that runs away: set
            ``state`` to one of before, or ``start``.
        """
    @property
    def step_s(self, /) -> float:
        """
        Length of a step, s.
        """
    @property
    def time_s(self, /) -> float:
        """
        Time since the start, s.
        """

def _record(out: str | PathLike[str], rig_out: str | PathLike[str], *, seconds: SupportsFloat | SupportsIndex, rate_hz: SupportsFloat | SupportsIndex, channels: SupportsIndex, excitation: str, range_kpa: tuple[SupportsFloat | SupportsIndex, SupportsFloat | SupportsIndex], effects: SupportsGetItem[int, str], realistic: bool, drive: bool, open_loop: SupportsFloat | SupportsIndex | None, joints: bool, supply: bool, seed: SupportsIndex) -> int:
    """
    Writes a recording of the truth plant and the rig's description; returns the number of rows. See ``pneudrive_py.sim.record``.
    """

def _run_program(program: str, arguments: SupportsGetItem[int, str]) -> int:
    """
    Does what ``pneudrive-host``, ``pneudrive-sim`` or ``pneudrive-model`` does with these arguments, in this process; once in it. Help and
    unusable arguments end the process. Returns the exit status. See ``pneudrive_py.__main__``.
    """

def batch_gradient(model: str | Parameters | ExtendedModel, parameters: ArrayLike | dict[str, ArrayLike] | None, interval_s: SupportsFloat | SupportsIndex, weights: ArrayLike, *, drive: ArrayLike | None = None, fill: ArrayLike | None = None, vent: ArrayLike | None = None, command_kpa: ArrayLike | None = None, supply_kpa: ArrayLike | None = None, volume_m3: ArrayLike | None = None, start_kpa: ArrayLike | None = None, rig: Rig | str | PathLike[str] | None = None, controller: bool | None = None, substeps: SupportsIndex | None = None, channel: str | None = None, progress: Any | None = None) -> dict[str, NDArray[float64]]:
    """
    Differentiates a weighted sum of simulated pressures by everything that they follow from.

    With ``pressure_kpa = simulate_batch(...)`` of the same arguments, these are the derivatives of ``(weights * pressure_kpa).sum()``. With
    the derivatives of a loss by the pressures as weights they are those of the loss: one call, whatever the number of inputs. They are
    exact for the discretised model (reverse accumulation), not differences.

    Parameters
    ----------
    model : {"nonlinear", "parametric", "linear"}, Parameters or ExtendedModel
    parameters : array_like of float, shape (parameters,) or (chambers, parameters), or dict, or None
        As of ``simulate_batch``, like all that is not described here.
    interval_s : float
    weights : array_like of float, shape (), (rows,) or (chambers, rows)
        Finite.
    drive, fill, vent, command_kpa, supply_kpa, volume_m3, start_kpa : array_like of float, optional
    rig : Rig or path, optional
    controller : bool, optional
        The converter's rounding of readings passes derivatives through; where the loop's drive is clipped they are 0.
    substeps : int, optional
    channel : str, optional
    progress : callable, optional
        Called with (chambers done, chambers in all, what is being done).

    Returns
    -------
    dict of str to numpy.ndarray of float64
        ``"parameters"``, ``"start_kpa"``, ``"supply_kpa"``, ``"volume_m3"``, and of ``"drive"``, ``"fill"``, ``"vent"`` and ``"command_kpa"``
        those that were given: by each of its values, in the shape it was given in. What was given once for several chambers or rows has the
        sum over them. What was taken from the rig, or left at 0, has shape (). Of a dict of parameters: shape (parameters,), or
        (chambers, parameters) where any has a value per chamber. In units of the weights by kPa, per unit of the argument.

    Raises
    ------
    DataError
        As ``simulate_batch``; weights that are not finite; a model with a smooth correction.

    Notes
    -----
    Ports that close and flows that begin to choke have kinks; there the derivative is one of the two. An ``ExtendedModel`` is differentiated
    forwards by its parameters, eight at a time, and backwards by its inputs. Where its board's loop hunts, around play or friction, the
    derivatives grow without bound.
    """

def compare(recording: Recording, rig: Rig | str | PathLike[str] | None = None, *, models: SupportsGetItem[int, str] | None = None, fit_seconds: SupportsFloat | SupportsIndex | None = None, fit_fraction: SupportsFloat | SupportsIndex | None = None, controller: str = "auto", drive: str = "auto", flow: str = "iso6358", objective: str = "rollout", starts: SupportsIndex = 20, seed: SupportsIndex = 1, measured_start: bool = False, progress: Any | None = None) -> Comparison:
    """
    Fits several models to the first part of a recording and judges them on the rest.

    Parameters
    ----------
    recording : Recording
    rig : Rig or path, optional
        Without it only the linear model can be used.
    models : sequence of str, optional
        All three by default: ``["linear", "nonlinear", "parametric"]``.
    fit_seconds, fit_fraction : float, optional
        What is fitted: the first so many seconds, or this share; 80 % by default.
    controller, drive, flow, objective, starts, seed, measured_start
        As for ``fit``.
    progress : callable, optional
        Called with (searches done, searches in all, what is being done).

    Returns
    -------
    Comparison

    Raises
    ------
    DataError
        Nothing can be compared, or an argument is unusable. What only some models or channels lack is in ``Comparison.table``.
    """

def diagnose(recording: Recording | SupportsGetItem[int, Recording], rig: Rig | str | PathLike[str] | None = None, *, reference: ExtendedModel | str | PathLike[str] | None = None, loads: str = "auto", machine: ExtendedModel | str | PathLike[str] | None = None, only: SupportsGetItem[int, str] | None = None, highest_kpa: SupportsFloat | SupportsIndex | None = None, progress: Any | None = None) -> Diagnosis:
    """
    Says what the simulation gets wrong in a recording, why, and how much better it is once the cause is modelled.

    Parameters
    ----------
    recording : Recording or sequence of Recording
        Thirty seconds or more. Several recordings of one rig, with the same channels and columns, are diagnosed together.
    rig : Rig or path, optional
        Without it the channels are taken for regulators and compared with the linear model.
    reference : ExtendedModel or path, optional
        ``extended.toml`` of an earlier diagnosis of the same rig, or a file that ``Parameters.save`` wrote. The question is then which
        calibrated parameter has moved; without it, which physical effect the model lacks.
    loads : {"auto", "same", "differ"}, default "auto"
        Whether the recordings have different loads (volumes, tubes, walls) on the same valves. ``"differ"`` diagnoses them as
        recordings of one machine; ``"same"`` as one recording; ``"auto"`` finds out, of three or more whose drives are recorded.
    machine : ExtendedModel or path, optional
        Calibrated model of the same machine with another load, such as one of ``Diagnosis.extended_models``: valves, supply and sensor
        are taken from it, and only the load is fitted.
    only : sequence of str, optional
        Ids of the effects that it may be, where you know that it can be nothing else; by default all that ``effects`` knows.
    highest_kpa : float, optional
        Highest pressure that a suggested next experiment may command, kPa gauge; by default the highest in the recordings. Nothing is
        suggested about a machine.
    progress : callable, optional
        Called with (steps done, 0, what is being done).

    Returns
    -------
    Diagnosis
        Of a machine ``machine`` and ``extended_models`` hold more.

    Raises
    ------
    DataError
        The data cannot carry a diagnosis, recordings do not belong together, the reference or the machine does not fit, or arguments
        contradict each other.

    Notes
    -----
    docs/diagnosis.md says how to read it, docs/diagnosis-trust.md what it has been measured to find.
    All cores are used; where several processes share a machine, set the environment variable
    ``RAYON_NUM_THREADS`` for each.
    """

def effects() -> dict[str, dict[str, Any]]:
    """
    The catalogue of physical effects that ``diagnose`` knows.

    Returns
    -------
    dict
        By the effect's name: a dictionary with ``title``, ``physics``, ``equation``, ``source``, ``rivals`` (effects it is easily
        confused with), ``check`` (what to look at first on the rig), and ``parameters``: by their names tuples (unit, value at
        which the effect is absent, meaning).
    """

def fit(recording: Recording, rig: Rig | str | PathLike[str] | None = None, *, model: str = "nonlinear", fit_seconds: SupportsFloat | SupportsIndex | None = None, fit_fraction: SupportsFloat | SupportsIndex | None = None, controller: str = "auto", drive: str = "auto", flow: str = "iso6358", objective: str = "rollout", starts: SupportsIndex = 20, seed: SupportsIndex = 1, measured_start: bool = False, profiles: bool = False, progress: Any | None = None) -> Fit:
    """
    Fits a model to every channel of a recording.

    Parameters
    ----------
    recording : Recording
    rig : Rig or path, optional
        Without it only the linear model can be used.
    model : {"nonlinear", "parametric", "linear"}, default "nonlinear"
        Valve and chamber from first principles; Tassa et al. 2013; first-order lag of the command.
    fit_seconds, fit_fraction : float, optional
        Fit only the first so many seconds, or this share, and judge on the rest. Everything is fitted by default.
    controller : {"auto", "on", "off"}, default "auto"
        Whether the board's own pressure loop is simulated: by default where the drive is not recorded.
    drive : {"auto", "spool", "separate"}, default "auto"
        Kind of valve; by default as the columns say.
    flow : {"iso6358", "printed"}, default "iso6358"
        Form of the flow function.
    objective : {"rollout", "rate"}, default "rollout"
        Compare simulated pressures, or rates (fast, biased by noise).
    starts : int, default 20
        Number of starts, 1 to 10000.
    seed : int, default 1
        The same seed gives the same result.
    measured_start : bool, default False
        Take the pressure at the start of each stretch as measured instead of fitting it.
    profiles : bool, default False
        Profile-likelihood intervals too (slower).
    progress : callable, optional
        Called with (searches done, searches in all, what is being done).

    Returns
    -------
    Fit

    Raises
    ------
    DataError
        The recording or the rig lacks something, or an argument is unusable.
    FitError
        A channel cannot be fitted.
    """

def load(path: str | PathLike[str], rig: Rig | str | PathLike[str] | None = None, *, channels: SupportsGetItem[int, str] | None = None, progress: Any | None = None) -> Recording:
    """
    Reads and checks a recording.

    Parameters
    ----------
    path : str or os.PathLike
        CSV, plain or compressed with gzip or zstd, with the columns ``t_s``, ``b0_cmd0_kpa``, ``b0_p0_kpa``, ``b0_u0`` and so on;
        or MCAP, a ROS 2 bag of the node's topics or of ``pneudrive-host --record``.
    rig : Rig or path, optional
        With its sensors, samples at a sensor's limit are found and masked.
    channels : sequence of str, optional
        Channels to keep, such as ``["b0c0"]``; all by default.
    progress : callable, optional
        Called with (bytes read, bytes in all, what is being done).

    Returns
    -------
    Recording

    Raises
    ------
    DataError
        The content cannot be understood; the message names file, row and column.
    FileError
        The file cannot be read.
    """

def model_parameters(model: str | Parameters | ExtendedModel, drive: str = "spool", *, channel: str | None = None) -> list[dict[str, Any]]:
    """
    The parameters of a model, in the order that ``simulate_batch`` takes them.

    Parameters
    ----------
    model : {"nonlinear", "parametric", "linear"}, Parameters or ExtendedModel
    drive : {"spool", "separate"}, default "spool"
        Kind of valve, of a model by its name.
    channel : str, optional
        Of a calibrated model; by default its only one.

    Returns
    -------
    list of dict
        ``name``, ``unit``, ``lower``, ``nominal``, ``upper``, ``meaning``; of a calibrated model ``value``, too. An effect's are called as in
        ``valve_lag.time_constant``.
    """

def simulate(recording: Recording, parameters: Parameters | ExtendedModel, *, rig: Rig | str | PathLike[str] | None = None, controller: str = "auto", start_kpa: SupportsFloat | SupportsIndex = 0.0, progress: Any | None = None) -> Simulation:
    """
    Simulates the channels of a recording from its commands or drives alone.

    Measured pressures are not used, except for the first of each stretch to start from, and to judge the simulation by.

    Parameters
    ----------
    recording : Recording
        Commands (for the linear model, or with the board's loop) or drives.
    parameters : Parameters or ExtendedModel
        Such as ``fit(...).parameters`` or ``diagnose(...).extended_model``. Their channels must include the recording's.
    rig : Rig or path, optional
        By default the one the parameters were fitted with.
    controller : {"auto", "on", "off"}, default "auto"
        Whether the board's pressure loop is simulated: by default as it was fitted.
    start_kpa : float, default 0.0
        Pressure to start from where none was measured, kPa gauge.
    progress : callable, optional
        Called with (channels done, channels in all, what is being done).

    Returns
    -------
    Simulation

    Raises
    ------
    DataError
        The recording, the rig or the parameters lack something.
    """

def simulate_batch(model: str | Parameters | ExtendedModel, parameters: ArrayLike | dict[str, ArrayLike] | None, interval_s: SupportsFloat | SupportsIndex, *, drive: ArrayLike | None = None, fill: ArrayLike | None = None, vent: ArrayLike | None = None, command_kpa: ArrayLike | None = None, supply_kpa: ArrayLike | None = None, volume_m3: ArrayLike | None = None, start_kpa: ArrayLike | None = None, rig: Rig | str | PathLike[str] | None = None, controller: bool | None = None, substeps: SupportsIndex | None = None, sensitivities: bool = False, dtype: DTypeLike | None = None, channel: str | None = None, progress: Any | None = None) -> Any:
    """
    Simulates many chambers at once, each with parameters, inputs and a start of its own.

    Arrays broadcast as in NumPy: what is given once holds for all chambers, or for all rows. Inputs of row k hold from row k to
    row k + 1; supply and volume change linearly in between. The last row's inputs have no effect on the result.

    Parameters
    ----------
    model : {"nonlinear", "parametric", "linear"}, Parameters or ExtendedModel
        A model by its name, or one that was calibrated, such as ``fit(...).parameters`` or ``diagnose(...).extended_model``: with its rig, its
        effects, and what drove it. What other channels do to the chambers is left out.
    parameters : array_like of float, shape (parameters,) or (chambers, parameters), or dict, or None
        In the order and units of ``model_parameters``; of a dict by name, each of shape () or (chambers,). ``None``, and what a dict leaves
        out, are the values of a calibrated model.
    interval_s : float
        Time between two rows, s.
    drive : array_like of float, shape (rows,) or (chambers, rows), optional
        Spool valves: -1 (vent) to 1 (fill).
    fill, vent : array_like of float, shape (rows,) or (chambers, rows), optional
        Instead of ``drive``: separate valves, 0 (closed) to 1 (open).
    command_kpa : array_like of float, shape (rows,) or (chambers, rows), optional
        Set points, kPa gauge, for the linear model or with ``controller``.
    supply_kpa : array_like of float, shape (), (rows,) or (chambers, rows), optional
        Supply pressure, kPa gauge; by default the rig's.
    volume_m3 : array_like of float, shape (), (rows,) or (chambers, rows), optional
        Chamber volume, m^3; by default the rig's, of the straight joint.
    start_kpa : array_like of float, shape () or (chambers,), default 0.0
        Pressure at the first row, kPa gauge.
    rig : Rig or path, optional
        Ambient pressure and temperature, valve constants, and what is not given above. Not for a calibrated model, which has its own.
    controller : bool, optional
        Simulate the boards' pressure loops, which follow ``command_kpa``, in front of the valves; needs ``[controller]`` and
        ``[sensor]`` of the rig. By default not, and for a calibrated model as it was calibrated.
    substeps : int, optional
        Runge-Kutta steps per interval (per loop of the board with ``controller``), 1 to 1000; by default 1, or what a fit chose. Not for an
        ``ExtendedModel``, which steps by 2.5 ms at most.
    sensitivities : bool, default False
        Return derivatives by the parameters, too. They are exact for the discretised model, not differences. ``batch_gradient`` has those
        by everything else.
    dtype : {numpy.float64, numpy.float32}, default numpy.float64
        Of the result. In float32 the simulation itself is in single precision, about twice as fast: pressures are within 0.02 kPa of those
        in float64 over 20,000 rows.
    channel : str, optional
        Of a calibrated model, such as ``"b0c1"``; by default its only one.
    progress : callable, optional
        Called with (parts done, parts in all, what is being done).

    Returns
    -------
    pressure_kpa : numpy.ndarray of ``dtype``, shape (chambers, rows)
        kPa gauge. Not finite where a simulation ran away.
    sensitivity : numpy.ndarray of float64, shape (chambers, rows, parameters), only with ``sensitivities``
        Derivatives of the pressures by the parameters, kPa per unit of the parameter.

    Raises
    ------
    DataError
        Shapes that do not fit, values that are not finite or not possible, something missing; float32 with ``sensitivities``, ``controller``
        or effects; ``sensitivities`` of a model with a smooth correction.

    Notes
    -----
    Rows of 10 ms and one substep suffice for chambers of 0.1 litre and more behind valves of a few mm^2; compare with twice as
    many substeps when in doubt. An ``ExtendedModel`` gives what ``simulate`` gives for a recording of the same inputs, chamber by chamber instead of
    many in lockstep: 30 to 120 times as long a row (docs/performance.md). All cores are used; the environment variable ``RAYON_NUM_THREADS`` limits them. Contiguous arrays
    of float64, and of float32 with shape (chambers, rows), are not copied: no other thread may change them meanwhile.
    """

