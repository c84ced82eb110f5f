"""Derivatives of batches: those of central differences, by every argument, in the shape that it was given in."""

import numpy as np
import pytest
from conftest import TRUE_PARAMETERS

import pneudrive_py as pneu
from pneudrive_py import DataError

CHAMBERS, ROWS, INTERVAL_S = 5, 40, 0.01


def nominal(model, drive="spool"):
    return np.array([parameter["nominal"] for parameter in pneu.model_parameters(model, drive)])


def arguments(rig, **more):
    """Everything by chamber and row."""
    random = np.random.default_rng(6)
    time_s = INTERVAL_S * np.arange(ROWS)
    return {
        "model": "nonlinear",
        "parameters": TRUE_PARAMETERS[0] * random.uniform(0.9, 1.1, (CHAMBERS, 7)),
        "interval_s": INTERVAL_S,
        "drive": random.uniform(-0.6, 0.6, (CHAMBERS, ROWS)),
        "supply_kpa": random.uniform(500.0, 560.0, (CHAMBERS, ROWS)),
        "volume_m3": 3.6e-4 * (1.0 + 0.2 * np.sin(5.0 * time_s + np.arange(CHAMBERS)[:, None])),
        "start_kpa": random.uniform(80.0, 160.0, CHAMBERS),
        "rig": rig,
        "substeps": 2,
    } | more


WEIGHTS = np.random.default_rng(7).uniform(-1.0, 1.0, (CHAMBERS, ROWS))


def total(given, weights=WEIGHTS):
    return float((weights * pneu.simulate_batch(**given)).sum())


def check(given, names, weights=WEIGHTS, tolerance=2e-5):
    """Compares some elements of each of the arguments with differences."""
    found = pneu.batch_gradient(weights=weights, **given)
    random = np.random.default_rng(8)
    for name in names:
        values = np.asarray(given[name], dtype=float)
        slopes = found[name]
        assert slopes.shape == values.shape and slopes.dtype == np.float64, name
        assert np.abs(slopes).max() > 0, name
        places = [np.unravel_index(k, values.shape) for k in random.permutation(values.size)[:6]]
        places += [tuple(0 for _ in values.shape), tuple(size - 1 for size in values.shape)]
        for place in places:
            step = 1e-5 * max(abs(values[place]), 1e-2 if name != "volume_m3" else 0.0)
            ends = []
            for sign in (1.0, -1.0):
                moved = values.copy()
                moved[place] += sign * step
                ends.append(total(given | {name: moved}, weights))
            expected = (ends[0] - ends[1]) / (2.0 * step)
            assert abs(slopes[place] - expected) <= tolerance * np.abs(slopes).max() + 1e-9, f"{name}{place}"
    return found


EVERYTHING = ["parameters", "drive", "supply_kpa", "volume_m3", "start_kpa"]


def test_by_everything_of_the_nonlinear_model(rig):
    found = check(arguments(rig), EVERYTHING)
    assert set(found) == set(EVERYTHING)
    # What comes after the last row is of no account.
    np.testing.assert_array_equal(found["drive"][:, -1], 0.0)


def test_by_everything_of_the_parametric_model(rig):
    check(arguments(rig, model="parametric", parameters=nominal("parametric")), EVERYTHING)


def test_by_two_valves(rig):
    random = np.random.default_rng(9)
    opened = {name: random.uniform(0.05, 0.6, (CHAMBERS, ROWS)) for name in ("fill", "vent")}
    found = check(
        arguments(rig, drive=None, parameters=nominal("nonlinear", "separate"), **opened),
        ["parameters", "fill", "vent", "start_kpa"],
    )
    assert "drive" not in found


def test_by_set_points_of_the_linear_model():
    random = np.random.default_rng(10)
    given = {
        "model": "linear",
        "parameters": np.array([5.0, 4.0]),
        "interval_s": INTERVAL_S,
        "command_kpa": random.uniform(0.0, 200.0, (CHAMBERS, ROWS)),
        "start_kpa": 50.0,
    }
    found = check(given, ["parameters", "command_kpa", "start_kpa"])
    assert found["supply_kpa"].shape == () and found["supply_kpa"] == 0.0


#: A board whose converter is so fine that differences do not see its steps, with gains that do not
#: saturate.
FINE_BOARD = {
    "controller": {"rate_hz": 200.0, "kp": 0.5, "kd": 0.2, "saturation": 400.0, "filter": 0.5},
    "sensor": {"bits": 16, "zero_counts": 1000.0, "kpa_per_count": 0.0125},
}


def test_by_set_points_of_boards(rig):
    """The converter rounds, so that differences are coarse; the derivatives are those without rounding."""
    board = pneu.Rig(**{"supply": {"pressure_kpa": 550.0}, "chamber": {"volume_m3": 3.6e-4}} | FINE_BOARD)
    random = np.random.default_rng(11)
    command = 120.0 + random.uniform(-5.0, 5.0, (1, ROWS))
    given = {
        "model": "nonlinear",
        "parameters": TRUE_PARAMETERS[0],
        "interval_s": INTERVAL_S,
        "command_kpa": command,
        "start_kpa": 118.0,
        "rig": board,
        "controller": True,
    }
    weights = np.ones((1, ROWS))
    found = pneu.batch_gradient(weights=weights, **given)["command_kpa"]
    # Along a direction, far enough that many steps of the converter average out.
    step = 4.0
    ends = [total(given | {"command_kpa": command + sign * step}, weights) for sign in (1.0, -1.0)]
    expected = (ends[0] - ends[1]) / (2.0 * step)
    assert found.shape == (1, ROWS)
    assert abs(found.sum() - expected) < 0.05 * abs(expected)
    assert expected > 1.0


def test_what_broadcasts_has_the_sum(rig):
    given = arguments(rig, supply_kpa=520.0, volume_m3=np.full((CHAMBERS, 1), 3e-4), start_kpa=90.0)
    given["drive"] = given["drive"][0]
    given["parameters"] = given["parameters"][:1]
    given["start_kpa"] = np.full(CHAMBERS, 90.0)
    shared = check(given, EVERYTHING)
    full = pneu.batch_gradient(
        weights=WEIGHTS,
        **given
        | {
            "drive": np.tile(given["drive"], (CHAMBERS, 1)),
            "supply_kpa": np.full((CHAMBERS, ROWS), 520.0),
            "parameters": np.tile(given["parameters"], (CHAMBERS, 1)),
        },
    )
    np.testing.assert_allclose(shared["drive"], full["drive"].sum(axis=0))
    np.testing.assert_allclose(shared["supply_kpa"], full["supply_kpa"].sum())
    np.testing.assert_allclose(shared["parameters"], full["parameters"].sum(axis=0, keepdims=True))
    assert shared["volume_m3"].shape == (CHAMBERS, 1)


def test_what_the_rig_gave_and_what_weighs_all_rows(rig):
    given = arguments(rig)
    for name in ("supply_kpa", "volume_m3", "start_kpa"):
        del given[name]
    names = [parameter["name"] for parameter in pneu.model_parameters("nonlinear")]
    named = given | {"parameters": dict(zip(names, TRUE_PARAMETERS[0], strict=True))}
    by_array = pneu.batch_gradient(weights=1.0, **given | {"parameters": TRUE_PARAMETERS[0]})
    by_name = pneu.batch_gradient(weights=1.0, **named)
    assert {name: slopes.shape for name, slopes in by_name.items()} == {
        "parameters": (7,), "drive": (CHAMBERS, ROWS), "supply_kpa": (), "volume_m3": (), "start_kpa": ()
    }  # fmt: skip
    for name, slopes in by_name.items():
        np.testing.assert_array_equal(slopes, by_array[name])
    named["parameters"] |= {"gain": np.full(CHAMBERS, 2.0)}
    assert pneu.batch_gradient(weights=1.0, **named)["parameters"].shape == (CHAMBERS, 7)


def test_it_is_what_sensitivities_say(rig):
    given = arguments(rig)
    _, sensitivities = pneu.simulate_batch(**given, sensitivities=True)
    found = pneu.batch_gradient(weights=WEIGHTS, **given)["parameters"]
    np.testing.assert_allclose(found, np.einsum("cr,crp->cp", WEIGHTS, sensitivities), rtol=1e-9, atol=1e-9)


def test_many_chambers_in_parts_are_the_same(rig):
    """More than fit into one part."""
    chambers, rows = 150, 2000
    random = np.random.default_rng(12)
    drive, weights = random.uniform(-0.5, 0.5, (chambers, rows)), random.uniform(-1.0, 1.0, (chambers, rows))
    given = {"model": "nonlinear", "parameters": TRUE_PARAMETERS[0], "interval_s": INTERVAL_S, "rig": rig}
    heard = []
    found = pneu.batch_gradient(weights=weights, drive=drive, progress=lambda *news: heard.append(news), **given)
    for chamber in (0, 99, 100, 149):
        alone = pneu.batch_gradient(weights=weights[chamber], drive=drive[chamber], **given)
        np.testing.assert_allclose(found["drive"][chamber], alone["drive"], rtol=1e-9, atol=1e-9)
    assert all(what == "differentiating" for _, _, what in heard)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"weights": np.nan}, "weights is NaN at row 0"),
        ({"weights": np.ones((2, ROWS))}, "weights has 2 chambers and .* has 5"),
        ({"weights": np.ones(3)}, "weights has 3 rows"),
        ({"weights": "all"}, "weights: expected an array of numbers"),
        ({"drive": np.full((CHAMBERS, ROWS), 1.5)}, "drive is 1.5 at row 0"),
        ({"interval_s": 0.0}, "interval_s"),
    ],
)
def test_what_is_refused(rig, change, message):
    with pytest.raises(DataError, match=message):
        pneu.batch_gradient(**arguments(rig) | {"weights": 1.0} | change)
