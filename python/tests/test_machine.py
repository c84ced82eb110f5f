"""Several recordings of one machine with different loads, and one of a machine that is known."""

import pickle

import numpy as np
import pytest
from conftest import RIG_TOML, TRUE_PARAMETERS

import pneudrive_py as pneu
from pneudrive_py import DataError

# One worker makes what these tests share, where several run.
pytestmark = pytest.mark.xdist_group("machine")

#: Volumes behind the valves, over that of the rig.
VOLUMES = {"large": 1.0, "small": 0.6, "larger": 1.4}


def load_of(volume, seed):
    """40 s at 50 Hz of the same valves with another volume behind them; drives held for 0.4 s, 0.3 kPa of noise."""
    # The volume is a circle's area times the length.
    rig = pneu.Rig.parse(RIG_TOML.replace("length_m = 0.2", f"length_m = {0.2 * volume}"))
    random = np.random.default_rng(seed)
    drive = np.repeat(random.uniform(-0.3, 0.3, 100), 20)
    kpa = pneu.simulate_batch("nonlinear", TRUE_PARAMETERS[0], 0.02, drive=drive, start_kpa=100.0, rig=rig)[0]
    noisy = kpa + random.normal(0.0, 0.3, kpa.shape)
    return {"t_s": 0.02 * np.arange(drive.size), "b0_u0": drive, "b0_p0_kpa": noisy}


@pytest.fixture(scope="module")
def recordings(rig):
    every = enumerate(VOLUMES.items())
    return [pneu.Recording.from_columns(load_of(volume, seed), rig=rig, name=name) for seed, (name, volume) in every]


@pytest.fixture(scope="module")
def machine(recordings, rig):
    return pneu.diagnose(recordings, rig, loads="differ")


def sizes(diagnosis, name):
    return [record["load"]["b0c0"][name]["value"] for record in diagnosis.machine["recordings"]]


def test_volumes_are_told_and_nothing_is_named(machine):
    assert machine.causes == [] and not machine.machine["known"]
    assert [record["file"] for record in machine.machine["recordings"]] == list(VOLUMES)
    np.testing.assert_allclose(sizes(machine, "chamber_volume.ratio"), list(VOLUMES.values()), rtol=0.03)
    likeliest = machine.alternatives[0]
    assert likeliest["probability"] == max(one["probability"] for one in machine.alternatives)
    assert machine.report_dict["alternatives"] == machine.alternatives
    assert "chamber_volume.ratio" in repr(machine) and "probability" in machine._repr_html_()


def test_every_recording_has_a_model_that_simulates_it(machine, recordings):
    models = machine.extended_models
    assert list(models) == [record["extended_model"] for record in machine.machine["recordings"]]
    for model, recording in zip(models.values(), recordings, strict=True):
        assert pneu.simulate(recording, model).scores["b0c0"]["rmse_kpa"] < 1.0
    # Another load's model does not.
    first, second = list(models.values())[:2]
    assert pneu.simulate(recordings[1], first).scores["b0c0"]["rmse_kpa"] > 3.0
    assert machine.extended_model.to_dict() == first.to_dict() != second.to_dict()
    with pytest.raises(DataError, match="extended_models"):
        machine.residuals("b0c0")


def test_a_known_machine_says_what_another_load_is(machine, rig):
    other = pneu.Recording.from_columns(load_of(0.8, 9), rig=rig, name="other")
    known = pneu.diagnose(other, rig, machine=machine.extended_model)
    assert known.machine["known"]
    np.testing.assert_allclose(sizes(known, "chamber_volume.ratio"), [0.8], rtol=0.03)


def test_it_is_saved_pickled_and_drawn(machine, tmp_path):
    pytest.importorskip("matplotlib").use("Agg")
    again = pickle.loads(pickle.dumps(machine))
    assert repr(again) == repr(machine) and again.machine == machine.machine
    machine.save(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"report.html", "report.json", *machine.extended_models}
    figure = machine.plot()
    assert [axis.get_xlabel() for axis in figure.axes][:1] == ["test error (kPa RMS)"]
    assert "chamber_volume.ratio" in [axis.get_xlabel() for axis in figure.axes]
    figure.savefig(tmp_path / "machine.png")


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"loads": "differ"}, 'loads="differ" needs several recordings'),
        ({"loads": "diffr"}, 'loads is "diffr"; it must be "auto", "same" or "differ"'),
        ({"machine": "m.toml", "loads": "same"}, "pass one"),
        ({"reference": "r.toml", "machine": "m.toml"}, "pass one"),
        ({"reference": "r.toml", "loads": "differ"}, "pass one"),
    ],
)
def test_arguments_that_contradict_each_other(recording, rig, arguments, message):
    with pytest.raises(DataError, match=message):
        pneu.diagnose(recording, rig, **arguments)


def test_recordings_with_one_load_are_one(recordings, rig):
    """Said, they are joined; unsaid, their loads are found to differ. One given twice is refused."""
    with pytest.raises(DataError, match="large is large once more"):
        pneu.diagnose([recordings[0], recordings[0]], rig, loads="same")
    again = pneu.Recording.from_columns(load_of(VOLUMES["large"], 9), rig=rig, name="again")
    same = pneu.diagnose([recordings[0], again], rig, loads="same")
    assert same.machine is None and list(same.extended_models) == ["extended.toml"]
    # A tenth is kept for what was not fitted.
    assert 0.85 < sum(one["probability"] for one in same.alternatives) <= 0.9 + 1e-9
    assert pneu.diagnose(recordings, rig).machine is not None
