"""The actuator plugin in MuJoCo gives the pressures of `pneudrive-model simulate`, and behaves as MuJoCo's users expect."""

import copy
import re
import subprocess
import sys
import time

import mujoco
import mujoco.rollout
import numpy as np
import pytest

from conftest import FOLDER, PARAMETERS, model, simulate

MOST_KPA = 0.005
OFFSET_M = 0.045


@pytest.fixture(scope="session", autouse=True)
def plugin(exported):
    mujoco.mj_loadPluginLibrary(str(exported / "libpneudrive_actuator.so"))


def chamber(name="b0c0", joint="hinge", parameters=PARAMETERS, gear=OFFSET_M, actdim='actdim="1"', **keys):
    area = np.pi * 0.024**2
    config = {"parameters": parameters, "channel": name, "area": area, **keys}
    lines = "".join(f'<config key="{k}" value="{v}"/>' for k, v in config.items())
    return f'<plugin joint="{joint}" gear="{gear}" plugin="pneudrive.chamber" {actdim}>{lines}</plugin>'


def world(actuators, joints=("hinge",), integrator="implicitfast", plugins=True):
    bodies = "".join(
        f'<body pos="0 0 {k}"><joint name="{j}" axis="0 1 0" damping="3" stiffness="40"/>'
        f'<geom size=".1" mass="5"/></body>'
        for k, j in enumerate(joints)
    )
    extension = '<extension><plugin plugin="pneudrive.chamber"/></extension>' if plugins else ""
    return (
        f'<mujoco><option timestep="0.001" gravity="0 0 0" integrator="{integrator}"/>{extension}'
        f"<worldbody>{bodies}</worldbody><actuator>{actuators}</actuator></mujoco>"
    )


def set_points(rows, seed=1):
    rng = np.random.default_rng(seed)
    levels = np.repeat(rng.uniform(20, 280, rows // 150 + 1), 150)[:rows]
    return levels.astype(np.float32).astype(float)


def test_a_locked_joint_has_the_pressures_of_simulate(tmp_path):
    commands = set_points(3000)
    expected = simulate(tmp_path, {"t_s": np.arange(3000) * 0.001, "b0_cmd0_kpa": commands})
    m = mujoco.MjModel.from_xml_string(world(chamber()))
    d = mujoco.MjData(m)
    for k, command in enumerate(commands):
        assert abs(d.act[0] - expected[k]) < MOST_KPA, k
        d.qpos[:], d.qvel[:] = 0, 0
        d.ctrl[0] = command
        mujoco.mj_step(m, d)
    assert np.ptp(expected) > 100


def test_a_moving_joint_has_the_pressures_of_simulate(tmp_path):
    rows = 3000
    commands = set_points(rows, 2)
    angle = (0.6 * np.sin(0.006 * np.arange(rows))).astype(np.float32).astype(float)
    expected = simulate(
        tmp_path, {"t_s": np.arange(rows) * 0.001, "b0_cmd0_kpa": commands, "b0_qu_rad": angle}
    )
    m = mujoco.MjModel.from_xml_string(world(chamber()))
    d = mujoco.MjData(m)
    moved = 0
    for k in range(rows - 1):
        assert abs(d.act[0] - expected[k]) < MOST_KPA, k
        # The recording's volume over an interval is the mean of its ends.
        d.qpos[0] = 0.5 * (angle[k] + angle[k + 1])
        d.qvel[0] = (angle[k + 1] - angle[k]) / 0.001
        d.ctrl[0] = commands[k]
        mujoco.mj_step(m, d)
        moved = max(moved, abs(d.actuator_force[0] - 1e3 * np.pi * 0.024**2 * expected[k]))
    assert moved < 1, "force is area times pressure"


def test_states_are_saved_restored_and_copied():
    m = mujoco.MjModel.from_xml_string(world(chamber()))
    d = mujoco.MjData(m)
    commands = set_points(400)

    def run(data, rows):
        pressures = []
        for command in rows:
            data.ctrl[0] = command
            mujoco.mj_step(m, data)
            pressures.append(data.act[0])
        return pressures

    run(d, commands[:200])
    spec = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mujoco.mj_stateSize(m, spec))
    mujoco.mj_getState(m, d, state, spec)
    twin = copy.copy(d)  # mj_copyData
    expected = run(d, commands[200:])
    assert run(twin, commands[200:]) == expected
    mujoco.mj_setState(m, d, state, spec)
    assert run(d, commands[200:]) == expected
    mujoco.mj_resetData(m, d)
    fresh = mujoco.MjData(m)
    assert run(d, commands) == run(fresh, commands)


def test_a_pressure_set_by_the_user_is_where_it_goes_on_from():
    m = mujoco.MjModel.from_xml_string(world(chamber(control="drive")))
    d = mujoco.MjData(m)
    d.act[0] = 200
    mujoco.mj_step(m, d)
    assert 199 < d.act[0] < 200.5
    d.act[0] = 50
    for _ in range(3):
        mujoco.mj_step(m, d)
    assert 49 < d.act[0] < 51


def test_rollouts_in_parallel_are_those_one_by_one():
    m = mujoco.MjModel.from_xml_string(world(chamber()))
    d = mujoco.MjData(m)
    spec = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty(mujoco.mj_stateSize(m, spec))
    mujoco.mj_getState(m, d, state, spec)
    control = np.stack([set_points(300, seed)[:, None] for seed in range(6)])
    one, _ = mujoco.rollout.rollout(m, d, state, control)
    datas = [mujoco.MjData(m) for _ in range(3)]
    many, _ = mujoco.rollout.rollout(m, datas, state, control)
    assert np.array_equal(one, many)
    assert np.ptp(one[:, -1], axis=0).max() > 50


@pytest.mark.parametrize(
    "actuator, words",
    [
        (chamber(parameters="nowhere.toml"), "nowhere.toml"),
        (chamber(name="b3c0"), "the file has b0c0, b0c1, b0c2, b0c3"),
        (chamber(area="wide"), 'area="wide" is not a number'),
        (chamber(area="0"), "area"),
        (chamber(control="wish"), 'it is "set_point"'),
        (chamber(actdim=""), 'needs actdim="1"'),
    ],
)
def test_what_cannot_be_used_is_refused_with_a_sentence(actuator, words):
    with pytest.raises((ValueError, mujoco.FatalError), match=re.escape(words)):
        mujoco.MjData(mujoco.MjModel.from_xml_string(world(actuator)))


def test_an_integrator_that_divides_steps_is_refused():
    with pytest.raises((ValueError, mujoco.FatalError), match="RK4"):
        mujoco.MjData(mujoco.MjModel.from_xml_string(world(chamber(), integrator="RK4")))


def test_the_native_actuator_is_as_far_off_as_it_says(tmp_path):
    printed = model("export", "mujoco", "--native", "--parameters", PARAMETERS, "--out", tmp_path)
    xml = (tmp_path / "native.xml").read_text()
    actuator = re.search(r'<general name="b0c0".*/>', xml).group(0).replace("JOINT", "hinge")
    said_kpa = float(re.search(r"b0c0: leaves ([0-9.]+) kPa RMS", xml).group(1))
    assert f"{said_kpa:.2f}" in printed
    m = mujoco.MjModel.from_xml_string(world(actuator, plugins=False))
    d = mujoco.MjData(m)
    rows = 60_000
    rng = np.random.default_rng(5)
    commands = np.concatenate([np.full(n, rng.uniform(0, 330)) for n in rng.integers(100, 3000, 60)])[:rows]
    commands = commands.astype(np.float32).astype(float)
    rows = len(commands)
    full = np.array(simulate(tmp_path, {"t_s": np.arange(rows) * 0.001, "b0_cmd0_kpa": commands}))
    area, pressures = np.pi * 0.024**2, []
    for command in commands:
        d.qpos[:], d.qvel[:] = 0, 0
        d.ctrl[0] = command
        mujoco.mj_forward(m, d)
        pressures.append(d.actuator_force[0] / (1e3 * area))
        mujoco.mj_step(m, d)
    error = np.sqrt(np.mean((np.array(pressures) - full) ** 2))
    assert 0.7 * said_kpa < error < 1.4 * said_kpa, (error, said_kpa)


def test_speed_is_printed_beside_the_native_actuators(capsys):
    """24 chambers at 1 kHz: no pass or fail on time."""
    joints = [f"j{k}" for k in range(24)]
    ours = "".join(chamber(name=f"b0c{k % 4}", joint=j) for k, j in enumerate(joints))
    native = "".join(
        f'<general joint="{j}" dyntype="filterexact" dynprm="0.1" gainprm="1.8" biastype="affine"/>' for j in joints
    )
    for name, xml in [("plugin", world(ours, joints)), ("native", world(native, joints, plugins=False))]:
        m = mujoco.MjModel.from_xml_string(xml)
        d = mujoco.MjData(m)
        d.ctrl[:] = 150
        began = time.process_time()
        mujoco.mj_step(m, d, nstep=5000)
        spent = time.process_time() - began
        with capsys.disabled():
            print(f"\n24 chambers, {name}: {5000 / spent:.0f} steps/s of CPU time")
        assert np.isfinite(d.act).all() and d.act.min() > 100


def test_the_example_joint_bends_as_it_is_told(exported, tmp_path):
    example = FOLDER.parents[1] / "mujoco" / "examples" / "joint.py"
    trajectory = tmp_path / "trajectory.csv"
    names = ",".join(["t_s", *(f"b0_cmd{k}_kpa" for k in range(4))])
    trajectory.write_text(f"{names}\n0,100,100,100,100\n1,200,50,100,100\n3,100,100,50,200\n5,0,0,0,0\n6,0,0,0,0\n")
    out = tmp_path / "joint.csv"
    subprocess.run([sys.executable, example, exported, PARAMETERS, trajectory, out], check=True)
    table = np.genfromtxt(out, delimiter=",", names=True)

    def at(time_s):
        return table[round(time_s / 0.01)]

    assert abs(at(2.9)["b0_p0_kpa"] - 200) < 5 and abs(at(2.9)["b0_p1_kpa"] - 50) < 5
    assert at(2.9)["b0_qu_rad"] > 0.2 and abs(at(2.9)["b0_qv_rad"]) < 0.05
    assert at(4.9)["b0_qv_rad"] < -0.2 and abs(at(4.9)["b0_qu_rad"]) < 0.05
    assert abs(at(5.9)["b0_p2_kpa"]) < 5
    # The bending is fed back: the chamber that grew takes longer to fill. Simulated from the
    # recording, the pressures are the same.
    again = simulate(tmp_path, {n: table[n] for n in table.dtype.names if "_p" not in n})
    assert np.abs(np.array(again) - table["b0_p0_kpa"]).max() < 3
