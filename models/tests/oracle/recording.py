"""A recording in the project's measured-data format with its rig file, made by the Python model: 0.36 kPa of white noise.

    python recording.py DIRECTORY [ROWS]
"""

import sys
from pathlib import Path

import numpy as np

import chamber

DT, SIGMA = 0.01, 360.0
TRUTH = np.array([0.03, 0.05, 4.0, 0.12, -0.09, 0.15, 1.0])
RIG = """[supply]
pressure_kpa = 550.0
[ambient]
pressure_kpa_abs = 101.325
temperature_k = 293.15
[chamber]
radius_m = 0.024
length_m = 0.20
offset_m = 0.045
[valve]
discharge_coefficient = 1.0
critical_ratio = 0.30
"""


def make(rows, seed=3):
    """Drive, supply, volume, volume rate, angle, measured pressure (Pa absolute)."""
    drive, volume, volume_rate, angle = chamber.excitation(rows, DT, seed)
    supply = np.full(rows, 550e3 + chamber.AMBIENT)
    clean = chamber.rollout(TRUTH, 200e3, DT, drive, supply, volume, volume_rate, False)
    measured = clean + SIGMA * np.random.default_rng(seed + 1).standard_normal(rows)
    return drive, supply, volume, volume_rate, angle, measured


def write(directory, rows):
    drive, _, _, _, angle, measured = make(rows)
    directory = Path(directory)
    (directory / "rig.toml").write_text(RIG)
    with open(directory / "recording.csv", "w") as file:
        file.write("t_s,b0_p0_kpa,b0_u0,b0_qu_rad,b0_qv_rad\n")
        for k in range(rows):
            kpa = (measured[k] - chamber.AMBIENT) / 1e3
            file.write(f"{k * DT:.2f},{kpa:.6f},{drive[k]:.15g},{angle[k]:.15g},0\n")


if __name__ == "__main__":
    write(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 20_000)
