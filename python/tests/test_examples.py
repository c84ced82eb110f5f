"""The examples run, and the environment is what Gymnasium expects."""

import csv
import gzip
import shutil
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "examples"))


@pytest.fixture(scope="module")
def joint_env():
    import joint_env

    return joint_env


def test_gymnasiums_checker_finds_nothing(joint_env):
    from gymnasium.utils.env_checker import check_env

    env = joint_env.gymnasium.make("PneuDrive/Joint-v0", seconds=0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)


def test_filling_one_side_bends_the_joint_to_the_other(joint_env):
    env = joint_env.JointEnv(seconds=1.0, spread=0.0)
    env.reset(seed=1)
    ended = False
    while not ended:
        observation, _, _, ended, _ = env.step(np.array([0.3, -0.3, -0.3, 0.3]))
    angles, pressures = observation[:2], observation[4:8]
    assert angles[0] > 0.2 and angles[1] < -0.2
    assert pressures[0] > 1.0 > pressures[1]


def test_joints_in_lockstep_are_joints_alone(joint_env):
    together = joint_env.Joints(3)
    alone = joint_env.Joints(1)
    drives = np.array([[0.1, -0.1, 0.0, 0.2], [0.4, -0.4, 0.3, -0.3], [0.0, 0.0, 0.0, 0.0]])
    together.step(drives, 0.1)
    alone.step(drives[1:2], 0.1)
    np.testing.assert_allclose(together.angles_rad[1], alone.angles_rad[0], rtol=1e-9)
    np.testing.assert_allclose(together.pressures_kpa[1], alone.pressures_kpa[0], rtol=1e-9)


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
