"""Exports of one calibrated joint, made by the command line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parent
PARAMETERS = FOLDER.parent / "data" / "joint.toml"
MODEL = os.environ.get("PNEUDRIVE_MODEL", str(FOLDER.parents[2] / "target" / "debug" / "pneudrive-model"))


def model(*arguments):
    """Runs pneudrive-model; returns what it prints."""
    done = subprocess.run([MODEL, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def simulate(folder, rows, parameters=PARAMETERS):
    """What `pneudrive-model simulate` says of inputs: column name to values in, readings of channel b0c0 out."""
    names = list(rows)
    lines = [",".join(names)] + [",".join(f"{v:.9g}" for v in row) for row in zip(*rows.values())]
    inputs, outputs = folder / "inputs.csv", folder / "outputs.csv"
    inputs.write_text("\n".join(lines) + "\n")
    model("simulate", inputs, "--parameters", parameters, "--out", outputs)
    table = [line for line in outputs.read_text().splitlines() if not line.startswith("#")]
    column = table[0].split(",").index("b0_p0_kpa")
    return [float(line.split(",")[column]) for line in table[1:]]


@pytest.fixture(scope="session")
def exported(tmp_path_factory):
    """A folder with the plugin, built against this Python's mujoco."""
    folder = tmp_path_factory.mktemp("mujoco")
    model("export", "mujoco", "--parameters", PARAMETERS, "--out", folder)
    subprocess.run(["sh", str(folder / "build.sh"), sys.executable], check=True)
    return folder
