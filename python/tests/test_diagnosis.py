"""Diagnosis from Python: of one recording or several, and what it suggests next."""

from pathlib import Path

import numpy as np
import pytest

import pneudrive_py as pneu
from pneudrive_py import DataError

DATA = Path(__file__).parent.parent / "notebooks" / "data"


@pytest.fixture(scope="module")
def halves():
    """A recording of valves with play, in two."""
    whole = pneu.load(DATA / "hysteresis.csv.gz", DATA / "rig.toml").to_dict()
    cut = len(whole["t_s"]) // 2
    parts = {"first": slice(None, cut), "second": slice(cut, None)}
    return [
        pneu.Recording.from_columns({k: v[rows] for k, v in whole.items()}, rig=DATA / "rig.toml", name=name)
        for name, rows in parts.items()
    ]


@pytest.fixture(scope="module")
def diagnosis(halves):
    told = []
    result = pneu.diagnose(
        halves, DATA / "rig.toml", highest_kpa=123.0, progress=lambda *step: told.append(step)
    )
    assert told and told[-1][2]
    return result


def test_recordings_are_diagnosed_together(diagnosis, halves):
    assert diagnosis.report_dict["data"]["file"] == "first, second"
    assert "valve_hysteresis" in [cause["effect"] for cause in diagnosis.causes]
    assert diagnosis.verdict in ("explained", "partly_explained")
    assert "valve_hysteresis" in repr(diagnosis) and "<table" in diagnosis._repr_html_()
    # What else it could be, with probabilities.
    assert diagnosis.alternatives and 0.0 < diagnosis.causes[0]["probability"] <= 1.0
    for shown in (repr(diagnosis), diagnosis._repr_html_()):
        assert "probability" in shown and f"{diagnosis.alternatives[0]['probability']:.3f}" in shown
    residuals = diagnosis.residuals("b0c0")
    # Rows of both.
    assert len(residuals["base"]) > 0.6 * sum(map(len, halves))
    assert np.std(residuals["extended"]) < 0.5 * np.std(residuals["base"])


def test_its_extended_model_simulates_what_it_explains(diagnosis, halves, tmp_path):
    model = diagnosis.extended_model
    assert model.effects("b0c0")["valve_hysteresis"]["half_width"] == pytest.approx(0.06, rel=0.3)
    base = diagnosis.report_dict["baseline"]["test_rmse_kpa"]
    score = pneu.simulate(halves[1], model).scores["b0c0"]
    assert score["rmse_kpa"] < 0.7 * base
    # The same through the folder that is saved.
    diagnosis.save(tmp_path)
    saved = pneu.ExtendedModel.load(tmp_path / "extended.toml")
    assert saved.to_dict()["channels"] == model.to_dict()["channels"]


@pytest.mark.parametrize("highest_kpa", [0.0, -5.0, float("nan"), float("inf")])
def test_a_highest_pressure_that_is_none(halves, highest_kpa):
    with pytest.raises(DataError, match="above 0 kPa"):
        pneu.diagnose(halves, DATA / "rig.toml", highest_kpa=highest_kpa)


def test_only_what_is_asked_about_is_named(halves):
    asked = pneu.diagnose(halves, DATA / "rig.toml", only=["valve_hysteresis", "supply_sag"])
    assert asked.report_dict["asked"] == ["valve_hysteresis", "supply_sag"]
    assert [cause["effect"] for cause in asked.causes] == ["valve_hysteresis"]
    assert "was asked about" in asked.report_dict["sentence"]
    with pytest.raises(DataError, match="no effect is called valve_hysterisis; there are drive_saturation, "):
        pneu.diagnose(halves, DATA / "rig.toml", only=["valve_hysterisis"])


def test_recordings_that_do_not_belong_together(halves, recording):
    with pytest.raises(DataError, match="nothing to diagnose"):
        pneu.diagnose([])
    one = pneu.Recording.from_columns(halves[1].to_dict(), channels=["b0c0"], name="one")
    with pytest.raises(DataError, match="first has the channels b0c0, b0c1 and one has b0c0"):
        pneu.diagnose([halves[0], one], DATA / "rig.toml")
    with pytest.raises(TypeError):
        pneu.diagnose([halves[0], "run.csv"], DATA / "rig.toml")
