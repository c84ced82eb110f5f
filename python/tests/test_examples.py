"""The examples run."""

import csv
import gzip
import shutil
import sys
from pathlib import Path

import numpy as np

import pneudrive_py as pneu

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "examples"))


def test_a_folder_of_recordings_becomes_one_table(tmp_path):
    import diagnose_folder

    data = HERE.parent / "notebooks" / "data"
    shutil.copy(data / "hysteresis.csv.gz", tmp_path / "a.csv.gz")
    with gzip.open(data / "hysteresis.csv.gz", "rt") as file:
        (tmp_path / "too_short.csv").write_text("".join(file.readlines()[:100]))
    table = tmp_path / "causes" / "table.csv"
    table.parent.mkdir()
    diagnose_folder.main([str(tmp_path), str(data / "rig.toml"), "--out", str(table), "--workers", "1"])
    with table.open() as file:
        rows = list(csv.DictReader(file))
    assert [row["recording"] for row in rows][0] == "a.csv.gz"
    assert "valve_hysteresis" in [row["cause"] for row in rows]
    assert rows[-1]["recording"] == "too_short.csv"
    assert rows[-1]["verdict"] == "failed" and rows[-1]["remark"]


def follow_in_virtual_time(model, controller, seconds=4.0):
    """RMS error in kPa of the channels of a model behind the boards' loop, with the reference as set points or by a controller."""
    import mpc

    plant = pneu.Stepper(model, step_s=mpc.STEP_S, control="set_point")
    plant.start(60.0)
    ahead_s = mpc.STEP_S * np.arange(mpc.HORIZON)
    errors = []
    for cycle in range(round(seconds / mpc.STEP_S)):
        wanted = mpc.reference(cycle * mpc.STEP_S + ahead_s, len(plant.channels))
        measured = plant.reading_kpa
        set_points = wanted[:, 0] if controller is None else controller.step(measured, wanted)
        if cycle * mpc.STEP_S > 1.0:
            errors.append(measured - wanted[:, 0])
        plant.step(set_point_kpa=set_points)
    return float(np.sqrt(np.mean(np.square(errors))))


def test_predictive_control_follows_better_than_the_reference_as_set_points(fit, rig):
    import mpc

    parameters = np.array([fit.parameters.array(channel) for channel in fit.channels])
    plain_kpa = follow_in_virtual_time(fit.parameters, None)
    error_kpa = follow_in_virtual_time(fit.parameters, mpc.Mpc(parameters, rig, len(parameters)))
    assert error_kpa < 0.5 * plain_kpa, (plain_kpa, error_kpa)


def test_predictive_control_runs_on_virtual_boards(capsys):
    import mpc

    plain_kpa, error_kpa = mpc.main(["--boards", "1", "--seconds", "1.5", "--identify-seconds", "6"])
    # How well it follows depends on the machine's speed here; the test above is about that.
    assert np.isfinite([plain_kpa, error_kpa]).all()
    said = capsys.readouterr().out
    assert "4 chambers, 150 cycles at 100 Hz" in said and "predictive control:" in said
