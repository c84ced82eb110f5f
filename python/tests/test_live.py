"""Trajectories, cycles one by one, callbacks and asyncio, against virtual boards."""

import asyncio
import time

import numpy as np
import pytest

import pneudrive_py as pneu
from pneudrive_py import CommandError, DataError, FileError, PressureController
from pneudrive_py.live import AsyncPoller, Watcher, rows


@pytest.fixture()
def controller():
    with PressureController("sim", 2, timing="instant", timeout=2.0) as controller:
        controller.ping_devices()
        yield controller


def test_sim_waits_longer_than_a_wire():
    with PressureController("sim", 1, timing="instant") as controller:
        assert controller.timeout == 0.02


def test_all_boards_at_once(controller):
    controller.set_all([[10, 20, 30, 40], [50, 60, 70, 80]])
    assert controller.get_all().shape == (2, 4) and np.isfinite(controller.get_all()).all()
    controller.set_all(25.0)
    with pytest.raises(CommandError, match=r"shape \(2, 4\), got shape \(3, 4\)"):
        controller.set_all(np.zeros((3, 4)))
    with controller.poll(200) as poller:
        poller.set_all([[10, 20, 30, 40], [50, 60, 70, 80]])
        row = poller.wait()
        while row["commands_kpa"][1, 3] < 70.0:
            row = poller.wait(row["cycle"])
        np.testing.assert_allclose(row["commands_kpa"], [[10, 20, 30, 40], [50, 60, 70, 80]], atol=0.5)
        with pytest.raises(CommandError, match="board 1, channel 2"):
            poller.set_all([[0, 0, 0, 0], [0, 0, -5, 0]])
        assert poller.get_all().shape == (2, 4)


def test_a_command_of_zero_reads_back_as_zero(controller):
    with controller.poll(200) as poller:
        row = poller.wait()
        assert (row["commands_kpa"] == 0.0).all()
        history = poller.history()
        assert (history["commands_kpa"] == 0.0).all()


def test_figures_are_there_at_once(controller):
    with controller.poll(200) as poller:
        first = poller.statistics()
        assert first is not None and first["devices"] == 2
        while poller.statistics()["cycles"] <= first["cycles"]:
            poller.wait()


@pytest.mark.parametrize("pressures", [np.array([1 + 2j] * 4), [True] * 4, "1234", np.array(["1"] * 4)])
def test_what_is_no_pressure_is_refused(controller, pressures):
    with pytest.raises(CommandError, match="board 0"):
        controller.set_pressure_commands(0, pressures)


def test_a_trajectory_is_played_to_its_end(controller):
    trajectory = {"t_s": [0.0, 0.5, 1.0], "b0_cmd0_kpa": [0.0, 100.0, 100.0], "b1_cmd3_kpa": [20.0, 20.0, 20.0]}
    poller = controller.play(trajectory, 200, interpolation="linear")
    with pytest.raises(CommandError, match="a trajectory commands the boards"):
        poller.set_pressure_commands(0, [1, 2, 3, 4])
    assert poller.join(30.0)
    history = poller.history()
    commands = history["commands_kpa"]
    # A straight line up to 0.5 s, wherever the cycles of a busy machine fall.
    expected = np.interp(history["t_s"], [0.0, 0.5], [0.0, 100.0])
    inside = history["t_s"] < 1.0
    assert np.abs(commands[inside, 0, 0] - expected[inside]).max() < 1.0
    np.testing.assert_allclose(commands[inside, 1, 3], 20.0, atol=0.5)
    assert (commands[inside, 0, 1:] == 0.0).all()
    assert "trajectory has ended" in repr(poller)
    # The bus is free again.
    controller.set_pressure_commands(0, [0, 0, 0, 0])


def test_a_recording_is_a_trajectory(controller, tmp_path):
    columns = {"t_s": [0.0, 0.1, 0.2], "b0_cmd0_kpa": [10.0, 20.0, 20.0], "b0_p0_kpa": [1.0, 2.0, 3.0]}
    recording = pneu.Recording.from_columns(columns)
    assert controller.play(recording, 200).join(30.0)
    recording.save(tmp_path / "run.csv")
    assert controller.play(tmp_path / "run.csv", 200).join(30.0)


def test_columns_that_do_nothing_in_a_trajectory_are_named(controller, tmp_path):
    columns = {"t_s": [0.0, 0.1], "b0_cmd0_kpa": [10.0, 20.0], "bend, deg": [1.0, 2.0]}
    with pytest.warns(UserWarning, match="ignored, .*: bend, deg$"):
        assert controller.play(columns, 200).join(30.0)
    (tmp_path / "run.csv").write_text("t_s,b0_cmd0_kpa,note\n0,10,a\n0.1,20,b\n")
    with pytest.warns(UserWarning, match="ignored, .*: note$"):
        assert controller.play(tmp_path / "run.csv", 200).join(30.0)


def test_trajectories_that_cannot_be_played(controller, tmp_path):
    with pytest.raises(DataError, match="t_s"):
        controller.play({"b0_cmd0_kpa": [1.0]})
    with pytest.raises(FileError, match="missing.csv"):
        controller.play(tmp_path / "missing.csv")
    for misspelt in ["b0_cmd_1_kpa", "b0_cdm1_kpa"]:
        with pytest.raises(DataError, match=f"column {misspelt} is not one .* did you mean b0_cmd1_kpa"):
            controller.play({"t_s": [0.0, 1.0], "b0_cmd0_kpa": [1.0, 2.0], misspelt: [1.0, 2.0]})
    with pytest.raises(DataError, match="column b7_cmd0_kpa: there are boards 0 to 1, .*; see num_devices$"):
        controller.play({"t_s": [0.0, 1.0], "b7_cmd0_kpa": [1.0, 2.0]})
    with pytest.raises(CommandError, match="interpolation"):
        controller.play({"t_s": [0.0, 1.0], "b0_cmd0_kpa": [1.0, 2.0]}, interpolation="cubic")
    with PressureController("sim", 1, timing="instant", timeout=2.0, max_kpa=50.0) as limited:
        with pytest.raises(CommandError, match="nothing was sent"):
            limited.play({"t_s": [0.0, 1.0], "b0_cmd0_kpa": [1.0, 60.0]})


def test_venting_ends_a_trajectory_for_good(controller):
    with controller.play({"t_s": [0.0, 60.0], "b0_cmd0_kpa": [100.0, 100.0]}, 200) as poller:
        poller.vent()
        poller.release()
        poller.set_pressure_commands(0, [0.0, 30.0, 0.0, 0.0])
        row = poller.wait()
        while row["commands_kpa"][0, 1] < 29.0:
            row = poller.wait(row["cycle"])
        assert row["commands_kpa"][0, 0] == 0.0


def test_cycles_one_by_one(controller):
    seen = []
    with controller.poll(200) as poller:
        for row in rows(poller):
            seen.append(row["cycle"])
            if len(seen) == 5:
                break
    assert seen == sorted(set(seen))
    with pytest.raises(pneu.PortError, match="has ended"):
        poller.wait()


def test_a_callback_sees_cycles_and_its_errors_are_raised(controller):
    seen = []
    with controller.poll(200) as poller:
        with Watcher(poller, seen.append) as watcher:
            while len(seen) < 3:
                time.sleep(0.005)
            assert watcher.running
        assert {"cycle", "t_s", "commands_kpa", "pressures_kpa"} == seen[0].keys()

        def fail(row):
            raise RuntimeError("as the callback says")

        watcher = Watcher(poller, fail)
        while watcher.running:
            time.sleep(0.005)
        with pytest.raises(RuntimeError, match="as the callback says"):
            watcher.stop()
        watcher.stop()


def test_asyncio(controller):
    async def follow():
        seen, ticks = [], 0

        async def tick():
            nonlocal ticks
            while True:
                ticks += 1
                await asyncio.sleep(0.001)

        async with AsyncPoller(controller.poll(200)) as poller:
            ticking = asyncio.create_task(tick())
            poller.set_all(10.0)
            async for row in poller:
                seen.append(row["cycle"])
                if len(seen) == 5:
                    break
            ticking.cancel()
        return seen, ticks

    seen, ticks = asyncio.run(follow())
    assert seen == sorted(set(seen)) and ticks > 0
    assert "polled" not in repr(controller)
