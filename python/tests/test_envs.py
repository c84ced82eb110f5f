"""The Gymnasium environments are registered, seeded, what Gymnasium expects, and the same alone and in lockstep."""

import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pneudrive_py as pneu
import pneudrive_py.envs
import pytest
from gymnasium.utils.env_checker import check_env
from pneudrive_py.joints import Joints, Randomisation

ID = "pneudrive/ContinuumJoint-v0"


def test_gymnasium_finds_it_by_name_and_its_checker_finds_nothing():
    assert gymnasium.spec(ID).entry_point is pneudrive_py.envs.ContinuumJointEnv
    env = gymnasium.make(ID, seconds=0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=True)


@pytest.mark.parametrize(
    "call",
    [
        "make('pneudrive_py.envs:pneudrive/ContinuumJoint-v0', seconds=0.1)",
        "make_vec('pneudrive_py.envs:pneudrive/ContinuumJoint-v0', num_envs=3, vectorization_mode='vector_entry_point')",
    ],
)
def test_a_name_with_its_module_needs_no_import(call):
    """Gymnasium 1.0 and later load no entry points of packages: the name has to say where it is."""
    program = f"import gymnasium; print(gymnasium.{call}.reset(seed=1)[0].shape)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == ("(3, 10)" if "make_vec" in call else "(10,)")


def test_every_episode_has_valves_of_its_own_and_a_seed_brings_them_back(fitted):
    env = gymnasium.make(ID, seconds=0.1, parameters=fitted)
    drawn = []
    for seed in (1, None, 2, 1):
        env.reset(seed=seed)
        drawn.append(env.unwrapped.joints.parameters)
    np.testing.assert_array_equal(drawn[0], drawn[3])
    assert all(np.abs(drawn[0] - other).max() > 0 for other in drawn[1:3])
    many = gymnasium.make_vec(ID, num_envs=50, vectorization_mode="vector_entry_point", parameters=fitted)
    many.reset(seed=1)
    gains = many.unwrapped.joints.parameters[:, 2]
    assert len(set(gains)) == 200


def test_filling_one_side_bends_the_joint_to_the_other():
    env = gymnasium.make(ID, seconds=1.0, spread=0.0)
    env.reset(seed=1)
    ended = False
    while not ended:
        observation, _, _, ended, _ = env.step(np.array([0.3, -0.3, -0.3, 0.3], dtype=np.float32))
    angles, pressures = observation[:2], observation[4:8]
    assert angles[0] > 0.2 and angles[1] < -0.2
    assert pressures[0] > 1.0 > pressures[1]


def test_joints_in_lockstep_are_joints_alone():
    together, alone = Joints(3), Joints(1)
    drives = np.array([[0.1, -0.1, 0.0, 0.2], [0.4, -0.4, 0.3, -0.3], [0.0, 0.0, 0.0, 0.0]])
    together.step(drives, 0.1)
    alone.step(drives[1:2], 0.1)
    np.testing.assert_allclose(together.angles_rad[1], alone.angles_rad[0], rtol=1e-9)
    np.testing.assert_allclose(together.pressures_kpa[1], alone.pressures_kpa[0], rtol=1e-9)


def run(env, count, steps):
    rng = np.random.default_rng(3)
    seen = [env.reset(seed=7)[0]]
    for _ in range(steps):
        seen.append(env.step(rng.uniform(-1, 1, (count, 4)).astype(np.float32))[0])
    return np.array(seen)


def test_a_vector_of_joints_is_seeded_and_starts_anew_after_its_end():
    make = lambda: gymnasium.make_vec(ID, num_envs=5, vectorization_mode="vector_entry_point", seconds=0.1)  # noqa: E731
    first, second = run(make(), 5, 12), run(make(), 5, 12)
    assert np.array_equal(first, second)
    assert first.shape == (13, 5, 10) and np.ptp(first[1, :, 8]) > 0
    # Five steps, then the targets are others and the pressures those of the start.
    assert np.array_equal(first[5, :, 8:], first[0, :, 8:]) and not np.array_equal(first[6, :, 8:], first[0, :, 8:])
    np.testing.assert_allclose(first[6, :, 4:8], 1.0)


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    rig = pneu.Rig(
        supply={"pressure_kpa": 550.0}, chamber={"radius_m": 0.024, "length_m": 0.2, "offset_m": 0.045}
    )
    drive = np.repeat(np.random.default_rng(1).uniform(-0.6, 0.6, 60), 20)
    truth = np.array([0.02, 0.02, 2.0, 0.05, -0.05, 0.1, 1.0])
    kpa = pneu.simulate_batch("nonlinear", truth, 0.01, drive=drive, rig=rig)[0]
    kpa += np.random.default_rng(2).normal(0, 0.5, kpa.size)
    path = tmp_path_factory.mktemp("fit") / "run.csv"
    rows = np.stack([0.01 * np.arange(drive.size), drive, kpa], axis=1)
    np.savetxt(path, rows, delimiter=",", header="t_s,b0_u0,b0_p0_kpa", comments="", fmt="%.6f")
    return pneu.fit(pneu.load(path, rig=rig), rig, model="nonlinear", starts=2).parameters


def test_valves_are_drawn_from_the_fits_covariance(fitted):
    drawn = Randomisation(fitted).draw(np.random.default_rng(4), 4000)
    stored = fitted.to_dict()["channels"]["b0c0"]
    names = [p["name"] for p in stored["parameters"]]
    gain = names.index("gain")
    deviation = np.sqrt(stored["covariance"][stored["free"].index("gain")][stored["free"].index("gain")])
    assert abs(drawn[:, gain].mean() - fitted.values("b0c0")["gain"]) < 0.1 * deviation
    assert abs(drawn[:, gain].std() / deviation - 1) < 0.1
    env = gymnasium.make(ID, seconds=0.1, parameters=fitted)
    env.reset(seed=1)
    assert env.unwrapped.joints.parameters.shape == (4, 7)


def test_what_is_no_valve_is_refused(fitted):
    with pytest.raises(pneu.DataError, match="spread is -1"):
        Randomisation(fitted, -1)
    with pytest.raises(pneu.DataError, match="radius_m, length_m, offset_m"):
        Joints(1, pneu.Rig(supply={"pressure_kpa": 500.0}, chamber={"volume_m3": 1e-4}))
