"""Limits on every way to the boards, and vents that hold until they are released."""

import time

import numpy as np
import pytest
from boards import ATMOSPHERE_COUNTS, Boards

from pneudrive_py import CommandError, DataError, FileError, PortError, PressureController

RIG = """
[limits]
max_kpa = 300.0
[boards.0.channels.3.limits]
max_kpa = 100.0
"""

#: kPa of a count, at most; commands are rounded to counts.
COUNT_KPA = 0.842


def until(condition, patience_s=60.0):
    deadline = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.01)


def last_command(poller, board=0):
    commands = poller.history()["commands_kpa"]
    return commands[-1, board] if len(commands) else np.zeros(4)


@pytest.mark.parametrize("polled", [False, True], ids=["by hand", "polled"])
def test_a_set_point_above_the_limit_is_refused(polled, tmp_path):
    rig = tmp_path / "rig.toml"
    rig.write_text(RIG)
    with Boards() as boards, PressureController(boards.port, 1, timeout=0.2, max_kpa=150.0, rig=rig) as controller:
        ways = [controller.poll(rate_hz=100).set_pressure_commands] if polled else [
            controller.set_pressure_commands,
            lambda board, kpa: controller.exchange_all([kpa]),
        ]
        for command in ways:
            command(0, [150.0, 0.0, 0.0, 100.0])
            with pytest.raises(ValueError, match="151.0 kPa for channel 1 of board 0 is above its limit of 150 kPa.*nothing was sent"):
                command(0, [0.0, 151.0, 0.0, 0.0])
            with pytest.raises(CommandError, match="120.0 kPa for channel 3 of board 0 is above its limit of 100 kPa"):
                command(0, [0.0, 0.0, 0.0, 120.0])
    assert max(max(values) for _, values in boards.commands) <= ATMOSPHERE_COUNTS + 150.0 / 0.8416


def test_a_poller_ramps_what_is_faster_than_allowed():
    with PressureController("sim", 1, timing="instant", timeout=2.0, max_rate_kpa_s=100.0) as controller:
        with controller.poll(rate_hz=200) as poller:
            poller.set_pressure_commands(0, [100.0] * 4)
            until(lambda: last_command(poller).min() > 99.0)
            history = poller.history()
    times, sent = history["t_s"], history["commands_kpa"][:, 0, 0]
    # Whatever the machine's load: a cycle's command goes out between its start, which is its time,
    # and the start of the next.
    ahead_of_start, ahead_of_next = sent[:-1] - 100.0 * times[:-1], sent[:-1] - 100.0 * times[1:]
    assert np.all(ahead_of_next <= np.minimum.accumulate(ahead_of_start) + COUNT_KPA)
    assert sent[-1] - sent[0] > 95.0, "the ramp is in it"


def test_by_hand_a_change_that_is_too_fast_is_refused():
    with Boards(count=2) as boards:
        with PressureController(boards.port, 2, timeout=0.2, max_rate_kpa_s=100.0) as controller:
            with pytest.raises(CommandError, match="board 0, channel 0: from 0 to 50 kPa at once is faster than its limit of 100 kPa/s"):
                controller.set_pressure_commands(0, [50.0, 0.0, 0.0, 0.0])
            with pytest.raises(CommandError, match="board 1, channel 2"):
                controller.exchange_all([[1.0] * 4, [0.0, 0.0, 50.0, 0.0]])
            assert not boards.were_under_pressure(), "nothing was sent"
            for kpa in np.arange(1.0, 20.0, 1.0):
                controller.set_pressure_commands(0, [kpa] * 4)
                time.sleep(0.011)
            assert boards.were_under_pressure()
            with pytest.raises(CommandError, match="faster"):
                controller.set_pressure_commands(0, [5.0] * 4)
            # Venting is not slowed down.
            controller.set_pressure_commands(0, [0.0] * 4)
            controller.ping_devices()


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"max_kpa": -1.0}, CommandError, "a highest pressure of -1 kPa"),
        ({"max_kpa": float("nan")}, CommandError, "a highest pressure of NaN kPa"),
        ({"max_rate_kpa_s": 0.0}, CommandError, "a fastest change of 0 kPa/s"),
        ({"rig": "/nowhere/rig.toml"}, FileError, "/nowhere/rig.toml"),
    ],
)
def test_limits_that_make_no_sense(arguments, error, message):
    with pytest.raises(error, match=message):
        PressureController("sim", 1, **arguments)


def test_a_misspelt_limit_does_not_limit_nothing(tmp_path):
    rig = tmp_path / "rig.toml"
    rig.write_text("[limits]\nmax_pka = 100\n")
    with pytest.raises(DataError, match="rig.toml:2: unknown key limits.max_pka; did you mean max_kpa"):
        PressureController("sim", 1, rig=rig)


def test_vent_and_release():
    with Boards() as boards, PressureController(boards.port, 1, timeout=0.2) as controller:
        poller = controller.poll(rate_hz=200)
        assert poller.vented is False
        poller.release()  # nothing to release
        poller.set_pressure_commands(0, [100.0] * 4)
        until(lambda: boards.were_under_pressure() and not boards.is_vented())
        poller.vent()
        assert poller.vented is True and "vented until released" in repr(poller)
        until(boards.is_vented)
        with pytest.raises(CommandError, match=r"all boards are vented .*: call release\(\) first"):
            poller.set_pressure_commands(0, [50.0] * 4)
        poller.release()
        before = len(boards.commands)
        until(lambda: len(boards.commands) > before + 20)
        assert boards.is_vented(), "what was commanded before does not return"
        poller.set_pressure_commands(0, [20.0] * 4)
        until(lambda: not boards.is_vented())
        poller.stop()
        with pytest.raises(PortError, match="this poller has ended: it was stopped"):
            poller.vent()




class Link:
    """Virtual boards behind a name that stays, which can be unplugged and come back."""

    def __init__(self, path):
        self.path = path
        self.boards = None
        self.plug()

    def plug(self):
        self.boards = Boards()
        self.path.unlink(missing_ok=True)
        self.path.symlink_to(self.boards.port)

    def unplug(self):
        self.path.unlink()
        self.boards.__exit__()


@pytest.mark.parametrize("resume", [False, True])
def test_after_a_port_came_back(resume, tmp_path):
    link = Link(tmp_path / "bus")
    try:
        with PressureController(link.path, 1, timeout=0.2, resume=resume) as controller:
            poller = controller.poll(rate_hz=100)
            poller.set_pressure_commands(0, [100.0] * 4)
            until(link.boards.were_under_pressure)
            link.unplug()
            time.sleep(0.3)
            link.plug()
            until(lambda: len(link.boards.commands) > 100)
            if not resume:
                assert poller.vented and not link.boards.were_under_pressure()
                poller.release()
                poller.set_pressure_commands(0, [30.0] * 4)
            until(link.boards.were_under_pressure)
            assert not poller.vented
    finally:
        link.boards.__exit__()


def test_a_rig_file_says_port_boards_and_calibration(tmp_path):
    rig = tmp_path / "rig.toml"
    with Boards() as boards:
        bus = f'[bus]\nport = "{boards.port}"\nboards = 1\n'
        rig.write_text(bus + "[boards.0.channels.2.sensor]\nzero_counts = 110.0\nkpa_per_count = 0.9\n")
        with PressureController(rig=rig, timeout=0.2) as controller:
            assert controller.num_devices == 1
            controller.ping_devices()
    with pytest.raises(CommandError, match="no uart_port is given, and none by"):
        PressureController()
    rig.write_text("[bus]\nboards = 1\n[boards.1.limits]\nmax_kpa = 50\n")
    with pytest.raises(DataError, match=r"\[boards.1\] has limits, but \[bus\] boards = 1 means board 0 alone"):
        PressureController("sim", rig=rig)
    with pytest.warns(UserWarning, match=r"\[boards.1\] has limits, but num_devices = 1 means board 0 alone"):
        PressureController("sim", 1, rig=rig).close()
    rig.write_text("[sensor]\nbits = 12\nzero_counts = 409.6\nkpa_per_count = 0.21\n")
    with pytest.raises(DataError, match="rig.toml:2: sensor.bits = 12: expected 10"):
        PressureController("sim", 1, rig=rig)
