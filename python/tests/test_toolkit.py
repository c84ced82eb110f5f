"""The modelling toolkit from Python: what goes in comes out, with the shapes and units that are documented."""

import json
import pickle
import signal
import threading
import time

import numpy as np
import pandas
import pytest
from conftest import TRUE_PARAMETERS
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import pneudrive_py as pneu
from pneudrive_py import DataError, FileError


def test_columns_come_back_as_they_went_in(recording, columns):
    assert recording.channels == ["b0c0", "b0c1"]
    assert len(recording) == 1000
    assert recording.rate_hz == pytest.approx(50.0)
    assert recording.duration_s == pytest.approx(19.98)
    assert set(recording.columns) == set(columns)
    for name, values in columns.items():
        # Single precision, except for time.
        np.testing.assert_allclose(recording[name], values, rtol=1e-6, atol=1e-6)
    assert recording.usable("b0c0").dtype == np.bool_
    assert recording.usable("b0c0").shape == (1000,)
    assert "b0c0" in repr(recording) and "<table" in recording._repr_html_()
    with pytest.raises(KeyError, match="b0_p7_kpa"):
        recording["b0_p7_kpa"]


@pytest.mark.parametrize("ending", ["csv", "csv.gz", "csv.zst"])
def test_a_saved_recording_loads_again(recording, tmp_path, rig_file, ending):
    path = tmp_path / f"run.{ending}"
    recording.save(path)
    again = pneu.load(path, rig_file)
    assert again.file == str(path)
    for name in recording.columns:
        np.testing.assert_allclose(again[name], recording[name], rtol=1e-6, atol=1e-6)
    only = pneu.load(path, channels=["b0c1"])
    assert only.channels == ["b0c1"]
    assert pneu.Recording.from_columns(recording.to_dict(), channels=["b0c0"]).channels == ["b0c0"]


def test_a_bag_loads(tmp_path):
    """As the ROS node and `pneudrive-host --record run.mcap` write them."""
    store = get_typestore(Stores.ROS2_JAZZY)
    types = store.types
    kind = "sensor_msgs/msg/JointState"
    names = [f"b2_p{k}_kpa" for k in range(4)] + [f"b2_cmd{k}_kpa" for k in range(4)]
    rows, nothing = 300, np.zeros(0)
    pressures = 50.0 + np.arange(4) + 20.0 * np.sin(0.1 * np.arange(rows))[:, None]
    with Writer(tmp_path / "bag", version=8, storage_plugin=StoragePlugin.MCAP) as writer:
        topic = writer.add_connection("/pneudrive/joint_2/pressure_state", kind, typestore=store)
        for row in range(rows):
            stamp_ns = 1_763_742_822_000_000_000 + 10_000_000 * row
            time = types["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
            header = types["std_msgs/msg/Header"](stamp=time, frame_id="bus0")
            effort = np.concatenate([pressures[row], [10.0, 20.0, 30.0, 40.0]])
            message = types[kind](header=header, name=names, position=nothing, velocity=nothing, effort=effort)
            writer.write(topic, stamp_ns, store.serialize_cdr(message, kind))
    path = tmp_path / "bag" / "bag.mcap"
    recording = pneu.load(path)
    assert recording.channels == ["b2c0", "b2c1", "b2c2", "b2c3"] and len(recording) == rows
    assert recording.rate_hz == pytest.approx(100.0)
    np.testing.assert_allclose(recording["b2_p3_kpa"], pressures[:, 3], rtol=1e-6)
    np.testing.assert_array_equal(recording["b2_cmd1_kpa"], np.full(rows, 20.0))
    assert pneu.load(path, channels=["b2c1"]).channels == ["b2c1"]
    killed = tmp_path / "killed.mcap"
    killed.write_bytes(path.read_bytes()[:-2000])
    assert any("end of the file is missing" in sentence for sentence in pneu.load(killed).quality)
    killed.write_bytes(path.read_bytes()[:8])
    with pytest.raises(DataError, match="killed.mcap"):
        pneu.load(killed)


def test_missing_values_are_masked_and_named(columns):
    broken = {name: values.copy() for name, values in columns.items()}
    broken["b0_p0_kpa"][100:110] = np.nan
    recording = pneu.Recording.from_columns(broken)
    usable = recording.usable("b0c0")
    assert not usable[100:110].any() and usable[:100].all()
    assert any("b0_p0_kpa" in sentence for sentence in recording.quality)


def test_a_pandas_data_frame_does_as_well(columns):
    frame = pandas.DataFrame(columns)
    recording = pneu.Recording.from_columns(frame)
    assert pandas.DataFrame(recording.to_dict()).shape == frame.shape


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({}, "empty"),
        ({"t_s": [0.0, 1.0]}, "channel"),
        ({"b0_p0_kpa": [0.0, 1.0]}, "t_s"),
        ({"t_s": [0.0, 1.0, 2.0], "b0_p0_kpa": [0.0, 1.0]}, "2 values and t_s has 3"),
        ({"t_s": [0.0, 1.0], "b0_u0": [0.0, 200.0]}, "b0_u0"),
        ({"t_s": [0.0, 1.0], "b0_p0_kpa": [[0.0], [1.0]]}, r"shape \(rows,\)"),
        ({"t_s": [0.0, 1.0], "b0_p0_kpa": ["a", "b"]}, r"shape \(rows,\)"),
        ({"t_s": [0.0, 1.0], "b0_p0_kpa,": [0.0, 1.0]}, "no column name"),
        ([1, 2, 3], "mapping"),
        (None, "mapping"),
    ],
)
def test_columns_that_cannot_be_a_recording(columns, message):
    with pytest.raises(DataError, match=message):
        pneu.Recording.from_columns(columns)


def test_files_that_cannot_be_used(tmp_path):
    with pytest.raises(FileError, match="no-such-file.csv") as failure:
        pneu.load(tmp_path / "no-such-file.csv")
    assert isinstance(failure.value, OSError)
    garbage = tmp_path / "garbage.csv"
    garbage.write_text("a,b\n1,2\n")
    with pytest.raises(DataError, match="garbage.csv") as failure:
        pneu.load(garbage)
    assert isinstance(failure.value, ValueError)
    with pytest.raises(FileError):
        pneu.Rig.load(tmp_path / "no-such-rig.toml")
    with pytest.raises(DataError, match="suply"):
        pneu.Rig.parse("[suply]\npressure_kpa = 550.0")
    with pytest.raises(FileError):
        pneu.Parameters.load(tmp_path / "no-such-parameters.toml")


def test_a_rig_from_tables_is_the_rig_from_text(rig):
    same = pneu.Rig(**rig.to_dict())
    assert same == rig
    assert pickle.loads(pickle.dumps(rig)) == rig
    assert pneu.Rig() != rig
    assert "chamber" in repr(rig)
    with pytest.raises(DataError, match="pressure_kpa"):
        pneu.Rig(supply={"pressure_kpa": -5.0})
    with pytest.raises(DataError):
        pneu.Rig(supply=object())


def test_boards_and_channels_have_tables_of_their_own():
    own = {"0": {"channels": {"3": {"chamber": {"volume_m3": 3e-4}}}}}
    rig = pneu.Rig(chamber={"volume_m3": 1e-4}, boards=own)
    assert rig.at("b0c3").to_dict() == {"chamber": {"volume_m3": 3e-4}}
    assert rig.at("b1c3").to_dict() == {"chamber": {"volume_m3": 1e-4}}
    assert pneu.Rig(**rig.to_dict()) == rig
    assert pickle.loads(pickle.dumps(rig)) == rig
    with pytest.raises(DataError, match="unknown key boards.0.channels.3.chamber.volume; did you mean volume_m3"):
        pneu.Rig(boards={"0": {"channels": {"3": {"chamber": {"volume": 1e-4}}}}})
    with pytest.raises(DataError, match="channel"):
        rig.at("elbow")


def test_a_fit_finds_what_made_the_recording(fit):
    assert fit.channels == ["b0c0", "b0c1"]
    for channel, truth in zip(fit.channels, TRUE_PARAMETERS, strict=True):
        values = fit.parameters.values(channel)
        assert values["gain"] == pytest.approx(truth[2], rel=0.05)
        np.testing.assert_array_equal(fit.parameters.array(channel), list(values.values()))
        for part in (fit.fitted, fit.held_out):
            assert part[channel]["rmse_kpa"] == pytest.approx(0.3, abs=0.15)
        names, covariance = fit.covariance(channel)
        assert covariance.shape == (len(names), len(names))
        gain = names.index("gain")
        # Within four standard errors of the truth.
        assert abs(values["gain"] - truth[2]) < 4.0 * np.sqrt(covariance[gain, gain])
    assert "nonlinear" in repr(fit) and "gain" in fit._repr_html_()
    assert json.dumps(fit.to_dict())


def test_parameters_go_through_a_file(fit, recording, tmp_path):
    path = tmp_path / "nonlinear.toml"
    fit.save(path)
    loaded = pneu.Parameters.load(path)
    assert loaded.channels == fit.channels
    assert loaded.model("b0c1") == "nonlinear"
    assert loaded.rig == fit.parameters.rig
    np.testing.assert_array_equal(
        pneu.simulate(recording, loaded).pressure_kpa, pneu.simulate(recording, fit.parameters).pressure_kpa
    )
    with pytest.raises(DataError, match="b3c3"):
        loaded.values("b3c3")
    with pytest.raises(DataError, match="expected a channel"):
        loaded.values("nonsense")


def test_simulation(recording, fit):
    simulation = pneu.simulate(recording, fit.parameters)
    assert simulation.pressure_kpa.shape == (len(recording), 2)
    error = simulation.pressure_kpa[:, 0] - recording["b0_p0_kpa"]
    rmse = np.sqrt(np.mean(error[recording.usable("b0c0")] ** 2))
    assert rmse == pytest.approx(simulation.scores["b0c0"]["rmse_kpa"], rel=1e-3)
    assert rmse < 0.6
    as_recording = simulation.recording
    np.testing.assert_allclose(as_recording["b0_p1_kpa"], simulation.pressure_kpa[:, 1], rtol=1e-6)
    assert "nonlinear" in repr(simulation) and "<table" in simulation._repr_html_()


def test_comparison(recording, rig, tmp_path):
    comparison = pneu.compare(recording, rig, models=["linear", "nonlinear"], starts=2)
    assert comparison.ranking[0] == "nonlinear"
    table = comparison.table
    assert table["channel"] == ["b0c0", "b0c0", "b0c1", "b0c1"]
    assert table["model"] == ["linear", "nonlinear"] * 2
    assert table["rollout_rmse_kpa"][1] < table["rollout_rmse_kpa"][0]
    time_s, pressure_kpa = comparison.trace("b0c0", "nonlinear")
    assert time_s.shape == pressure_kpa.shape
    measured = recording["b0_p0_kpa"][-len(time_s) :]
    assert np.sqrt(np.nanmean((pressure_kpa - measured) ** 2)) < 1.0
    page = tmp_path / "compare.html"
    comparison.save(page)
    assert page.read_text().startswith("<!DOCTYPE html>")
    assert comparison.to_dict()["ranking"] == comparison.ranking
    with pytest.raises(DataError, match="parametric"):
        comparison.trace("b0c0", "parametric")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"model": "best"}, '"linear" or "nonlinear" or "parametric"'),
        ({"controller": "maybe"}, '"auto" or "on" or "off"'),
        ({"starts": 0}, "1 to 10000"),
        ({"fit_fraction": 1.5}, "between 0 and 1"),
        ({"fit_seconds": float("nan")}, "above 0 s"),
        ({"fit_seconds": 5.0, "fit_fraction": 0.5}, "not both"),
        ({"fit_seconds": 1e6}, "rows to fit"),
        ({"objective": "rate", "controller": "on"}, "rates"),
    ],
)
def test_arguments_that_cannot_be_used(recording, rig, arguments, message):
    with pytest.raises(DataError, match=message):
        pneu.fit(recording, rig, **arguments)


def test_without_a_rig_only_the_linear_model(recording):
    with pytest.raises(DataError, match="supply"):
        pneu.fit(recording, starts=1)
    assert pneu.fit(recording, model="linear", starts=1).channels == ["b0c0", "b0c1"]


def test_progress_is_told(recording, rig):
    told = []
    pneu.fit(recording, rig, starts=20, progress=lambda *step: told.append(step))
    assert told
    done, total, what = told[-1]
    assert 0 <= done <= total == 40
    assert "nonlinear" in what


def test_an_exception_in_progress_ends_the_work(recording, rig):
    def stop(*_):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        pneu.fit(recording, rig, starts=10_000, progress=stop)


@pytest.mark.parametrize(
    "work",
    [
        lambda recording, rig: pneu.fit(recording, rig, starts=10_000),
        lambda recording, rig: pneu.compare(recording, rig, starts=10_000),
        lambda recording, rig: pneu.simulate_batch(
            "nonlinear", TRUE_PARAMETERS[0], 0.01, drive=np.full((20_000, 1000), 0.1), rig=rig, substeps=1000
        ),
    ],
    ids=["fit", "compare", "simulate_batch"],
)
def test_ctrl_c_ends_long_work(recording, rig, work):
    """It would take minutes; SIGINT arrives after half a second."""
    # A job in the background of a shell starts with SIGINT ignored, and Python leaves it so.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    main = threading.main_thread()
    timer = threading.Timer(0.5, lambda: signal.pthread_kill(main.ident, signal.SIGINT))
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            work(recording, rig)
        timer.join()
    finally:
        signal.signal(signal.SIGINT, before)


def test_other_threads_run_during_long_work(recording, rig):
    ticks = []
    done = threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(1)
            time.sleep(0.002)

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        pneu.fit(recording, rig, starts=4)
    finally:
        done.set()
        thread.join()
    assert len(ticks) > 10


def test_the_catalogue_of_effects():
    effects = pneu.effects()
    assert "valve_hysteresis" in effects
    for entry in effects.values():
        assert entry["title"] and entry["physics"] and entry["parameters"]
