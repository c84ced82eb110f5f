"""What ``pneudrive-model export jax`` writes needs JAX only, and gives the pressures of ``pneudrive-model simulate``."""

import csv
import os
import subprocess
import sys

import numpy as np

PROGRAM = os.environ["PNEUDRIVE_MODEL"]
ROWS, INTERVAL_S = 500, 0.01
MODEL = """
schema = "pneudrive-extended/1"
model = "nonlinear"
[rig]
supply = { pressure_kpa = 530.0 }
chamber = { volume_m3 = 3.6e-4 }
valve = { critical_ratio = 0.35, discharge_coefficient = 0.9 }
ambient = { pressure_kpa_abs = 95.0, temperature_k = 285.0 }
[channels.b0c0]
drive = "spool"
noise_kpa = 0.3
command_range_kpa = 300.0
parameters = { gain = 2.0, corner = 0.1, leak_in = 0.02, leak_out = 0.01, threshold_in = 0.05, threshold_out = -0.03, volume_weight = 1.0 }
"""

#: Runs where the package is, without pneudrive_py.
USER = """
import sys
sys.modules["pneudrive_py"] = None
import jax
jax.config.update("jax_enable_x64", True)
import numpy as np
import chambers
channel = chambers.CHANNELS["b0c0"]
np.save("found.npy", channel.rollout(100.0, np.load("drive.npy"), 0.01))
slope = jax.grad(channel.dp)(100.0, 0.3)
assert slope < 0 < channel.dp(100.0, 0.3), slope
"""


def test_an_exported_package_simulates_as_the_program_does(tmp_path):
    (tmp_path / "model.toml").write_text(MODEL)
    # Recordings are in single precision.
    drive = np.repeat(np.random.default_rng(3).uniform(-0.5, 0.6, ROWS // 10), 10).astype(np.float32).astype(float)
    np.save(tmp_path / "drive.npy", drive)
    with open(tmp_path / "run.csv", "w") as file:
        file.write("t_s,b0_u0\n")
        file.writelines(f"{INTERVAL_S * k:.2f},{u!r}\n" for k, u in enumerate(drive.tolist()))
    run = {"cwd": tmp_path, "check": True}
    subprocess.run([PROGRAM, "export", "jax", "--parameters", "model.toml", "--out", "chambers"], **run)
    simulate = [PROGRAM, "simulate", "run.csv", "--parameters", "model.toml", "--start-kpa", "100", "--out", "expected.csv"]
    subprocess.run(simulate, **run)
    subprocess.run([sys.executable, "-c", USER], **run)
    with open(tmp_path / "expected.csv") as file:
        lines = (line for line in file if not line.startswith("#"))
        expected = np.array([float(row["b0_p0_kpa"]) for row in csv.DictReader(lines)])
    found = np.load(tmp_path / "found.npy")
    assert np.ptp(expected) > 100
    print(f"largest difference {np.abs(found - expected).max():.5f} kPa")
    assert np.abs(found - expected).max() < 0.005
