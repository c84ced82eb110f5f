"""Recordings and residuals as tables of other libraries: pandas and xarray, imported only when they are asked for."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from ._needs import needs
from ._pneudrive import Fit, Recording, simulate

if TYPE_CHECKING:
    import pandas
    import xarray

__all__ = ["dataframe", "dataset", "fit_residuals"]

#: Columns of a channel by what they are, and what an array of all channels is called, its unit and
#: what it is.
_QUANTITIES = {
    "cmd": ("command", "kPa", "set point, gauge"),
    "p": ("pressure", "kPa", "measured pressure, gauge"),
    "u": ("drive", "1", "drive of the spool valve, -1 vent to 1 fill"),
    "fill": ("fill", "1", "drive of the fill valve"),
    "vent": ("vent", "1", "drive of the vent valve"),
}

_COLUMN = re.compile(r"b(\d+)_(cmd|p|u|fill|vent)(\d+)(?:_kpa)?")


def dataframe(recording: Recording) -> pandas.DataFrame:
    """All columns of a recording.

    Returns
    -------
    pandas.DataFrame
        One column for each of ``recording.columns`` but the time, which is the index ``t_s``, s.
    """
    with needs("pandas"):
        import pandas

    columns = dict(recording)
    return pandas.DataFrame(columns, index=pandas.Index(columns.pop("t_s"), name="t_s"))


def dataset(recording: Recording) -> xarray.Dataset:
    """The channels of a recording as arrays.

    Returns
    -------
    xarray.Dataset
        ``pressure``, ``command``, ``drive`` or ``fill`` and ``vent``, as far as there are any: float64, dimensions ``t_s`` (s) and
        ``channel`` (``"b0c0"``, ...), NaN where a channel has none; ``usable``: bool, which pressures may be used. Angles and supply
        have the dimension ``t_s`` alone. Units are in ``attrs["units"]``.
    """
    with needs("xarray"):
        import xarray

    channels = recording.channels
    arrays, others = {}, {}
    for name in recording.columns[1:]:
        match = _COLUMN.fullmatch(name)
        if match is None:
            unit = "rad" if name.endswith("_rad") else "kPa"
            others[name] = xarray.DataArray(recording[name], dims="t_s", attrs={"units": unit})
            continue
        board, kind, channel = match.groups()
        quantity, unit, meaning = _QUANTITIES[kind]
        if quantity not in arrays:
            empty = np.full((len(recording), len(channels)), np.nan)
            arrays[quantity] = xarray.DataArray(empty, dims=("t_s", "channel"), attrs={"units": unit, "long_name": meaning})
        arrays[quantity].values[:, channels.index(f"b{board}c{channel}")] = recording[name]
    usable = np.column_stack([recording.usable(channel) for channel in channels])
    arrays["usable"] = xarray.DataArray(usable, dims=("t_s", "channel"), attrs={"long_name": "pressures that may be used"})
    coordinates = {"t_s": ("t_s", recording.time_s, {"units": "s"}), "channel": channels}
    return xarray.Dataset(arrays | others, coords=coordinates, attrs={"source": recording.file})


def fit_residuals(fit: Fit, channel: str) -> dict[str, np.ndarray]:
    """What ``Fit.residuals`` returns."""
    residuals = dict(simulate(fit.recording, fit.parameters).residuals(channel))
    from_start_s = residuals["t_s"] - fit.recording.time_s[0]
    # Half a microsecond, so that the last fitted row is not lost to a rounding.
    residuals["role"] = np.where(from_start_s <= fit.fit_seconds + 5e-7, "fit", "held out")
    return residuals
