"""Results can be copied, pickled and drawn; residuals say when and in which part, and have one sign."""

import copy
import pickle

import numpy as np
import pytest

import pneudrive_py as pneu


@pytest.fixture(scope="module")
def simulation(recording, fit):
    return pneu.simulate(recording, fit.parameters)


@pytest.fixture(scope="module")
def comparison(recording, rig):
    return pneu.compare(recording, rig, models=["linear", "nonlinear"], starts=1)


@pytest.fixture(scope="module")
def diagnosis(recording, rig):
    return pneu.diagnose(recording, rig)


@pytest.fixture(params=["rig", "recording", "fit", "parameters", "simulation", "comparison", "diagnosis", "extended_model"])
def result(request):
    if request.param == "parameters":
        return request.getfixturevalue("fit").parameters
    if request.param == "extended_model":
        return request.getfixturevalue("diagnosis").extended_model
    return request.getfixturevalue(request.param)


def test_results_are_pickled_and_copied(result):
    for again in (pickle.loads(pickle.dumps(result)), copy.copy(result), copy.deepcopy(result)):
        assert type(again) is type(result)
        assert repr(again) == repr(result)
        assert again._repr_html_() == result._repr_html_()


def test_a_pickled_recording_is_the_same(recording):
    again = pickle.loads(pickle.dumps(recording))
    assert again.quality == recording.quality
    for name, column in recording.items():
        np.testing.assert_array_equal(again[name], column)


def test_a_pickled_fit_simulates_as_before(recording, fit, simulation):
    again = pickle.loads(pickle.dumps(fit))
    np.testing.assert_array_equal(pneu.simulate(recording, again.parameters).pressure_kpa, simulation.pressure_kpa)
    assert again.to_dict() == fit.to_dict()


def test_foreign_bytes_are_refused():
    with pytest.raises(pneu.DataError, match="not a pickle"):
        pneu.Fit._unpickle(b"nothing")


def test_residuals_are_measured_minus_simulated(recording, fit, simulation, comparison, diagnosis):
    one = simulation.residuals("b0c1")
    np.testing.assert_allclose(one["residual_kpa"], one["measured_kpa"] - one["simulated_kpa"])
    np.testing.assert_array_equal(one["t_s"], recording.time_s[recording.usable("b0c1")])
    of_fit = fit.residuals("b0c1")
    np.testing.assert_array_equal(of_fit["residual_kpa"], one["residual_kpa"])
    held_out = of_fit["t_s"][of_fit["role"] == "held out"]
    assert set(of_fit["role"]) == {"fit", "held out"} and held_out.min() > of_fit["t_s"][of_fit["role"] == "fit"].max()
    judged = comparison.residuals("b0c0", "nonlinear")
    np.testing.assert_allclose(judged["residual_kpa"], judged["measured_kpa"] - judged["simulated_kpa"])
    found = diagnosis.residuals("b0c0")
    assert set(found["role"]) == {"fit", "select", "test"}
    assert len(found["t_s"]) == len(found["base"]) == len(found["extended"]) == len(found["measured_kpa"])


@pytest.mark.parametrize("what", ["recording", "fit", "simulation", "comparison", "diagnosis"])
def test_plots(what, request, tmp_path):
    pytest.importorskip("matplotlib").use("Agg")
    figure = request.getfixturevalue(what).plot()
    labels = [axis.get_ylabel() for axis in figure.axes]
    assert any(label.startswith("measured - ") for label in labels), labels
    assert all(axis.lines for axis in figure.axes)
    figure.savefig(tmp_path / "figure.pdf")


def test_a_plot_of_a_channel_that_is_not_there(recording):
    pytest.importorskip("matplotlib").use("Agg")
    with pytest.raises(ValueError, match="no channel b0c7; there is b0c0, b0c1"):
        recording.plot("b0c7")


def test_units_are_not_ones(fit, diagnosis):
    assert "<td" in fit._repr_html_() and ">1</td>" not in fit.parameters._repr_html_()
    assert "] 1" not in repr(diagnosis)


@pytest.mark.parametrize("what", ["fit", "simulation", "comparison", "diagnosis"])
def test_displays_have_plots_with_units(what, request):
    shown = request.getfixturevalue(what)._repr_html_()
    assert shown.count("<figure>") == 2 and "<svg" in shown
    for axis in ("time, s", "pressure, kPa gauge", "measured - simulated, kPa"):
        assert axis in shown
    assert "The first of 2 channels" in shown
    assert ("fitted" in shown) if what == "fit" else ("test blocks" in shown) == (what == "diagnosis")


def test_what_cannot_be_drawn_is_said(fit, recording):
    columns = {name: recording[name] for name in ("t_s", "b0_u0")} | {"b0_p0_kpa": np.full(len(recording), np.nan)}
    shown = pneu.simulate(pneu.Recording.from_columns(columns), fit.parameters)._repr_html_()
    assert "<table" in shown and "<svg" not in shown
    assert "not drawn" in shown and "nothing to draw" in shown
