"""Reference rollouts for tests/rollout_oracle.rs: SciPy's DOP853 at a relative tolerance of 1e-12, restarted at each sample
because the inputs jump there. Writes rollouts.csv: inputs, then the pressures of each model (absolute, Pa).

    pip install -r requirements.txt && python rollouts.py
"""

import csv
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import chamber

ROWS, DT, START = 400, 0.01, 250e3
SPOOL = (0.03, 0.05, 4.0, 0.12, -0.09, 0.15, 0.9)
SEPARATE = (0.03, 0.05, 4.0, 6.0, 0.12, 0.2, 0.15, 1.1)
PARAMETRIC = (0.02, 4.0, 2.0, -30.0, 1.5, 0.8, 12.0, 0.1, 0.03, 0.08)
LINEAR = (4.0, 3.5)


def main():
    drive, volume, volume_rate, _ = chamber.excitation(ROWS, DT, 7)
    drive[200:380] = -0.9  # down to ambient, without supply: the laminar segment and flow backwards
    rng = np.random.default_rng(8)
    supply = 650e3 + 20e3 * np.sin(np.arange(ROWS) / 30)
    supply[260:380] = 100e3
    volume[300:380], volume_rate[300:380] = volume[300], 0
    command = np.repeat(rng.uniform(150e3, 500e3, ROWS // 50), 50)

    def models(k):
        fill, vent = drive[k], -drive[k]
        gas = (supply[k], volume[k], volume_rate[k])
        spool = chamber.spool_areas(SPOOL, fill, vent)
        valves = chamber.separate_areas(SEPARATE, max(fill, 0), max(vent, 0))
        return {
            "nonlinear": lambda p: chamber.nonlinear(p, spool, *gas, SPOOL[6], False),
            "printed": lambda p: chamber.nonlinear(p, spool, *gas, SPOOL[6], True),
            "separate": lambda p: chamber.nonlinear(p, valves, *gas, SEPARATE[7], False),
            "parametric": lambda p: chamber.parametric(p, PARAMETRIC, fill, *gas),
            "linear": lambda p: chamber.linear(p, LINEAR, command[k]),
        }

    names = list(models(0))
    pressures = {name: [START] for name in names}
    for k in range(ROWS - 1):
        for name, rate in models(k).items():
            step = solve_ivp(
                lambda _, p: [rate(p[0])], (0, DT), [pressures[name][-1]], "DOP853", rtol=1e-12, atol=1e-7, max_step=DT / 4
            )
            pressures[name].append(float(step.y[0, -1]))
    with open(Path(__file__).with_name("rollouts.csv"), "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["t_s", "u", "command_pa", "supply_pa", "volume_m3", "volume_rate_m3_s", *names])
        for k in range(ROWS):
            inputs = (k * DT, drive[k], command[k], supply[k], volume[k], volume_rate[k])
            writer.writerow([repr(float(x)) for x in inputs] + [f"{pressures[name][k]:.6f}" for name in names])


if __name__ == "__main__":
    main()
