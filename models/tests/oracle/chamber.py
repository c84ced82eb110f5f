"""The three pressure models once more, written from their equations and not from the Rust code.

Pressures absolute in Pa, areas in mm^2, volumes in m^3. Inputs are constant over a sample interval.
"""

import math

import numba
import numpy as np

GAMMA, R, T, AMBIENT = 1.4, 287.05, 293.15, 101_325.0
PSI_MAX = (2 / (GAMMA + 1)) ** (1 / (GAMMA - 1)) * math.sqrt(GAMMA / (GAMMA + 1))
B_CRITICAL, LAMINAR = 0.30, 0.999


@numba.njit(cache=True)
def psi(ratio, printed):
    """Flow function; a straight line to zero above LAMINAR."""
    if ratio <= B_CRITICAL:
        return PSI_MAX
    z = (min(ratio, LAMINAR) - B_CRITICAL) / (1 - B_CRITICAL)
    value = PSI_MAX * math.sqrt(1 - z if printed else 1 - z * z)
    if ratio > LAMINAR:
        value *= (1 - ratio) / (1 - LAMINAR)
    return value


@numba.njit(cache=True)
def mass_flow(area_mm2, p1, p2, printed):
    """kg/s from p1 to p2, negative when p2 is the higher one."""
    if p1 >= p2:
        return area_mm2 * 1e-6 * psi(p2 / p1, printed) * p1 * math.sqrt(2 / (R * T))
    return -area_mm2 * 1e-6 * psi(p1 / p2, printed) * p2 * math.sqrt(2 / (R * T))


@numba.njit(cache=True)
def opening(leak, gain, drive, threshold, corner):
    x = gain * (drive - threshold) - leak
    return leak + (math.sqrt(x * x + corner * corner) + x) / 2


@numba.njit(cache=True)
def nonlinear(p, areas, supply, volume, volume_rate, weight, printed):
    flow = mass_flow(areas[0], supply, p, printed) - mass_flow(areas[1], p, AMBIENT, printed)
    return GAMMA * R * T / volume * flow - GAMMA * weight * volume_rate * p / volume


@numba.njit(cache=True)
def spool_areas(q, fill, vent):
    """q: leak_in, leak_out, gain, threshold_in, threshold_out, corner, volume_weight; u = fill = -vent."""
    u = fill
    return (opening(q[0], q[2], u, q[3], q[5]), q[1] + corner_of(q[2] * (q[4] - u) - q[1], q[5]))


@numba.njit(cache=True)
def corner_of(x, e):
    return (math.sqrt(x * x + e * e) + x) / 2


@numba.njit(cache=True)
def separate_areas(q, fill, vent):
    """q: leak_in, leak_out, gain_in, gain_out, threshold_in, threshold_out, corner, volume_weight."""
    return (opening(q[0], q[2], fill, q[4], q[6]), opening(q[1], q[3], vent, q[5], q[6]))


def parametric(p, q, u, supply, volume, volume_rate):
    """q: c1 ... c9, c_gamma; volumes in litres, c4 in kPa s/l."""
    c1, c2, c3, c4, c5, c6, c7, c8, c9, cg = q
    v, vd = volume * 1e3, volume_rate * 1e3
    x = u - c1
    y = c2 * x + c3 * x**3
    end = (supply + AMBIENT) / 2 + (supply - AMBIENT) / 2 * y / math.sqrt(y * y + 1) + c4 * 1e3 * vd
    k = math.sqrt(x * x + cg * cg) - cg + c8 * x + c9
    rate = corner_of((c7 * k + c5 * vd) / (1 + c6 * v), 0.01)
    return (end - p) * rate


def linear(p, q, command):
    return -q[0] * (p - AMBIENT) + q[1] * (command - AMBIENT)


@numba.njit(cache=True)
def rollout(q, p0, dt, fill, supply, volume, volume_rate, printed):
    """RK4 with one step per sample of the nonlinear model with a spool."""
    out = np.empty(len(fill))
    p = p0
    for k in range(len(fill)):
        out[k] = p
        a = spool_areas(q, fill[k], -fill[k])
        s, v, vd, w = supply[k], volume[k], volume_rate[k], q[6]
        k1 = nonlinear(p, a, s, v, vd, w, printed)
        k2 = nonlinear(p + dt / 2 * k1, a, s, v, vd, w, printed)
        k3 = nonlinear(p + dt / 2 * k2, a, s, v, vd, w, printed)
        k4 = nonlinear(p + dt * k3, a, s, v, vd, w, printed)
        p += dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return out


def excitation(rows, dt, seed):
    """Drive that steps every 50 to 500 ms, a joint that swings: drive, volume, volume rate (means over the intervals), angle."""
    rng = np.random.default_rng(seed)
    drive = np.empty(rows)
    k = 0
    while k < rows:
        n = int(rng.integers(5, 50))
        drive[k : k + n] = rng.uniform(-0.6, 0.6)
        k += n
    t = dt * np.arange(rows + 1)
    angle = 0.6 * np.sin(0.7 * t) + 0.2 * np.sin(2.3 * t)
    volume = math.pi * 0.024**2 * (0.20 + 0.045 * angle)
    return drive, (volume[1:] + volume[:-1]) / 2, np.diff(volume) / dt, angle[:-1]
