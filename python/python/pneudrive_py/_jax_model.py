"""The nonlinear chamber model in JAX: a pure right-hand side and a rollout, for ``jit``, ``vmap``, ``grad`` and ``scan``. Needs nothing but
JAX: ``pneudrive-model export jax`` copies this file. Pressures are kPa gauge, volumes m^3, times s.
"""

from typing import NamedTuple

try:
    import jax
    import jax.numpy as jnp
except ImportError as missing:
    raise ImportError("the chamber model needs JAX: pip install jax") from missing

__all__ = ["Constants", "dp", "rollout"]

GAMMA = 1.4
GAS_CONSTANT = 287.05
#: Above this ratio of pressures the flow is laminar: its subsonic slope would become infinite.
LAMINAR_RATIO = 0.999
PSI_MAX = (2.0 / (GAMMA + 1.0)) ** (1.0 / (GAMMA - 1.0)) * (GAMMA / (GAMMA + 1.0)) ** 0.5


class Constants(NamedTuple):
    """What is fixed about a chamber. Each may be an array that broadcasts with the pressures."""

    #: Supply pressure, kPa gauge.
    supply_kpa: float = 550.0
    #: Volume of the straight joint's chamber, m^3.
    volume_m3: float = 3.619e-4
    #: Ambient pressure, kPa absolute.
    ambient_kpa_abs: float = 101.325
    #: Temperature of the air, K.
    temperature_k: float = 293.15
    #: ISO 6358 critical ratio of the ports.
    critical_ratio: float = 0.3
    #: Discharge coefficient.
    discharge_coefficient: float = 1.0


def _mean_of_drops(upstream, downstream, critical_ratio):
    """Flow pressure over its gain, Pa, between two absolute pressures in Pa; negative backwards.

    The subsonic ellipse as a geometric mean of drops, joined to the laminar line by taking the smaller of the two.
    """
    choking_drop = 1.0 - critical_ratio
    small = 1.0 - LAMINAR_RATIO
    slope = jnp.sqrt(small * (2.0 * choking_drop - small)) / small
    drop = upstream - downstream
    magnitude = jnp.abs(drop)
    choking = jnp.maximum(upstream, downstream) * choking_drop
    effective = jnp.minimum(magnitude, choking)
    line = magnitude * slope
    squared = effective * (2.0 * choking - effective)
    laminar = squared >= line * line
    # Where the line holds, the root is not taken at its infinite slope: a derivative of what is not
    # used must be finite, too.
    ellipse = jnp.sqrt(jnp.where(laminar, 1.0, squared))
    return jnp.sign(drop) * jnp.where(laminar, line, ellipse)


def _corner(x, width):
    """``max(x, 0)`` with its corner rounded over a width."""
    return 0.5 * (jnp.sqrt(x * x + width * width) + x)


def _openings(drive, theta):
    """Effective areas of the fill and the vent port, mm^2."""
    if theta.shape[-1] == 7:
        leak_in, leak_out, gain, low, high, corner, _ = (theta[..., k] for k in range(7))
        fill, vent, gain_in, gain_out = drive - low, high - drive, gain, gain
    elif theta.shape[-1] == 8:
        leak_in, leak_out, gain_in, gain_out, low, high, corner, _ = (theta[..., k] for k in range(8))
        fill, vent = drive[..., 0] - low, drive[..., 1] - high
    else:
        raise ValueError(
            f"theta has {theta.shape[-1]} parameters; the nonlinear model has 7 (one spool) or 8 (two valves)"
        )
    return (
        leak_in + _corner(gain_in * fill - leak_in, corner),
        leak_out + _corner(gain_out * vent - leak_out, corner),
    )


def dp(p_kpa, drive, volume_m3, volume_rate_m3_s, theta, constants=Constants()):
    """Rate of the pressure in a chamber. Everything broadcasts.

    Parameters
    ----------
    p_kpa : array_like
        Pressure, kPa gauge.
    drive : array_like
        Of one spool: -1 (vent) to 1 (fill). Of two valves: shape (..., 2), fill and vent, 0 to 1.
    volume_m3, volume_rate_m3_s : array_like
        Volume of the chamber and its rate, m^3 and m^3/s.
    theta : array_like, shape (..., 7) or (..., 8)
        Parameters in the order and units of ``pneudrive_py.model_parameters("nonlinear")``; 8 of two valves.
    constants : Constants

    Returns
    -------
    jax.Array
        kPa/s.
    """
    theta, drive = jnp.asarray(theta), jnp.asarray(drive)
    ambient = constants.ambient_kpa_abs * 1e3
    pressure, supply = ambient + 1e3 * jnp.asarray(p_kpa), ambient + 1e3 * jnp.asarray(constants.supply_kpa)
    fill, vent = _openings(drive, theta)
    specific = GAS_CONSTANT * constants.temperature_k
    speed = GAMMA * specific * (2.0 / specific) ** 0.5 * 1e-6 * constants.discharge_coefficient
    conductance = speed * PSI_MAX / (1.0 - constants.critical_ratio) / volume_m3
    inflow = _mean_of_drops(supply, pressure, constants.critical_ratio)
    outflow = _mean_of_drops(pressure, jnp.asarray(ambient), constants.critical_ratio)
    expansion = GAMMA * theta[..., -1] * volume_rate_m3_s / volume_m3
    return 1e-3 * (conductance * (fill * inflow - vent * outflow) - expansion * pressure)


def rollout(start_kpa, drive, interval_s, theta, constants=Constants(), *, supply_kpa=None, volume_m3=None, substeps=1):
    """Pressures of a chamber under a course of drives, by Runge-Kutta steps of fourth order in a ``scan``.

    Inputs of row k hold from row k to row k + 1; supply and volume change linearly in between. The last row's inputs have no effect.

    Parameters
    ----------
    start_kpa : array_like
        Pressure at the first row, kPa gauge.
    drive : array_like, shape (rows,), or (rows, 2) of two valves
    interval_s : float
        Time between two rows, s.
    theta : array_like, shape (7,) or (8,)
        As for :func:`dp`.
    constants : Constants
    supply_kpa, volume_m3 : array_like, shape () or (rows,), optional
        Instead of the constants'.
    substeps : int
        Runge-Kutta steps per interval.

    Returns
    -------
    jax.Array, shape (rows,)
        kPa gauge. For many chambers, use ``jax.vmap``.
    """
    theta, drive = jnp.asarray(theta), jnp.asarray(drive)
    rows = drive.shape[0]
    supply = jnp.broadcast_to(constants.supply_kpa if supply_kpa is None else supply_kpa, (rows,))
    volume = jnp.broadcast_to(constants.volume_m3 if volume_m3 is None else volume_m3, (rows,))
    held = (
        drive[:-1],
        0.5 * (supply[:-1] + supply[1:]),
        0.5 * (volume[:-1] + volume[1:]),
        (volume[1:] - volume[:-1]) / interval_s,
    )
    h = interval_s / substeps

    def interval(pressure, row):
        u, supply_here, volume_here, rate_here = row
        here = constants._replace(supply_kpa=supply_here)

        def rate(p):
            return dp(p, u, volume_here, rate_here, theta, here)

        for _ in range(substeps):
            k1 = rate(pressure)
            k2 = rate(pressure + 0.5 * h * k1)
            k3 = rate(pressure + 0.5 * h * k2)
            k4 = rate(pressure + h * k3)
            pressure = pressure + h / 6.0 * ((k1 + k4) + 2.0 * (k2 + k3))
        return pressure, pressure

    kind = jnp.result_type(theta, drive, jnp.asarray(start_kpa), float)
    first = jnp.asarray(start_kpa, kind)
    _, after = jax.lax.scan(interval, first, held)
    return jnp.concatenate([first[None], after])
