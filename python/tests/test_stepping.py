"""Channels step by step: the numbers of `simulate`, with and without the board's loop, with states that come and go."""

import copy
import pickle

import numpy as np
import pytest

import pneudrive_py as pneu
from pneudrive_py import DataError

#: Rows of a recording that start at the same time as the stepper.
ROWS = 400


@pytest.fixture(scope="module")
def parameters(fit):
    return fit.parameters


def test_steps_are_those_of_a_simulation(recording, parameters):
    simulated = pneu.simulate(recording, parameters).pressure_kpa
    stepper = pneu.Stepper(parameters, step_s=0.02)
    assert stepper.channels == ["b0c0", "b0c1"] and stepper.control == "calibrated"
    drive = np.stack([recording["b0_u0"], recording["b0_u1"]], axis=1)
    stepper.start(simulated[0])
    np.testing.assert_allclose(stepper.pressure_kpa, simulated[0], rtol=1e-12)
    stepped = [stepper.step(drive=drive[row]) for row in range(ROWS)]
    np.testing.assert_allclose(stepped, simulated[1 : ROWS + 1], atol=1e-6)
    assert stepper.time_s == pytest.approx(0.02 * ROWS)
    np.testing.assert_array_equal(stepper.drive, drive[ROWS - 1])
    assert np.ptp(stepped) > 50


def test_steps_behind_the_boards_loop_are_those_of_a_batch(parameters, rig):
    command = np.repeat([60.0, 180.0, 120.0], 100)
    stepper = pneu.Stepper(parameters, channels=["b0c1"], step_s=0.02, control="set_point")
    substeps = parameters.to_dict()["channels"]["b0c1"]["substeps"]
    expected = pneu.simulate_batch(
        "nonlinear", parameters.array("b0c1"), 0.02, command_kpa=command, rig=rig, controller=True, substeps=substeps
    )[0]
    found = np.array([stepper.step(set_point_kpa=kpa)[0] for kpa in command])
    np.testing.assert_allclose(found[:-1], expected[1:], atol=1e-6)
    assert abs(found[90] - 60.0) < 5.0 and abs(found[190] - 180.0) < 5.0
    assert abs(stepper.reading_kpa[0] - found[-1]) < 1.0
    assert -1.0 <= stepper.drive[0] <= 1.0


def with_effect(folder, parameters, effect, values):
    """The fit's model, and the same with an effect in channel b0c0."""
    parameters.save(folder / "fit.toml")
    plain = pneu.ExtendedModel.load(folder / "fit.toml")
    (folder / "more.toml").write_text(f"{plain.to_toml()}\n[channels.b0c0.effects.{effect}]\n{values}\n")
    return plain, pneu.ExtendedModel.load(folder / "more.toml")


def test_effects_are_part_of_it(tmp_path, parameters):
    """A dead time of 50 ms are five steps."""
    rises = []
    for model in with_effect(tmp_path, parameters, "transport_delay", "delay = 0.05"):
        stepper = pneu.Stepper(model, channels=["b0c0"], step_s=0.01)
        for _ in range(10):
            before = stepper.step(drive=0.0)[0]
        rises.append([stepper.step(drive=0.4)[0] - before for _ in range(30)])
    plain, delayed = rises
    np.testing.assert_allclose(delayed[10], plain[5], atol=1.0)
    assert plain[4] > 10.0 > 1.0 > delayed[4]


@pytest.mark.parametrize("effect", [("valve_lag", "time_constant = 0.05"), ("transport_delay", "delay = 0.05")])
def test_the_state_holds_what_an_effect_remembers(tmp_path, parameters, effect):
    _, late = with_effect(tmp_path, parameters, *effect)
    stepper = pneu.Stepper(late, channels=["b0c0"], step_s=0.01)
    for _ in range(5):
        stepper.step(drive=0.4)
    state, other = stepper.state, pickle.loads(pickle.dumps(stepper))
    ahead = [stepper.step(drive=-0.4)[0] for _ in range(20)]
    assert ahead[1] > ahead[0], "the spool still fills"
    stepper.state = state
    for again in (stepper, other):
        np.testing.assert_array_equal([again.step(drive=-0.4)[0] for _ in range(20)], ahead)


@pytest.mark.parametrize("control", ["drive", "set_point"])
def test_states_come_and_go(parameters, control):
    given = {"drive": 0.2} if control == "drive" else {"set_point_kpa": [100.0, 150.0]}
    stepper = pneu.Stepper(parameters, step_s=0.02, control=control)
    for _ in range(20):
        stepper.step(**given)
    state = stepper.state
    assert state.dtype == np.float64 and state.ndim == 1
    copies = [copy.copy(stepper), pickle.loads(pickle.dumps(stepper)), pneu.Stepper(parameters, step_s=0.02, control=control)]
    copies[2].state = state
    ahead = [stepper.step(**given) for _ in range(20)]
    for other in copies:
        assert other.channels == stepper.channels and other.step_s == 0.02 and other.control == control
        np.testing.assert_array_equal([other.step(**given) for _ in range(20)], ahead)
    stepper.state = state
    np.testing.assert_array_equal([stepper.step(**given) for _ in range(20)], ahead)
    stepper.start([10.0, 20.0])
    assert stepper.time_s == 0.0
    np.testing.assert_allclose(stepper.pressure_kpa, [10.0, 20.0])


def test_volume_and_supply_are_the_callers(parameters):
    """A chamber behind a closed valve is compressed; a higher supply fills faster."""
    stepper = pneu.Stepper(parameters, channels=["b0c0"], step_s=0.02)
    ends = []
    for supply_kpa in (300.0, 500.0):
        stepper.start(0.0)
        ends.append(stepper.step(drive=0.3, supply_kpa=supply_kpa)[0])
    assert ends[1] > ends[0] > 1.0
    stepper.start(100.0)
    still = stepper.step(drive=0.0)[0]
    stepper.start(100.0)
    assert stepper.step(drive=0.0, volume_m3=3.6e-4, volume_rate_m3_s=-1e-3)[0] > still + 1.0


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({}, "drive is missing: b0c0 follows it"),
        ({"drive": 1.5}, r"drive\[0\] is 1.5; it must be -1 to 1"),
        ({"drive": [0.0, np.nan]}, r"drive\[1\] is NaN"),
        ({"drive": [0.0, 0.0, 0.0]}, r"drive has shape \(3,\); expected \(\) or \(2,\)"),
        ({"drive": "full"}, "drive: expected an array of numbers"),
        ({"drive": 0.0, "set_point_kpa": 100.0}, "set_point_kpa is not used by any of the channels"),
        ({"drive": 0.0, "fill": 0.1}, "fill is not used by any of the channels"),
        ({"drive": 0.0, "volume_m3": 0.0}, r"volume_m3\[0\] is 0"),
    ],
)
def test_what_no_step_can_have_changes_nothing(parameters, inputs, message):
    stepper = pneu.Stepper(parameters, step_s=0.02)
    before = stepper.state
    with pytest.raises(DataError, match=message):
        stepper.step(**inputs)
    np.testing.assert_array_equal(stepper.state, before)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"channels": ["b7c0"]}, "b7c0"),
        ({"channels": []}, "channels is empty"),
        ({"channels": ["left"]}, "left"),
        ({"step_s": 2.0}, "a step of 2 s is not possible"),
        ({"step_s": 0.015, "control": "set_point"}, "whole number of loops of the board"),
        ({"control": "thought"}, 'control is "thought"; it must be "calibrated" or "drive" or "set_point"'),
    ],
)
def test_what_cannot_be_stepped(parameters, arguments, message):
    with pytest.raises(DataError, match=message):
        pneu.Stepper(parameters, **arguments)


def test_a_state_of_something_else_is_refused(parameters):
    stepper = pneu.Stepper(parameters, step_s=0.02)
    with pytest.raises(DataError, match="state has 3 numbers; this stepper's has"):
        stepper.state = np.zeros(3)
    with pytest.raises(TypeError, match="Parameters or an ExtendedModel"):
        pneu.Stepper("fit.toml")
