"""Batches in single precision: near those in double, in the type that was asked for, refused where they would not be."""

import numpy as np
import pytest
from conftest import TRUE_PARAMETERS

import pneudrive_py as pneu
from pneudrive_py import DataError

#: What the documentation promises over 20,000 rows, kPa.
NEAR_KPA = 0.02
ROWS = 20_000


@pytest.fixture(scope="module")
def drive():
    """Held for 0.1 to 0.3 s each, and half of the time closed."""
    random = np.random.default_rng(4)
    held = random.uniform(-0.6, 0.6, (6, ROWS // 20)) * (random.random((6, ROWS // 20)) < 0.5)
    return np.repeat(held, 20, axis=1)


def batch(drive, rig, model="nonlinear", parameters=TRUE_PARAMETERS[0], **more):
    return pneu.simulate_batch(model, parameters, 0.01, **({"drive": drive, "start_kpa": 80.0, "rig": rig} | more))


def nominal(model):
    return [parameter["nominal"] for parameter in pneu.model_parameters(model)]


@pytest.mark.parametrize("model", ["nonlinear", "parametric"])
def test_it_stays_near_double_precision(drive, rig, model):
    parameters = TRUE_PARAMETERS[0] if model == "nonlinear" else nominal(model)
    double = batch(drive, rig, model, parameters)
    single = batch(drive.astype(np.float32), rig, model, parameters, dtype=np.float32)
    assert single.dtype == np.float32 and double.dtype == np.float64
    apart = np.abs(single - double).max()
    assert 0.0 < apart < NEAR_KPA
    assert np.ptp(double) > 100.0


def test_the_linear_model_stays_near_it(rig):
    command = np.repeat(np.random.default_rng(5).uniform(0.0, 300.0, ROWS // 50), 50)
    arguments = {"command_kpa": command, "start_kpa": 0.0}
    single = batch(None, rig, "linear", [5.0, 4.0], dtype="float32", **arguments)
    double = batch(None, rig, "linear", [5.0, 4.0], **arguments)
    assert 0.0 < np.abs(single - double).max() < NEAR_KPA


def test_inputs_may_be_of_either_type(drive, rig):
    """float32 in both dimensions goes in as it is; what broadcasts, or is no contiguous array, is converted."""
    narrow = drive[:, :500].astype(np.float32)
    for dtype in (np.float32, np.float64):
        as_is = batch(narrow, rig, dtype=dtype)
        assert as_is.dtype == dtype
        for same in (narrow.astype(np.float64), np.asfortranarray(narrow), narrow.tolist()):
            np.testing.assert_array_equal(batch(same, rig, dtype=dtype), as_is)
        np.testing.assert_array_equal(batch(narrow[2], rig, dtype=dtype), as_is[2:3])
    everything = {"supply_kpa": np.full((6, 500), 500.0), "start_kpa": np.arange(6.0), "parameters": np.tile(TRUE_PARAMETERS[0], (6, 1))}
    narrowed = {name: values.astype(np.float32) for name, values in everything.items()}
    np.testing.assert_allclose(
        batch(narrow, rig, dtype=np.float32, **narrowed), batch(narrow, rig, **everything), atol=NEAR_KPA
    )


def test_a_wrong_value_is_found(drive, rig):
    for wrong in (1.5, np.nan):
        narrow = drive[:, :500].astype(np.float32)
        narrow[3, 7] = wrong
        for dtype in (np.float32, np.float64):
            with pytest.raises(DataError, match=f"drive is {'NaN' if wrong != 1.5 else wrong} at row 7 of chamber 3"):
                batch(narrow, rig, dtype=dtype)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"dtype": np.float16}, "dtype is .*float16.*; it must be numpy.float64 or numpy.float32"),
        ({"dtype": "int32"}, "dtype is 'int32'; it must be"),
        ({"dtype": "wide"}, "dtype is 'wide'; it must be"),
        ({"dtype": ">f4"}, "dtype is '>f4'; it must be"),
        ({"dtype": np.float32, "sensitivities": True}, "sensitivities are computed in float64 only"),
        ({"dtype": np.float32, "command_kpa": [50.0], "controller": True}, "controller=True.*float64 only"),
    ],
)
def test_what_is_refused(drive, rig, change, message):
    with pytest.raises(DataError, match=message):
        batch(None if "command_kpa" in change else drive[:, :20], rig, **change)
