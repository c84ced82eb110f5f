"""The extended model of a diagnosis, simulated, saved and read again."""

import numpy as np
import pytest

import pneudrive_py as pneu
from pneudrive_py import DataError, FileError


@pytest.fixture(scope="module")
def plain(fit, tmp_path_factory):
    """What was fitted, as a model without effects."""
    path = tmp_path_factory.mktemp("fit") / "nonlinear.toml"
    fit.save(path)
    return pneu.ExtendedModel.load(path)


@pytest.fixture(scope="module")
def with_play(plain, tmp_path_factory):
    """The same, but the spool of channel 0 has play."""
    path = tmp_path_factory.mktemp("extended") / "extended.toml"
    before = "[channels.b0c0.parameters]"
    assert plain.to_toml().count(before) == 1
    path.write_text(plain.to_toml().replace(before, f"[channels.b0c0.effects.valve_hysteresis]\nhalf_width = 0.1\n{before}"))
    return pneu.ExtendedModel.load(path)


def test_without_effects_it_is_the_fitted_model(plain, fit, recording):
    assert plain.channels == fit.channels and plain.model == "nonlinear"
    assert plain.rig == fit.parameters.rig
    assert plain.values("b0c0") == fit.parameters.values("b0c0")
    assert plain.effects("b0c0") == {}
    fitted = pneu.simulate(recording, fit.parameters)
    extended = pneu.simulate(recording, plain)
    assert extended.channels == fitted.channels
    # The one steps as finely as the fit chose, the other as a diagnosis does.
    np.testing.assert_allclose(extended.pressure_kpa, fitted.pressure_kpa, atol=0.5)
    for channel in fitted.channels:
        for measure in ("rmse_kpa", "samples"):
            assert extended.scores[channel][measure] == pytest.approx(fitted.scores[channel][measure], rel=0.02)


def test_an_effect_acts_on_its_channel_alone(plain, with_play, recording):
    assert with_play.effects("b0c0") == {"valve_hysteresis": {"half_width": 0.1}}
    assert with_play.effects("b0c1") == {}
    without, play = (pneu.simulate(recording, model) for model in (plain, with_play))
    difference = np.abs(play.pressure_kpa - without.pressure_kpa).max(axis=0)
    assert difference[0] > 5.0
    assert difference[1] == 0.0
    assert play.scores["b0c0"]["rmse_kpa"] > 2.0 * without.scores["b0c0"]["rmse_kpa"]
    assert "nonlinear model with valve_hysteresis" in repr(play) and "with" not in repr(without)
    assert "b0c0 with valve_hysteresis; b0c1" in repr(with_play)
    assert "<table" in with_play._repr_html_() and "half_width" in with_play._repr_html_()


def test_it_goes_through_a_file(with_play, recording, tmp_path):
    path = tmp_path / "extended.toml"
    with_play.save(path)
    again = pneu.ExtendedModel.load(path)
    assert again.to_dict() == with_play.to_dict()
    np.testing.assert_array_equal(
        pneu.simulate(recording, again).pressure_kpa, pneu.simulate(recording, with_play).pressure_kpa
    )


def test_a_start_that_was_not_measured(plain, columns, rig):
    drives = {name: values for name, values in columns.items() if name in ("t_s", "b0_u0", "b0_u1")}
    recording = pneu.Recording.from_columns(drives, rig=rig)
    simulation = pneu.simulate(recording, plain, start_kpa=70.0)
    np.testing.assert_allclose(simulation.pressure_kpa[0], 70.0, atol=0.5)
    assert simulation.scores == {"b0c0": None, "b0c1": None}


def test_what_cannot_be_used(plain, recording, columns, tmp_path):
    with pytest.raises(FileError, match="no-such-file.toml"):
        pneu.ExtendedModel.load(tmp_path / "no-such-file.toml")
    other = tmp_path / "other.toml"
    other.write_text('schema = "something-else/1"')
    with pytest.raises(DataError, match="something-else/1"):
        pneu.ExtendedModel.load(other)
    with pytest.raises(DataError, match="b3c3"):
        plain.values("b3c3")
    elsewhere = {name.replace("b0_", "b5_"): values for name, values in columns.items()}
    with pytest.raises(DataError, match="b5c0"):
        pneu.simulate(pneu.Recording.from_columns(elsewhere), plain)
    with pytest.raises(TypeError):
        pneu.simulate(recording, "extended.toml")


def test_the_band_of_a_diagnosis_is_simulated_with_it(plain, recording, tmp_path):
    """Half of its width is 2 kPa where the pressure rests, and of a fit there is none."""
    path = tmp_path / "banded.toml"
    path.write_text(plain.to_toml() + "\n[channels.b0c0.band]\nrest_kpa = 2.0\ntiming_s = 0.0\n")
    simulation = pneu.simulate(recording, pneu.ExtendedModel.load(path))
    band_kpa, kpa = simulation.band_kpa, simulation.pressure_kpa
    assert band_kpa.shape == (*kpa.shape, 2)
    np.testing.assert_allclose(kpa[:, 0] - band_kpa[:, 0, 0], 2.0)
    np.testing.assert_allclose(band_kpa[:, 0, 1] - kpa[:, 0], 2.0)
    assert np.isnan(band_kpa[:, 1]).all()
    one = simulation.residuals("b0c0")
    assert simulation.band_holds == {"b0c0": pytest.approx(np.mean(np.abs(one["residual_kpa"]) <= 2.0)), "b0c1": None}
    assert np.isnan(pneu.simulate(recording, plain).band_kpa).all()
    pytest.importorskip("matplotlib").use("Agg")
    drawn = [[filled.get_label() for filled in axis.collections] for axis in simulation.plot().axes]
    assert drawn[0] == ["95 % band"] and drawn[1] == []
