"""
The compiled part of `pneudrive_py`; import that.
"""

from _typeshed import Incomplete
from os import PathLike
from pathlib import Path
from typing import Any, Final, SupportsFloat, SupportsIndex, final

__all__ = ["__version__", "Poller", "PressureController"]

__version__: Final[str]

@final
class Poller:
    """
    Polls all boards of a controller in the background; made by ``PressureController.poll``.

    Set points may be changed and pressures read at any time, from any thread, without waiting for the bus. When it is stopped
    (or its ``with`` block ends) all boards are commanded to 0 kPa, and the controller can be used by hand again.
    """
    def __enter__(self, /) -> Poller: ...
    def __exit__(self, /, exc_type: Any, _exc_value: Any, _traceback: Any) -> None: ...
    def __repr__(self, /) -> str: ...
    def get_pressure_data(self, /, device: SupportsIndex) -> Incomplete:
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
    def history(self, /) -> dict:
        """
        What happened in the time that is kept.

        Returns
        -------
        dict
            ``t_s``: shape (n,), start of each cycle, s from the first; ``commands_kpa`` and ``pressures_kpa``: shape
            (n, num_devices, 4), kPa gauge, NaN where a board did not answer in that cycle.
        """
    def set_pressure_commands(self, /, device: SupportsIndex, pressures: Any) -> None:
        """
        Changes the set points of one board, from its next exchange on.

        Parameters
        ----------
        device : int
            Board number, from 0.
        pressures : array_like of float, shape (4,)
            Set points of channels 0 to 3, kPa gauge.
        """
    def statistics(self, /) -> dict | None:
        """
        What the run has been like.

        Returns
        -------
        dict or None
            ``seconds``, ``cycles``, ``exchanges``, ``lost``, ``rejected``, ``missed_ticks``; ``loop_hz`` (``mean``, ``std``, ``min``);
            ``cycle_us`` (``p50``, ``p99``, ``p999``, ``max``); ``cpu_share`` of one core. None before the first figures.
        """
    def stop(self, /) -> None:
        """
        Commands 0 kPa to all boards and gives the bus back to the controller. Further calls do nothing.

        Raises
        ------
        PortError
            The port failed while polling.
        """

@final
class PressureController:
    """
    Host of up to 256 boards with four chambers each, on one serial port.

    Parameters
    ----------
    uart_port : str or os.PathLike
        Serial port, such as ``"/dev/ttyUSB0"``, or ``"sim"`` for virtual boards with chambers behind them.
    num_devices : int
        Boards on the bus; their address switches are set to 0, 1, ... 1 to 255.
    baud : int, default 1_000_000
        Line rate.
    timeout : float, optional
        How long a board may think before it answers, s; 0.002 by default. The wire's time is added.
    timing : {"wire", "instant"}, default "wire"
        Only for ``"sim"``: whether bytes take as long as on a wire.

    Raises
    ------
    PortError
        The port does not exist, is used by another process, or may not be opened.

    Notes
    -----
    Usable as a context manager: at the end all boards are commanded to 0 kPa and the port is closed. All methods may be called
    from several threads; exchanges then wait for each other.
    """
    def __enter__(self, /) -> PressureController: ...
    def __exit__(self, /, exc_type: Any, _exc_value: Any, _traceback: Any) -> None: ...
    def __new__(cls, /, uart_port: str | PathLike[str], num_devices: SupportsIndex, *, baud: SupportsIndex = 1000000, timeout: SupportsFloat | SupportsIndex | None = None, timing: str = "wire") -> PressureController: ...
    def __repr__(self, /) -> str: ...
    def close(self, /) -> None:
        """
        Commands 0 kPa to all boards and closes the port. Further calls do nothing.
        """
    def exchange_all(self, /, pressures: Any) -> Incomplete:
        """
        Commands all boards, one after the other, and receives all pressures.

        Parameters
        ----------
        pressures : array_like of float, shape (num_devices, 4)
            Set points, kPa gauge. All are checked before the first is sent.

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
    def get_pressure_data(self, /, device: SupportsIndex) -> Incomplete:
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
            The last exchange with this board failed, or there was none yet.
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
            Has the bus until it is stopped; use it as a context manager.
        """
    @property
    def port(self, /) -> Path:
        """
        The port's path; for virtual boards that of their pty.
        """
    def set_pressure_commands(self, /, device: SupportsIndex, pressures: Any) -> None:
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
            A pressure that cannot be commanded, a wrong shape, or no such board; nothing was sent.
        NoAnswerError, GarbledAnswerError
            The exchange failed; ``get_pressure_data`` then has nothing to give.
        """
