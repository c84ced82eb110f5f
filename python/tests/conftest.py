"""A recording small enough to fit in a second, made by the batch simulation itself: what is tested is the bindings."""

import numpy as np
import pytest

import pneudrive_py as pneu

RIG_TOML = """
[supply]
pressure_kpa = 550.0
[chamber]
radius_m = 0.024
length_m = 0.2
offset_m = 0.045
[controller]
rate_hz = 100.0
kp = 10.0
kd = 0.0
saturation = 400.0
filter = 0.0
[sensor]
bits = 10
zero_counts = 102.4
kpa_per_count = 0.841645
"""

#: mm2, mm2, mm2, 1, 1, mm2, 1: what the recording was made with, a different gain for each channel
TRUE_PARAMETERS = np.array([[0.02, 0.02, 2.0, 0.05, 0.03, 0.1, 1.0], [0.02, 0.02, 2.4, 0.05, 0.03, 0.1, 1.0]])


@pytest.fixture(scope="session")
def rig():
    return pneu.Rig.parse(RIG_TOML)


@pytest.fixture(scope="session")
def rig_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("rig") / "rig.toml"
    path.write_text(RIG_TOML)
    return path


@pytest.fixture(scope="session")
def columns(rig):
    """20 s at 50 Hz, two channels: drives held for 0.4 s each, 0.3 kPa of noise."""
    random = np.random.default_rng(1)
    rows, interval_s = 1000, 0.02
    drive = np.repeat(random.uniform(-0.3, 0.3, (2, rows // 20)), 20, axis=1)
    pressure = pneu.simulate_batch("nonlinear", TRUE_PARAMETERS, interval_s, drive=drive, start_kpa=100.0, rig=rig)
    noisy = pressure + random.normal(0.0, 0.3, pressure.shape)
    columns = {"t_s": interval_s * np.arange(rows)}
    for channel in range(2):
        columns[f"b0_u{channel}"] = drive[channel]
        columns[f"b0_cmd{channel}_kpa"] = np.clip(pressure[channel], 0.0, 600.0)
        columns[f"b0_p{channel}_kpa"] = noisy[channel]
    return columns


@pytest.fixture(scope="session")
def recording(columns, rig):
    return pneu.Recording.from_columns(columns, rig=rig)


@pytest.fixture(scope="session")
def fit(recording, rig):
    return pneu.fit(recording, rig, fit_fraction=0.8, starts=2)
