"""Run by bare_wheel: what a user has after `pip install` of a wheel. Prints a line as pytest does."""

import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np

import pneudrive_py as pneu

LARGEST_BYTES = 10_000_000
MACHINES = {"x86_64": 62, "aarch64": 183}  # e_machine of ELF


def check_wheels(folder):
    """All wheels: small, for every Python from 3.10 on and any Linux, and compiled for the processor they are named after."""
    for wheel in sorted(Path(folder).glob("*.whl")):
        assert wheel.stat().st_size < LARGEST_BYTES, f"{wheel.name} has {wheel.stat().st_size} bytes"
        assert "-cp310-abi3-manylinux" in wheel.name, wheel.name
        machine = next(machine for machine in MACHINES if wheel.stem.endswith(machine))
        with zipfile.ZipFile(wheel) as content:
            programs = [name for name in content.namelist() if content.read(name)[:4] == b"\x7fELF"]
            assert len(programs) == 1, programs
            for name in programs:
                (found,) = struct.unpack_from("<H", content.read(name), 18)
                assert found == MACHINES[machine], f"{wheel.name}: {name} is for another processor"
        print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB")


def check_programs():
    for name in ("pneudrive-host", "pneudrive-sim", "pneudrive-model", "pneudrive"):
        assert Path(shutil.which(name) or "").parent == Path(sys.executable).parent, name
        said = subprocess.run([name, "--version"], check=True, capture_output=True, text=True).stdout
        assert pneu.__version__ in said, said
    said = subprocess.run(["pneudrive", "model", "effects"], check=True, capture_output=True, text=True).stdout
    assert "valve_lag" in said


def check_package():
    with pneu.PressureController("sim", 1, retries=20) as controller:
        controller.ping_devices()
        assert controller.get_pressure_data(0).shape == (4,)
    made = pneu.sim.record(seconds=5.0, rate_hz=50.0)
    assert made.recording["b0_p0_kpa"].shape == (250,)
    areas = np.array([0.02, 0.02, 2.0, 0.05, 0.03, 0.1, 1.0])
    kpa = pneu.simulate_batch("nonlinear", areas, 0.01, drive=np.ones(50), start_kpa=100.0, rig=made.rig)
    assert np.all(np.diff(kpa) >= 0.0) and kpa[..., -1] > 120.0


check_programs()
check_package()
check_wheels(sys.argv[1])
print("3 passed")
