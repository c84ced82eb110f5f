"""Sensors on the I2C connectors of virtual boards, and the line rate, from Python."""

import time

import numpy as np
import pytest
from test_bus import PATIENCE

import pneudrive_py as pneu
from pneudrive_py import CommandError, PressureController


def until(what, condition, patience_s=60.0):
    """Waits for it, however busy the machine is."""
    deadline = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < deadline, f"{what} did not come"
        time.sleep(0.01)


def test_a_poller_has_supply_and_imu_and_so_has_its_history():
    with PressureController("sim", 2, timing="instant", timeout=PATIENCE, sensors=0.5) as controller:
        controller.ping_devices()
        with controller.poll(rate_hz=200) as poller:
            until("both", lambda: all(np.isfinite(value).all() for value in poller.get_sensors().values()))
            sensors = poller.get_sensors()
            time.sleep(0.5)
            history = poller.history()
    assert sensors["supply_kpa"].shape == (2,)
    np.testing.assert_allclose(sensors["supply_kpa"], 550.0, atol=3.0)
    # At rest and upright.
    np.testing.assert_allclose(sensors["acceleration_m_s2"], [[0.0, 0.0, 9.807]] * 2, atol=0.1)
    np.testing.assert_allclose(sensors["angular_rate_rad_s"], np.zeros((2, 3)), atol=0.02)
    rows = len(history["t_s"])
    np.testing.assert_allclose(sensors["chip_c"], 27.2)
    np.testing.assert_allclose(sensors["rail_v"], 5.0)
    for name, value in (("chip_c", 27.2), ("rail_v", 5.0)):
        told = history[name][np.isfinite(history[name])]
        assert history[name].shape == (rows, 2) and 0 < len(told) < rows and (told == value).all()
    assert history["supply_kpa"].shape == (rows, 2)
    assert history["acceleration_m_s2"].shape == history["angular_rate_rad_s"].shape == (rows, 2, 3)
    read = np.isfinite(history["supply_kpa"][:, 1])
    assert 0 < read.sum() < rows, "in the cycles in which it was read"
    recording = pneu.Recording.from_history(history)
    assert "b1_supply_kpa" in recording.columns
    np.testing.assert_allclose(recording["b1_supply_kpa"][read], history["supply_kpa"][read, 1], rtol=1e-6)
    assert np.isfinite(recording["b1_supply_kpa"]).all(), "a straight line in between"


def test_who_does_not_ask_gets_none():
    with PressureController("sim", 1, timing="instant", timeout=PATIENCE) as controller:
        controller.ping_devices()
        with controller.poll(rate_hz=200) as poller:
            poller.wait()
            assert np.isnan(poller.get_sensors()["supply_kpa"]).all()
            assert "supply_kpa" not in poller.history()


@pytest.mark.parametrize("sensors", [0.0, -1.0, 1.5, float("nan")])
def test_a_share_that_is_none_is_refused(sensors):
    with pytest.raises(CommandError, match="sensors is .*; it must be above 0 and at most 1"):
        PressureController("sim", 1, sensors=sensors)


def test_a_line_rate_is_a_number_or_auto(tmp_path):
    with pytest.raises(CommandError, match='baud is "fast"; it must be a whole number of bit/s, or "auto"'):
        PressureController("sim", 1, baud="fast")
    rig = tmp_path / "rig.toml"
    rig.write_text('[bus]\nport = "sim"\nboards = 1\nbaud = "auto"\n')
    for arguments in ({"baud": "auto", "uart_port": "sim", "num_devices": 1}, {"rig": rig}):
        with PressureController(**arguments, timeout=PATIENCE) as controller:
            controller.ping_devices()
            with controller.poll(rate_hz=200) as poller:
                until("3 Mbaud", lambda: (poller.statistics() or {}).get("baud") == 3_000_000)
            # By hand it is 1 Mbaud again.
            controller.exchange_all(0.0)
