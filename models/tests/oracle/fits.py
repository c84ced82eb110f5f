"""Reference fits for tests/fit_oracle.rs with LMFIT: the nonlinear model on 1,500 samples of recording.py, on rollouts (start
pressure fitted) and on rates. Writes fit_inputs.csv and fits.csv (fit, parameter, value, standard error).

    pip install -r requirements.txt && python fits.py
"""

import csv
from pathlib import Path

import lmfit
import numpy as np

import chamber
import recording

NAMES = ["leak_in", "leak_out", "gain", "threshold_in", "threshold_out", "corner", "volume_weight"]
BOUNDS = [(0, 20), (0, 20), (1e-2, 1e3), (-1, 1), (-1, 1), (1e-4, 10), (0, 3)]
NOMINAL = [0.02, 0.02, 2.0, 0.0, 0.0, 0.1, 1.0]
CONTROL = {"ftol": 1e-14, "xtol": 1e-14, "gtol": 1e-14}


def parameters(start_kpa=None, values=NOMINAL):
    p = lmfit.Parameters()
    for name, value, (low, high) in zip(NAMES, values, BOUNDS):
        p.add(name, value, min=low, max=high)
    if start_kpa is not None:
        p.add("start_kpa", start_kpa)
    return p


def values(p):
    return np.array([p[name].value for name in NAMES])


def rollout_residual(p, data):
    drive, supply, volume, volume_rate, _, measured = data
    out = chamber.rollout(
        values(p), p["start_kpa"].value * 1e3, recording.DT, drive, supply, volume, volume_rate, False
    )
    return (out - measured) * 1e-3


def slopes(measured):
    """Least-squares parabola through two samples on either side of each interval's middle: pressure, rate, interval."""
    p = np.lib.stride_tricks.sliding_window_view(measured, 4)
    x = np.array([-1.5, -0.5, 0.5, 1.5])
    s2, s4 = np.sum(x**2), np.sum(x**4)
    return p @ ((s4 - s2 * x**2) / (4 * s4 - s2**2)), p @ (x / s2) / recording.DT, np.arange(1, len(measured) - 2)


def flow_pressure(high, low):
    ratio = low / high
    z = (np.clip(ratio, chamber.B_CRITICAL, chamber.LAMINAR) - chamber.B_CRITICAL) / (1 - chamber.B_CRITICAL)
    psi = chamber.PSI_MAX * np.sqrt(1 - z * z)
    return high * np.where(ratio > chamber.LAMINAR, psi * (1 - ratio) / (1 - chamber.LAMINAR), psi)


def rates(q, pressure, drive, supply, volume, volume_rate):
    """The nonlinear model's rate in numpy, all samples at once."""
    corner = lambda x: (np.sqrt(x * x + q[5] ** 2) + x) / 2
    a_in = q[0] + corner(q[2] * (drive - q[3]) - q[0])
    a_out = q[1] + corner(q[2] * (q[4] - drive) - q[1])
    signed = lambda a, b: np.where(a >= b, 1, -1) * flow_pressure(np.maximum(a, b), np.minimum(a, b))
    flow = (a_in * signed(supply, pressure) - a_out * signed(pressure, chamber.AMBIENT)) * 1e-6
    scale = chamber.GAMMA * chamber.R * chamber.T * np.sqrt(2 / (chamber.R * chamber.T))
    return scale / volume * flow - chamber.GAMMA * q[6] * volume_rate * pressure / volume


def rate_residual(p, pressure, rate, drive, supply, volume, volume_rate):
    return (rates(values(p), pressure, drive, supply, volume, volume_rate) - rate) * 1e-3


def rate_arguments(data):
    drive, supply, volume, volume_rate, _, measured = data
    pressure, rate, k = slopes(measured)
    return pressure, rate, drive[k], supply[k], volume[k], volume_rate[k]


def main():
    here = Path(__file__).parent
    data = recording.make(1500)
    with open(here / "fit_inputs.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["t_s", "u", "command_pa", "supply_pa", "volume_m3", "volume_rate_m3_s", "measured"])
        drive, supply, volume, volume_rate, _, measured = data
        for k in range(len(drive)):
            row = (k * recording.DT, drive[k], chamber.AMBIENT, supply[k], volume[k], volume_rate[k])
            writer.writerow([repr(float(x)) for x in row] + [f"{measured[k]:.6f}"])
    start = parameters(data[5][0] * 1e-3)
    fits = {
        "rollout": lmfit.minimize(rollout_residual, start, args=(data,), **CONTROL),
        "rate": lmfit.minimize(rate_residual, parameters(), args=rate_arguments(data), **CONTROL),
    }
    with open(here / "fits.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["fit", "parameter", "value", "standard_error"])
        for name, fit in fits.items():
            writer.writerow([name, "chi_square", f"{fit.chisqr:.10g}", ""])
            for p in fit.params.values():
                writer.writerow([name, p.name, f"{p.value:.10g}", f"{p.stderr:.10g}"])


if __name__ == "__main__":
    main()
