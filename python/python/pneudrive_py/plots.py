"""Figures of recordings and results with matplotlib, at the size of a column of text and in the house's colours.

Each function draws into ``figure`` or makes one, and returns it; ``figure.savefig("name.pdf")`` saves it. ``recording.plot()``,
``fit.plot()`` and so on call these functions. Errors are measured - simulated everywhere.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from ._needs import needs
from ._pneudrive import Comparison, Diagnosis, Fit, Recording, Simulation, simulate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["COLOURS", "STYLE", "comparison", "diagnosis", "fit", "recording", "simulation"]

#: Colours that differ for colour-blind readers too (Okabe and Ito, 2008), as the reports'.
COLOURS = {
    "measured": "#1e1e1e",
    "command": "#969696",
    "blue": "#0072b2",
    "orange": "#d57800",
    "green": "#008a64",
    "purple": "#aa5a8c",
    "red": "#c8321e",
}

_RESULTS = [COLOURS[name] for name in ("blue", "orange", "green", "purple", "red")]

#: What ``matplotlib.rc_context`` takes: text of 8 pt, for figures as wide as a column (3.5 in) or a
#: page (7.16 in).
STYLE: dict[str, Any] = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.0,
    "legend.frameon": False,
    "legend.fontsize": 7,
    "savefig.dpi": 300,
    "pdf.fonttype": 42,
}

#: Width of a page of text, inches.
PAGE_IN = 7.16


@contextmanager
def _figure(figure: Figure | None, rows: int, heights: list[float], size: tuple[float, float] | None):
    """A figure with ``rows`` axes under each other, one time axis for all."""
    with needs("matplotlib"):
        import matplotlib.pyplot as plt

    with plt.rc_context(STYLE):
        if figure is None:
            height = 0.5 + sum(heights)
            figure = plt.figure(figsize=size or (PAGE_IN, height), layout="constrained")
            # A notebook shows what is returned; it need not show it again at the end of the cell.
            plt.close(figure)
        axes = figure.subplots(rows, 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights})[:, 0]
        yield figure, list(axes)
        axes[-1].set_xlabel("time (s)")
        for one in axes:
            if one.get_legend_handles_labels()[1]:
                one.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _chosen(wanted: Iterable[str] | str | None, there: list[str]) -> list[str]:
    chosen = there if wanted is None else [wanted] if isinstance(wanted, str) else list(wanted)
    missing = [name for name in chosen if name not in there]
    if missing:
        raise ValueError(f"no channel {missing[0]}; there is {', '.join(there)}")
    return chosen


def _column(channel: str, kind: str) -> str:
    board, number = channel[1:].split("c")
    return f"b{board}_{kind}{number}_kpa"


def _error_axis(axis: Axes, label: str = "measured - simulated (kPa)") -> None:
    axis.axhline(0.0, color="#787878", linewidth=0.6, zorder=1)
    axis.set_ylabel(label)


def _shade(axes: list[Axes], time_s: np.ndarray, inside: np.ndarray, name: str) -> None:
    """Shades stretches of rows."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], inside, [False])).astype(int)))
    for k, (start, stop) in enumerate(zip(edges[::2], edges[1::2])):
        for one in axes:
            label = name if k == 0 and one is axes[0] else None
            one.axvspan(time_s[start], time_s[stop - 1], color="#eef2f7", zorder=0, label=label)


def recording(
    recording: Recording,
    channels: Iterable[str] | str | None = None,
    *,
    figure: Figure | None = None,
    size: tuple[float, float] | None = None,
) -> Figure:
    """Set points, usable pressures, and what lies between.

    Parameters
    ----------
    recording : Recording
    channels : str or iterable of str, optional
        Such as ``"b0c1"``; all by default.
    figure : matplotlib.figure.Figure, optional
        To draw into.
    size : tuple of float, optional
        Width and height, inches.
    """
    chosen = _chosen(channels, recording.channels)
    with _figure(figure, 2, [1.8, 1.6], size) as (figure, (pressures, deviations)):
        time_s = recording.time_s
        for k, channel in enumerate(chosen):
            command, measured = recording.get(_column(channel, "cmd")), recording.get(_column(channel, "p"))
            if command is not None:
                label = "set points" if k == 0 else None
                pressures.plot(time_s, command, color=COLOURS["command"], label=label, drawstyle="steps-post")
            if measured is None:
                continue
            usable = np.where(recording.usable(channel), measured, np.nan)
            pressures.plot(time_s, usable, color=_RESULTS[k % len(_RESULTS)], label=channel)
            if command is not None:
                deviations.plot(time_s, usable - command, color=_RESULTS[k % len(_RESULTS)])
        for event in recording.events:
            for one in (pressures, deviations):
                one.axvline(event["t_s"], color=COLOURS["red"], linewidth=0.6)
        pressures.set_ylabel("pressure (kPa gauge)")
        _error_axis(deviations, "measured - set point (kPa)")
    return figure


def simulation(
    simulation: Simulation,
    channels: Iterable[str] | str | None = None,
    *,
    figure: Figure | None = None,
    size: tuple[float, float] | None = None,
) -> Figure:
    """Measured and simulated pressures, the 95 % band where the model has one, and their difference; keywords as for :func:`recording`."""
    return _simulated(simulation, _chosen(channels, simulation.channels), None, figure, size)


def fit(
    fit: Fit,
    channels: Iterable[str] | str | None = None,
    *,
    figure: Figure | None = None,
    size: tuple[float, float] | None = None,
) -> Figure:
    """The same with the fitted parameters, the fitted part shaded; keywords as for :func:`recording`."""
    simulated = simulate(fit.recording, fit.parameters)
    return _simulated(simulated, _chosen(channels, fit.channels), fit, figure, size)


def _simulated(simulated: Simulation, chosen: list[str], fitted: Fit | None, figure: Figure | None, size: Any) -> Figure:
    heights = [1.3] * len(chosen) + [1.6]
    time_s, bands_kpa = simulated.time_s, simulated.band_kpa
    with _figure(figure, len(heights), heights, size) as (figure, axes):
        for k, (channel, axis) in enumerate(zip(chosen, axes)):
            one = simulated.residuals(channel)
            axis.plot(one["t_s"], one["measured_kpa"], color=COLOURS["measured"], label="measured")
            axis.plot(one["t_s"], one["simulated_kpa"], color=_RESULTS[k % len(_RESULTS)], label="simulated")
            low_kpa, high_kpa = bands_kpa[:, simulated.channels.index(channel)].T
            if np.isfinite(low_kpa).any():
                axis.fill_between(time_s, low_kpa, high_kpa, color=_RESULTS[k % len(_RESULTS)], alpha=0.25, linewidth=0, label="95 % band")
            axis.set_title(channel)
            axis.set_ylabel("kPa gauge")
            axes[-1].plot(one["t_s"], one["residual_kpa"], color=_RESULTS[k % len(_RESULTS)], label=channel)
        _error_axis(axes[-1])
        if fitted is not None:
            time_s = fitted.recording.time_s
            _shade(axes, time_s, time_s - time_s[0] <= fitted.fit_seconds, "fitted")
    return figure


def comparison(
    comparison: Comparison,
    channel: str | None = None,
    *,
    figure: Figure | None = None,
    size: tuple[float, float] | None = None,
) -> Figure:
    """The judging part of one channel, measured and by every model, and the errors.

    Parameters
    ----------
    comparison : Comparison
    channel : str, optional
        Such as ``"b0c1"``; the first by default.
    figure, size
        As for :func:`recording`.
    """
    table = comparison.table
    channels = list(dict.fromkeys(table["channel"]))
    channel = _chosen(channel, channels)[0]
    rows = zip(table["channel"], table["model"], table["error"])
    models = [model for there, model, error in rows if there == channel and error is None]
    with _figure(figure, 2, [1.8, 1.6], size) as (figure, (pressures, errors)):
        for k, model in enumerate(models):
            one = comparison.residuals(channel, model)
            if k == 0:
                pressures.plot(one["t_s"], one["measured_kpa"], color=COLOURS["measured"], label="measured")
            pressures.plot(one["t_s"], one["simulated_kpa"], color=_RESULTS[k], label=model)
            errors.plot(one["t_s"], one["residual_kpa"], color=_RESULTS[k])
        pressures.set_title(channel)
        pressures.set_ylabel("pressure (kPa gauge)")
        _error_axis(errors)
    return figure


def diagnosis(
    diagnosis: Diagnosis,
    channel: str | None = None,
    *,
    figure: Figure | None = None,
    size: tuple[float, float] | None = None,
) -> Figure:
    """The pressures of one channel, and the residuals of the model without and with the causes; test blocks are shaded.

    Of several recordings of one machine: the test error of each without and with the causes, and the sizes of its load with their
    95 % intervals. Keywords as for :func:`comparison`.
    """
    if diagnosis.machine is not None:
        return _machine(diagnosis, _chosen(channel, diagnosis.channels)[0], figure, size)
    channel = _chosen(channel, diagnosis.channels)[0]
    one = diagnosis.residuals(channel)
    # Rows between blocks are not compared: lines do not cross them.
    gap = np.diff(one["t_s"], prepend=one["t_s"][0]) > 3 * np.median(np.diff(one["t_s"]))
    with _figure(figure, 2, [1.5, 1.5], size) as (figure, (pressures, errors)):
        pressures.plot(one["t_s"], np.where(gap, np.nan, one["measured_kpa"]), color=COLOURS["measured"], label="measured")
        errors.plot(one["t_s"], np.where(gap, np.nan, one["base"]), color=COLOURS["orange"], label="base model")
        if diagnosis.causes:
            errors.plot(one["t_s"], np.where(gap, np.nan, one["extended"]), color=COLOURS["blue"], label="with the causes")
        _shade([pressures, errors], one["t_s"], (one["role"] == "test") & ~gap, "test blocks")
        pressures.set_title(channel)
        pressures.set_ylabel("pressure (kPa gauge)")
        _error_axis(errors)
    return figure


def _machine(diagnosis: Diagnosis, channel: str, figure: Figure | None, size: tuple[float, float] | None) -> Figure:
    recordings = diagnosis.machine["recordings"]
    names = [record["file"] for record in recordings]
    loads = [record["load"].get(channel, {}) for record in recordings]
    sizes = [name for name in dict.fromkeys(name for load in loads for name in load) if _known(loads, name)]
    with needs("matplotlib"):
        import matplotlib.pyplot as plt

    with plt.rc_context(STYLE):
        if figure is None:
            height = 0.8 + 0.22 * len(names)
            figure = plt.figure(figsize=size or (PAGE_IN, height), layout="constrained")
            plt.close(figure)
        axes = figure.subplots(1, 1 + len(sizes), sharey=True, squeeze=False)[0]
        rows = np.arange(len(names))
        axes[0].plot([r["test_rmse_before_kpa"] for r in recordings], rows, "o", ms=4, color=COLOURS["orange"], label="base model")
        if diagnosis.causes:
            after = [r["test_rmse_after_kpa"] for r in recordings]
            axes[0].plot(after, rows, "o", ms=4, color=COLOURS["blue"], label="with the causes")
        axes[0].set_xlim(left=0.0)
        axes[0].set_xlabel("test error (kPa RMS)")
        axes[0].set_yticks(rows, names)
        axes[0].invert_yaxis()
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper left", ncols=2)
        for axis, name in zip(axes[1:], sizes):
            _intervals(axis, rows, [load.get(name) for load in loads], name)
    return figure


def _known(loads: list[dict[str, Any]], name: str) -> bool:
    """Does any recording determine it?"""
    return any(load[name]["ci95"] is not None for load in loads if name in load)


def _intervals(axis: Axes, rows: np.ndarray, estimates: list[dict[str, Any] | None], name: str) -> None:
    """Values with their 95 % intervals, one in a row; a value without an interval is the unit of the others, or not determined."""
    unit = next(estimate["unit"] for estimate in estimates if estimate is not None)
    for row, estimate in zip(rows, estimates):
        if estimate is None:
            continue
        if estimate["ci95"] is not None:
            axis.plot(estimate["ci95"], [row, row], color=COLOURS["blue"])
            axis.plot(estimate["value"], row, "o", ms=4, color=COLOURS["blue"])
        elif estimate["state"] == "taken as the unit":
            axis.plot(estimate["value"], row, "|", ms=8, color=COLOURS["measured"])
    axis.set_xlabel(name if unit == "1" else f"{name} ({unit})")
