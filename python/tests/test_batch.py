"""Thousands of chambers at once: the same numbers as one at a time, with exact derivatives, in the documented shapes."""

import numpy as np
import pytest
from conftest import TRUE_PARAMETERS

import pneudrive_py as pneu
from pneudrive_py import DataError

CHAMBERS, ROWS, INTERVAL_S = 37, 60, 0.01


@pytest.fixture(scope="module")
def drive():
    return np.random.default_rng(2).uniform(-0.5, 0.5, (CHAMBERS, ROWS))


@pytest.fixture(scope="module")
def parameters():
    spread = np.random.default_rng(3).uniform(0.9, 1.1, (CHAMBERS, 7))
    return TRUE_PARAMETERS[0] * spread


def batch(drive, parameters, rig, **more):
    arguments = {"drive": drive, "rig": rig, "start_kpa": 80.0} | more
    return pneu.simulate_batch("nonlinear", parameters, INTERVAL_S, **arguments)


def test_every_chamber_is_simulated_as_if_alone(drive, parameters, rig):
    together = batch(drive, parameters, rig)
    assert together.shape == (CHAMBERS, ROWS)
    assert together.dtype == np.float64
    np.testing.assert_allclose(together[:, 0], 80.0)
    for chamber in (0, 15, 16, CHAMBERS - 1):
        alone = batch(drive[chamber], parameters[chamber], rig)
        np.testing.assert_allclose(alone[0], together[chamber], rtol=1e-12)


def test_a_recording_simulates_the_same(recording, fit, rig):
    drive = np.stack([recording["b0_u0"], recording["b0_u1"]])
    parameters = np.stack([fit.parameters.array("b0c0"), fit.parameters.array("b0c1")])
    start = np.array([recording["b0_p0_kpa"][0], recording["b0_p1_kpa"][0]])
    # As many Runge-Kutta steps as the fit chose.
    substeps = fit.parameters.to_dict()["channels"]["b0c0"]["substeps"]
    together = pneu.simulate_batch(
        "nonlinear", parameters, 0.02, drive=drive, start_kpa=start, rig=rig, substeps=substeps
    )
    np.testing.assert_allclose(together.T, pneu.simulate(recording, fit.parameters).pressure_kpa, atol=1e-3)


def test_what_is_given_once_holds_for_all(drive, parameters, rig):
    full = batch(np.tile(drive[0], (CHAMBERS, 1)), np.tile(parameters[0], (CHAMBERS, 1)), rig, supply_kpa=500.0)
    shared = batch(drive[0], np.tile(parameters[0], (CHAMBERS, 1)), rig, supply_kpa=np.full(ROWS, 500.0))
    np.testing.assert_allclose(shared, full, rtol=1e-12)
    names = [parameter["name"] for parameter in pneu.model_parameters("nonlinear")]
    by_name = dict(zip(names, parameters.T, strict=True)) | {"volume_weight": 1.0}
    as_array = parameters.copy()
    as_array[:, names.index("volume_weight")] = 1.0
    np.testing.assert_array_equal(batch(drive, by_name, rig), batch(drive, as_array, rig))


def test_sensitivities_are_derivatives(drive, parameters, rig):
    pressures, sensitivities = batch(drive, parameters, rig, sensitivities=True)
    assert sensitivities.shape == (CHAMBERS, ROWS, 7)
    np.testing.assert_allclose(pressures, batch(drive, parameters, rig), rtol=1e-9)
    for index in range(7):
        step = 1e-6 * max(1.0, abs(TRUE_PARAMETERS[0, index]))
        up, down = parameters.copy(), parameters.copy()
        up[:, index] += step
        down[:, index] -= step
        difference = (batch(drive, up, rig) - batch(drive, down, rig)) / (2.0 * step)
        scale = np.abs(difference).max() + 1e-9
        np.testing.assert_allclose(sensitivities[:, :, index], difference, atol=1e-4 * scale)


def test_a_changing_volume_compresses_the_air(rig):
    """Closed valves: p V^gamma stays constant (volume_weight 1)."""
    closed = [1e-9, 1e-9, 2.0, 0.9, -0.9, 1e-4, 1.0]
    volume = np.linspace(3.6e-4, 3.0e-4, 50)
    pressures = pneu.simulate_batch(
        "nonlinear", closed, INTERVAL_S, drive=np.zeros(50), volume_m3=volume, start_kpa=100.0, rig=rig, substeps=4
    )
    expected = (100.0 + 101.325) * (volume[0] / volume) ** 1.4 - 101.325
    np.testing.assert_allclose(pressures[0], expected, rtol=1e-3)


def test_boards_in_front_follow_their_commands(rig):
    command = np.full((3, 300), [[50.0], [150.0], [250.0]])
    pressures = pneu.simulate_batch(
        "nonlinear", TRUE_PARAMETERS[0], INTERVAL_S, command_kpa=command, rig=rig, controller=True
    )
    np.testing.assert_allclose(pressures[:, -1], [50.0, 150.0, 250.0], atol=5.0)


def test_the_linear_model_is_a_first_order_lag():
    rate = 5.0
    pressures = pneu.simulate_batch("linear", [rate, rate], INTERVAL_S, command_kpa=np.full(100, 60.0))
    np.testing.assert_allclose(pressures[0], 60.0 * (1.0 - np.exp(-rate * INTERVAL_S * np.arange(100))), atol=1e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"drive": None}, "neither drive nor"),
        ({"drive": np.zeros((2, 3, 4))}, "shape"),
        ({"drive": np.zeros((5, 0))}, "empty"),
        ({"drive": np.zeros((0, 5))}, "empty"),
        ({"drive": []}, "empty"),
        ({"drive": [np.nan]}, "row 0"),
        ({"drive": [0.0, 1.5]}, "drive is 1.5 at row 1; it must be -1 to 1$"),
        ({"drive": "full"}, "array of numbers"),
        ({"fill": [1.0]}, "give drive, or both"),
        ({"drive": None, "fill": [1.0]}, "give drive, or both"),
        ({"parameters": np.ones(6)}, r"\(7,\) or \(chambers, 7\)"),
        ({"parameters": np.ones((0, 7))}, "empty"),
        ({"parameters": np.full(7, np.inf)}, "leak_in of chamber 0 is inf"),
        ({"parameters": {"gain": 1.0}}, "missing"),
        ({"parameters": {"gian": 1.0}}, "no parameter gian"),
        ({"start_kpa": [1.0, 2.0, 3.0]}, "3 chambers|2 chambers"),
        ({"start_kpa": np.nan}, "start_kpa"),
        ({"supply_kpa": np.zeros((2, 7))}, "rows"),
        ({"volume_m3": 0.0}, "volume_m3 is 0"),
        ({"interval_s": 0.0}, "interval_s"),
        ({"interval_s": float("nan")}, "interval_s"),
        ({"substeps": 0}, "substeps"),
        ({"model": "quadratic"}, "model is"),
        ({"command_kpa": [1.0]}, "command_kpa is for"),
        ({"rig": None}, "supply_kpa is missing"),
        ({"controller": True}, "not used"),
    ],
)
def test_what_cannot_be_simulated(rig, change, message):
    arguments = {
        "model": "nonlinear",
        "parameters": TRUE_PARAMETERS[0],
        "interval_s": INTERVAL_S,
        "drive": np.zeros((2, 5)),
        "rig": rig,
    } | change
    with pytest.raises(DataError, match=message):
        pneu.simulate_batch(**arguments)


def test_a_result_that_no_memory_holds_is_refused(rig):
    drive = np.broadcast_to(0.0, (1, 1 << 20))
    start = np.zeros(1 << 14)
    with pytest.raises(DataError, match="too large"):
        pneu.simulate_batch("nonlinear", TRUE_PARAMETERS[0], 0.01, drive=drive, start_kpa=start, rig=rig)
