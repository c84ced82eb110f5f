"""Recordings as tables: mapping protocol, stretches of time, other rates, pandas, xarray."""

import sys

import numpy as np
import pytest

import pneudrive_py as pneu


@pytest.fixture(scope="module")
def whole():
    """10 s at 100 Hz; the pressure of row 250 is missing, and 5 to 6 s are."""
    time = np.concatenate([np.arange(0, 5, 0.01), np.arange(6, 10, 0.01)])
    pressure = 10.0 * time
    pressure[250] = np.nan
    return pneu.Recording.from_columns({"t_s": time, "b0_cmd0_kpa": np.where(time < 2, 0.0, 50.0), "b0_p0_kpa": pressure})


def test_it_is_a_table_of_named_columns(whole):
    assert list(whole) == whole.columns == whole.keys() == ["t_s", "b0_cmd0_kpa", "b0_p0_kpa"]
    assert "b0_p0_kpa" in whole and "b0_p1_kpa" not in whole and 3 not in whole
    assert whole.get("b0_p1_kpa") is None and whole.get("b0_p1_kpa", 7) == 7
    np.testing.assert_array_equal(whole.get("t_s"), whole.time_s)
    assert len(whole) == len(whole.time_s) == len(whole.values()[0])
    assert [name for name, _ in whole.items()] == whole.columns
    assert dict(whole).keys() == set(whole.columns)
    with pytest.raises(KeyError, match="b0_p1_kpa"):
        whole["b0_p1_kpa"]


def test_a_stretch_of_time_keeps_times_and_masks(whole):
    part = whole.between(2.0, 3.0)
    assert part.time_s[0] == 2.0 and part.time_s[-1] < 3.0 and len(part) == 100
    assert not part.usable("b0c0")[50] and part.usable("b0c0").sum() == 99
    assert len(whole.between()) == len(whole)
    with pytest.raises(pneu.DataError, match="1 row"):
        whole.between(2.0, 2.005)


def test_another_rate_interpolates_pressures_and_holds_commands(whole):
    fine = whole.resample(200.0)
    # Both sides of the missing second.
    assert len(fine) == 999 + 799
    row = np.searchsorted(fine.time_s, 1.0049)
    assert fine["b0_p0_kpa"][row] == pytest.approx(10.05, abs=1e-4)
    assert set(fine["b0_cmd0_kpa"]) == {0.0, 50.0}
    with pytest.raises(pneu.DataError, match="0 Hz"):
        whole.resample(0.0)


@pytest.mark.parametrize("package, method", [("pandas", "to_dataframe"), ("xarray", "to_xarray"), ("matplotlib", "plot")])
def test_a_package_that_is_missing_is_named_with_how_to_get_it(whole, monkeypatch, package, method):
    for name in (package, f"{package}.pyplot"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ModuleNotFoundError, match=f"^this needs {package}: pip install {package}$"):
        getattr(whole, method)()


def test_pandas(whole):
    frame = whole.to_dataframe()
    assert frame.index.name == "t_s" and list(frame.columns) == whole.columns[1:]
    assert frame.loc[1.0:1.5, "b0_p0_kpa"].is_monotonic_increasing
    again = pneu.Recording.from_columns(frame.reset_index())
    np.testing.assert_array_equal(again["b0_p0_kpa"], whole["b0_p0_kpa"])


def test_xarray(recording):
    pytest.importorskip("xarray")
    data = recording.to_xarray()
    assert data["pressure"].dims == ("t_s", "channel") and data["pressure"].attrs["units"] == "kPa"
    assert list(data["channel"].values) == ["b0c0", "b0c1"]
    np.testing.assert_array_equal(data["drive"].sel(channel="b0c1"), recording["b0_u1"])
    np.testing.assert_array_equal(data["usable"].sel(channel="b0c0"), recording.usable("b0c0"))


def test_the_page_of_a_recording(whole):
    page = whole.html()
    assert "<h1>Recording columns</h1>" in page and "measured - set point" in page
    assert "<svg" in whole._repr_html_()


def test_a_loss_of_several_channels_is_said_once():
    time = np.arange(0, 1, 0.01)
    columns = {"t_s": time}
    for channel in range(4):
        columns[f"b0_p{channel}_kpa"] = np.where(np.arange(100) == 40, np.nan, 10.0 * time + channel)
    said = [sentence for sentence in pneu.Recording.from_columns(columns).quality if "empty" in sentence]
    assert len(said) == 1
    assert said[0].startswith("b0_p0_kpa, b0_p1_kpa, b0_p2_kpa, b0_p3_kpa: 1 cell")
