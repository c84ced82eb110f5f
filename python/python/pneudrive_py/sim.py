"""Data sets of the truth plant: what a host would have recorded of a rig whose every property is known.

The plant is not the models of this package: it has mass and energy balances, spool dynamics and tubes, and any of the effects that
:func:`pneudrive_py.effects` names, so that a fit or a diagnosis can be tried on data whose answer is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike, fspath
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from . import _pneudrive
from ._pneudrive import Recording, Rig, load

__all__ = ["DataSet", "record"]


class DataSet(NamedTuple):
    """A recording and the nominal description of the rig that it is of: what somebody would have who built the rig."""

    recording: Recording
    rig: Rig


def record(
    path: str | PathLike[str] | None = None,
    *,
    seconds: float = 60.0,
    rate_hz: float = 100.0,
    channels: int = 4,
    excitation: str = "mixed",
    range_kpa: tuple[float, float] = (50.0, 300.0),
    effects: Sequence[str] = (),
    realistic: bool = False,
    drive: bool = False,
    open_loop: float | None = None,
    joints: bool = False,
    supply: bool = False,
    seed: int = 1,
) -> DataSet:
    """Makes a data set without a bus, faster than real time. The same arguments make the same data.

    Parameters
    ----------
    path : str or os.PathLike, optional
        File to keep: ``.csv``, ``.csv.gz`` or ``.csv.zst``; the rig's description is written beside it (``.toml``). By default nothing is
        kept.
    seconds : float, default 60.0
        Length, s.
    rate_hz : float, default 100.0
        Rows per second, 1 to 1000.
    channels : int, default 4
        Four to a board.
    excitation : {"mixed", "steps", "fast-steps", "aprbs", "sine", "ramps", "staircase"}, default "mixed"
        What the set points do.
    range_kpa : tuple of float, default (50.0, 300.0)
        Lowest and highest set point, kPa gauge.
    effects : sequence of str, optional
        What is wrong with the rig, such as ``"exhaust_leak"`` or ``"valve_hysteresis=0.05@b0c1"``: ``id``, ``id=value`` or ``id:name=value,...``, each
        with an optional board or channel.
    realistic : bool, default False
        Add small amounts of what every rig has.
    drive : bool, default False
        Close the loop once a row and record the drive, so that the plant alone can be simulated. Otherwise the board's firmware closes
        it, and only set points are known.
    open_loop : float, optional
        Leave the loop open: random drives up to this amplitude, recorded, and no set points.
    joints, supply : bool, default False
        Free the joints and record their angles; record the supply pressure.
    seed : int, default 1
        Of everything random.

    Returns
    -------
    DataSet
        ``recording`` and ``rig``.

    Raises
    ------
    DataError
        An argument that makes no sense.
    FileError
        The files cannot be written.
    """
    with TemporaryDirectory() as folder:
        out = Path(folder) / "data_set.csv" if path is None else Path(fspath(path))
        rig_out = _beside(out)
        _pneudrive._record(
            out,
            rig_out,
            seconds=seconds,
            rate_hz=rate_hz,
            channels=channels,
            excitation=excitation,
            range_kpa=range_kpa,
            effects=list(effects),
            realistic=realistic,
            drive=drive,
            open_loop=open_loop,
            joints=joints,
            supply=supply,
            seed=seed,
        )
        rig = Rig.load(rig_out)
        return DataSet(load(out, rig), rig)


def _beside(path: Path) -> Path:
    name = path.name
    for ending in (".gz", ".zst", ".csv"):
        name = name.removesuffix(ending)
    return path.with_name(f"{name}.toml")
