"""The nonlinear chamber model in JAX: a pure right-hand side and a rollout, for ``jit``, ``vmap``, ``grad`` and ``scan``.

Needs ``jax`` (``pip install 'pneudrive_py[jax]'``), which nothing else of this package imports::

    import jax
    import pneudrive_py as pneu
    from pneudrive_py import jax as chambers

    constants = chambers.constants("rig.toml")
    theta = parameters.array("b0c0")                       # of a fit
    rate = chambers.dp(120.0, 0.3, 3.6e-4, 0.0, theta, constants)
    pressures = chambers.rollout(0.0, drives, 0.01, theta, constants)
    gradient = jax.grad(lambda theta: ((chambers.rollout(0.0, drives, 0.01, theta, constants) - measured) ** 2).mean())(theta)

Pressures are kPa gauge, volumes m^3, times s. The numbers are those of :func:`pneudrive_py.simulate_batch` with the same substeps.
They are single precision unless ``jax_enable_x64`` is on.
"""

import math

from . import DataError, Rig
from ._jax_model import Constants, dp, rollout

__all__ = ["Constants", "constants", "dp", "rollout"]


def constants(rig):
    """The constants of a rig.

    Parameters
    ----------
    rig : Rig or path
        With ``[supply]`` and ``[chamber]``.

    Returns
    -------
    Constants

    Raises
    ------
    DataError
        The rig cannot be read, or has no such table.
    """
    tables = (rig if isinstance(rig, Rig) else Rig.load(rig)).to_dict()
    for needed in ("supply", "chamber"):
        if needed not in tables:
            raise DataError(f"the rig has no [{needed}], which the chamber's rate needs")
    chamber, ambient, valve = tables["chamber"], tables.get("ambient", {}), tables.get("valve", {})
    volume = chamber.get("volume_m3")
    if volume is None:
        volume = math.pi * chamber["radius_m"] ** 2 * chamber["length_m"]
    standard = Constants()
    return Constants(
        supply_kpa=tables["supply"]["pressure_kpa"],
        volume_m3=volume,
        ambient_kpa_abs=ambient.get("pressure_kpa_abs", standard.ambient_kpa_abs),
        temperature_k=ambient.get("temperature_k", standard.temperature_k),
        critical_ratio=valve.get("critical_ratio", standard.critical_ratio),
        discharge_coefficient=valve.get("discharge_coefficient", standard.discharge_coefficient),
    )
