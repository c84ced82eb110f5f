"""Batches of calibrated models, effects included: the numbers of `simulate`, with exact derivatives."""

import numpy as np
import pytest

import pneudrive_py as pneu
from pneudrive_py import DataError

INTERVAL_S = 0.02
# A delay of a whole number of the simulation's steps has two derivatives.
DELAYED = '\n[channels.b0c0.effects.valve_lag]\ntime_constant = 0.05\n[channels.b0c0.effects.transport_delay]\ndelay = 0.0313\n'


@pytest.fixture(scope="module")
def extended(fit, tmp_path_factory):
    """The fit's model, the spool of whose channel 0 is late."""
    folder = tmp_path_factory.mktemp("calibrated")
    fit.parameters.save(folder / "fit.toml")
    plain = pneu.ExtendedModel.load(folder / "fit.toml")
    (folder / "extended.toml").write_text(plain.to_toml() + DELAYED)
    return pneu.ExtendedModel.load(folder / "extended.toml")


@pytest.fixture(scope="module")
def drive(recording):
    return np.stack([recording["b0_u0"], recording["b0_u1"]])


def batch(model, drive, parameters=None, **more):
    arguments = {"drive": drive, "channel": "b0c0", "start_kpa": 100.0} | more
    return pneu.simulate_batch(model, parameters, INTERVAL_S, **arguments)


def test_effects_are_simulated_as_in_a_recording(extended, recording, drive):
    simulated = pneu.simulate(recording, extended).pressure_kpa
    for channel in range(2):
        start = recording[f"b0_p{channel}_kpa"][0]
        # The other chamber's drive beside it: each has its own.
        found = batch(extended, drive[[channel, 1 - channel]], channel=f"b0c{channel}", start_kpa=start)
        np.testing.assert_allclose(found[0], simulated[:, channel], atol=1e-6)
        assert np.ptp(found[0]) > 50 and np.abs(found[1] - found[0]).max() > 10


def test_a_fit_is_simulated_with_what_it_chose(fit, rig, drive):
    parameters = fit.parameters
    substeps = parameters.to_dict()["channels"]["b0c1"]["substeps"]
    expected = pneu.simulate_batch(
        "nonlinear", parameters.array("b0c1"), INTERVAL_S, drive=drive, start_kpa=100.0, rig=rig, substeps=substeps
    )
    np.testing.assert_array_equal(batch(parameters, drive, channel="b0c1"), expected)
    by_command = {"controller": True, "drive": None, "command_kpa": np.repeat([60.0, 180.0], 100)}
    expected = pneu.simulate_batch(
        "nonlinear", parameters.array("b0c0"), INTERVAL_S, command_kpa=by_command["command_kpa"], start_kpa=100.0, rig=rig,
        controller=True, substeps=3,
    )
    np.testing.assert_array_equal(batch(parameters, substeps=3, **by_command), expected)


def test_the_boards_loop_in_front_of_effects_follows_as_step_by_step(extended):
    command = np.repeat([60.0, 180.0, 120.0], 50)
    stepper = pneu.Stepper(extended, channels=["b0c0"], step_s=INTERVAL_S, control="set_point")
    stepped = [stepper.reading_kpa[0]]
    for kpa in command[:-1]:
        stepper.step(set_point_kpa=kpa)
        stepped.append(stepper.reading_kpa[0])
    found = batch(extended, None, command_kpa=command, controller=True, start_kpa=0.0)[0]
    np.testing.assert_allclose(found, stepped, atol=1e-6)
    assert abs(found[45] - 60.0) < 8.0 and abs(found[95] - 180.0) < 8.0


def test_parameters_of_effects_are_parameters(extended, drive):
    listed = pneu.model_parameters(extended, channel="b0c0")
    names = [parameter["name"] for parameter in listed]
    assert names[:3] == ["leak_in", "leak_out", "gain"] and names[7:] == ["transport_delay.delay", "valve_lag.time_constant"]
    values = np.array([parameter["value"] for parameter in listed])
    assert list(values[7:]) == [0.0313, 0.05] and listed[2]["value"] == extended.values("b0c0")["gain"]
    calibrated = batch(extended, drive[0])
    np.testing.assert_array_equal(batch(extended, drive[0], values), calibrated)
    # What a dict leaves out is as it was calibrated.
    lags = batch(extended, drive[0], {"valve_lag.time_constant": [0.05, 0.1]})
    np.testing.assert_array_equal(lags[0], calibrated[0])
    assert np.abs(lags[1] - lags[0]).max() > 1.0


def test_derivatives_by_every_parameter_are_those_of_differences(extended, drive):
    values = np.array([parameter["value"] for parameter in pneu.model_parameters(extended, channel="b0c0")])
    rows = drive[:, :120]
    more = {"volume_m3": 3.6e-4 * (1.0 + 0.2 * np.sin(0.1 * np.arange(120)))}
    pressures, slopes = batch(extended, rows, values, sensitivities=True, **more)
    np.testing.assert_allclose(pressures, batch(extended, rows, values, **more), atol=1e-9)
    assert slopes.shape == (2, 120, len(values))
    weights = np.random.default_rng(4).uniform(-1.0, 1.0, pressures.shape)
    found = pneu.batch_gradient(extended, values, INTERVAL_S, weights, drive=rows, channel="b0c0", start_kpa=100.0, **more)
    assert set(found) == {"parameters", "start_kpa", "drive", "supply_kpa", "volume_m3"}
    np.testing.assert_allclose(found["parameters"], (weights[:, :, None] * slopes).sum(axis=(0, 1)), rtol=1e-9)
    for index, value in enumerate(values):
        step = 1e-6 * max(abs(value), 1e-3)
        moved = [values + sign * step * (np.arange(len(values)) == index) for sign in (1, -1)]
        ends = [batch(extended, rows, one, **more) for one in moved]
        difference = (ends[0] - ends[1]) / (2 * step)
        scale = np.abs(difference).max()
        assert scale > 0, index
        far = np.abs(slopes[:, :, index] - difference) > 1e-3 * scale
        assert far.mean() < 0.05, (index, far.mean())
    ends = [(weights * batch(extended, rows, values, start_kpa=100.0 + move, **more)).sum() for move in (0.01, -0.01)]
    assert found["start_kpa"] == pytest.approx((ends[0] - ends[1]) / 0.02, rel=1e-3, abs=1e-3)


def by_differences(model, given, weights, name, place, step):
    """The derivative of the weighted sum of pressures by one value of an argument."""
    ends = []
    for sign in (1.0, -1.0):
        moved = np.array(given[name], dtype=float)
        moved[place] += sign * step
        pressures = pneu.simulate_batch(model, None, INTERVAL_S, channel="b0c0", **given | {name: moved})
        ends.append((weights * pressures).sum())
    return (ends[0] - ends[1]) / (2.0 * step)


def check_inputs(model, given, steps, rows):
    """Derivatives by single values of arguments are those of differences, and of each argument in its shape."""
    weights = np.random.default_rng(5).uniform(-1.0, 1.0, (2, rows))
    found = pneu.batch_gradient(model, None, INTERVAL_S, weights, channel="b0c0", **given)
    random = np.random.default_rng(6)
    for name, step in steps.items():
        shape = np.shape(given[name])
        assert found[name].shape == shape and np.abs(found[name]).max() > 0, name
        for _ in range(8):
            place = tuple(random.integers(0, size) for size in shape)
            expected = by_differences(model, given, weights, name, place, step)
            assert found[name][place] == pytest.approx(expected, abs=2e-3 * np.abs(found[name]).max()), (name, place)
    return found


def test_derivatives_by_inputs_are_those_of_differences(extended, drive):
    """With a drive that jumps, 300 rows: more than are differentiated in one stretch."""
    rows = 300
    given = {
        "drive": np.tile(drive[:, :100], 3),
        "supply_kpa": 520.0 + 20.0 * np.sin(0.07 * np.arange(rows)),
        "volume_m3": 3.6e-4 * (1.0 + 0.2 * np.sin(0.1 * np.arange(rows))) * np.ones((2, 1)),
        "start_kpa": 100.0,
    }
    found = check_inputs(extended, given, {"drive": 1e-5, "supply_kpa": 1e-3, "volume_m3": 1e-9}, rows)
    np.testing.assert_array_equal(found["drive"][:, -1], 0.0)


def test_derivatives_by_set_points_across_their_jumps(extended):
    """The board's loop in front of the effects; the rows of the jump and those around it are among those compared."""
    rows = 90
    command = np.repeat([[60.0, 180.0, 120.0], [100.0, 150.0, 90.0]], 30, axis=1)
    given = {"command_kpa": command, "controller": True, "supply_kpa": np.full(rows, 520.0), "start_kpa": 40.0}
    found = check_inputs(extended, given, {"command_kpa": 1e-4, "supply_kpa": 1e-3}, rows)
    weights = np.random.default_rng(5).uniform(-1.0, 1.0, (2, rows))
    for row in (28, 29, 30, 31, 59, 60):
        expected = by_differences(extended, given, weights, "command_kpa", (0, row), 1e-4)
        assert found["command_kpa"][0, row] == pytest.approx(expected, abs=2e-3 * np.abs(found["command_kpa"]).max()), row


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"channel": None}, "b0c0, b0c1: say which"),
        ({"channel": "b3c0"}, "b3c0"),
        ({"channel": "first"}, "first"),
        ({"dtype": np.float32}, "float64 only"),
        ({"substeps": 2}, "leave substeps out"),
        ({"rig": "rig.toml"}, "leave rig out"),
        ({"drive": None, "fill": [0.1], "vent": [0.1]}, "one spool: give drive"),
        ({"drive": None, "command_kpa": [10.0]}, "neither drive nor"),
        ({"controller": True}, "not used"),
        ({"parameters": {"lag": 0.1}}, "valve_lag.time_constant"),
        ({"parameters": np.ones(7)}, r"\(9,\)"),
        ({"drive": [[0.0, 2.0], [0.0, 0.0]]}, "drive is 2"),
    ],
)
def test_what_cannot_be_simulated(extended, change, message):
    arguments = {"parameters": None, "drive": np.zeros((2, 5)), "channel": "b0c0"} | change
    with pytest.raises(DataError, match=message):
        pneu.simulate_batch(extended, interval_s=INTERVAL_S, **arguments)


def test_a_name_needs_parameters_and_has_no_channels(rig):
    with pytest.raises(DataError, match="parameters is None"):
        pneu.simulate_batch("nonlinear", None, INTERVAL_S, drive=[0.0], rig=rig)
    with pytest.raises(DataError, match="channel is for"):
        pneu.simulate_batch("nonlinear", np.ones(7), INTERVAL_S, drive=[0.0], rig=rig, channel="b0c0")
    with pytest.raises(TypeError, match="the name of a model, Parameters or an ExtendedModel"):
        pneu.simulate_batch(3, None, INTERVAL_S, drive=[0.0], rig=rig)


def test_a_correction_is_simulated_and_not_differentiated(extended, drive, recording, tmp_path):
    correction = (
        '\n[channels.b0c1.correction]\nvariable = "drive"\nknots = [-0.3, -0.2, -0.1, 0.1, 0.2, 0.3]\n'
        "heights = [5.0, 5.0, 5.0, 5.0, 5.0, 5.0]\n"
    )
    (tmp_path / "corrected.toml").write_text(extended.to_toml() + correction)
    corrected = pneu.ExtendedModel.load(tmp_path / "corrected.toml")
    start = recording["b0_p1_kpa"][0]
    found = batch(corrected, drive[1], channel="b0c1", start_kpa=start)
    np.testing.assert_allclose(found[0], pneu.simulate(recording, corrected).pressure_kpa[:, 1], atol=1e-6)
    assert np.abs(found - batch(extended, drive[1], channel="b0c1", start_kpa=start)).max() > 1.0
    with pytest.raises(DataError, match="smooth correction"):
        batch(corrected, drive[1], channel="b0c1", sensitivities=True)
    with pytest.raises(DataError, match="smooth correction"):
        pneu.batch_gradient(corrected, None, INTERVAL_S, 1.0, drive=drive[1], channel="b0c1")
