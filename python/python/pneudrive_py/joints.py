"""Continuum joints of four chambers, thousands of them in lockstep: what the Gymnasium environments simulate.

Chambers and valves are :func:`pneudrive_py.simulate_batch`; the joint is a spring, a damper and an inertia.
"""

import math

import numpy as np

from . import DataError, Parameters, Rig, model_parameters, simulate_batch

__all__ = ["Joints", "Randomisation"]

#: A valve of 2 mm^2 at full drive, in the order of ``pneudrive_py.model_parameters("nonlinear")``.
NOMINAL_PARAMETERS = np.array([0.02, 0.02, 2.0, 0.05, -0.05, 0.1, 1.0])

NOMINAL_RIG = {
    "supply": {"pressure_kpa": 550.0},
    "chamber": {"radius_m": 0.024, "length_m": 0.2, "offset_m": 0.045},
}


class Randomisation:
    """Valve parameters that differ from one episode to the next, as much as is not known about them.

    Parameters
    ----------
    parameters : Parameters or path, optional
        Of a fit of the nonlinear model to valves with one spool: each chamber is one of its channels, drawn from the fit's covariance.
        Without it, a nominal valve.
    spread : float, default 0.0
        Every parameter is varied by up to this share besides: what differs from rig to rig, or what the fit cannot know.
    """

    def __init__(self, parameters=None, spread=0.0):
        if not 0.0 <= spread < 1.0:
            raise DataError(f"spread is {spread}; it must be 0 or more, and below 1")
        self.spread = spread
        if parameters is None:
            self.rig = Rig(**NOMINAL_RIG)
            self._channels = [(NOMINAL_PARAMETERS, np.zeros((7, 0)))]
            self._bounds = _bounds()
            return
        if not isinstance(parameters, Parameters):
            parameters = Parameters.load(parameters)
        self.rig = parameters.rig
        self._bounds = _bounds()
        stored = parameters.to_dict()["channels"]
        self._channels = [_channel(name, stored[name]) for name in parameters.channels]

    def draw(self, rng, chambers):
        """Parameters of some chambers, shape (chambers, 7); chamber k is channel k of the fit, over and over."""
        drawn = np.empty((chambers, 7))
        for k in range(chambers):
            values, root = self._channels[k % len(self._channels)]
            drawn[k] = values + root @ rng.standard_normal(root.shape[1])
        drawn *= rng.uniform(1.0 - self.spread, 1.0 + self.spread, drawn.shape)
        return np.clip(drawn, *self._bounds)


def _bounds():
    """What a valve can be, from the model's own ranges."""
    known = model_parameters("nonlinear")
    return np.array([p["lower"] for p in known]), np.array([p["upper"] for p in known])


def _channel(name, stored):
    """Values of a channel and a root of their covariance, shape (7, n)."""
    setup = stored["setup"]
    if setup["model"] != "nonlinear" or len(stored["parameters"]) != 7:
        raise DataError(f"{name} is not the nonlinear model of a valve with one spool, which the joints are simulated with")
    names = [p["name"] for p in stored["parameters"]]
    values = np.array([p["value"] for p in stored["parameters"]], dtype=float)
    free = [names.index(n) for n in stored["free"]]
    covariance = np.array(stored["covariance"], dtype=float).reshape(len(free), len(free))
    # What the data do not determine has no covariance: it stays where the fit left it.
    known = [k for k in range(len(free)) if np.isfinite(covariance[k]).any() and np.isfinite(covariance[k, k])]
    part = covariance[np.ix_(known, known)]
    sizes, directions = np.linalg.eigh(0.5 * (part + part.T)) if known else (np.zeros(0), np.zeros((0, 0)))
    root = np.zeros((7, len(known)))
    root[[free[k] for k in known]] = directions * np.sqrt(np.maximum(sizes, 0.0))
    return values, root


class Joints:
    """``number`` joints with four chambers each: angles, rates and pressures, advanced together.

    Chambers 0 and 1 lie opposite each other and bend the joint by ``qu``, chambers 2 and 3 by ``qv``: their lengths are
    ``h + r q`` and ``h - r q``.
    """

    INTERVAL_S = 0.005
    STIFFNESS_NM_RAD = 15.0
    DAMPING_NM_S_RAD = 0.5
    INERTIA_KG_M2 = 0.02
    LIMIT_RAD = 1.2

    def __init__(self, number, rig=None, parameters=NOMINAL_PARAMETERS):
        self.rig = rig if rig is not None else Rig(**NOMINAL_RIG)
        chamber = self.rig.to_dict().get("chamber", {})
        missing = [key for key in ("radius_m", "length_m", "offset_m") if key not in chamber]
        if missing:
            raise DataError(f"a joint that bends needs {', '.join(missing)} in the rig's [chamber]")
        self.parameters = np.array(np.broadcast_to(parameters, (4 * number, 7)), dtype=float)
        self.offset_m, self.length_m = chamber["offset_m"], chamber["length_m"]
        self.area_m2 = math.pi * chamber["radius_m"] ** 2
        self.angles_rad = np.zeros((number, 2))
        self.rates_rad_s = np.zeros((number, 2))
        self.pressures_kpa = np.zeros((number, 4))

    def volumes_m3(self, angles_rad):
        """Shape (joints, 4)."""
        stretch = np.repeat(angles_rad, 2, axis=1) * [1.0, -1.0, 1.0, -1.0]
        return self.area_m2 * (self.length_m + self.offset_m * stretch)

    def step(self, drive, seconds):
        """Holds the drives, shape (joints, 4), -1 (vent) to 1 (fill), for a time."""
        for _ in range(round(seconds / self.INTERVAL_S)):
            before = self.volumes_m3(self.angles_rad)
            self._bend()
            after = self.volumes_m3(self.angles_rad)
            rows = simulate_batch(
                "nonlinear",
                self.parameters,
                self.INTERVAL_S,
                drive=np.ascontiguousarray(drive, dtype=float).reshape(-1, 1),
                volume_m3=np.stack([before.ravel(), after.ravel()], axis=1),
                start_kpa=self.pressures_kpa.ravel(),
                rig=self.rig,
            )
            self.pressures_kpa = rows[:, -1].reshape(-1, 4)

    def _bend(self):
        """Moves the joints for one interval: damping and spring implicitly, which no step makes unstable."""
        h, kpa = self.INTERVAL_S, 1e3
        difference = self.pressures_kpa[:, 0::2] - self.pressures_kpa[:, 1::2]
        torque = kpa * self.area_m2 * self.offset_m * difference - self.STIFFNESS_NM_RAD * self.angles_rad
        inertia = self.INERTIA_KG_M2 + h * self.DAMPING_NM_S_RAD + h * h * self.STIFFNESS_NM_RAD
        self.rates_rad_s = (self.INERTIA_KG_M2 * self.rates_rad_s + h * torque) / inertia
        moved = self.angles_rad + h * self.rates_rad_s
        self.angles_rad = np.clip(moved, -self.LIMIT_RAD, self.LIMIT_RAD)
        # A joint against its stop stands still.
        self.rates_rad_s = np.where(moved == self.angles_rad, self.rates_rad_s, 0.0)
