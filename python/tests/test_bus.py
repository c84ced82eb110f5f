"""The bus, against virtual boards behind a real pty."""

import itertools
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from boards import Boards

from pneudrive_py import (
    CommandError,
    NoAnswerError,
    PneuDriveError,
    PortError,
    PressureController,
    StaleDataError,
    VentWarning,
)

ATMOSPHERE = np.zeros(4)

# Patience with the virtual boards on a busy machine, s. On a quiet one they answer in a fraction of
# a millisecond.
PATIENCE = 2.0


@pytest.fixture
def controller():
    with PressureController("sim", 2, timing="instant", timeout=PATIENCE) as controller:
        controller.ping_devices()
        yield controller


def test_the_papers_script_runs_unchanged():
    controller = PressureController("sim", 1, timeout=PATIENCE)  # but for this argument, as in the paper
    controller.ping_devices()
    for _ in range(5):
        controller.set_pressure_commands(0, np.array([50.0, 50.0, 50.0, 50.0]))
        pressures = controller.get_pressure_data(0)
    assert pressures.shape == (4,)
    assert pressures.dtype == np.float64
    # Powered up a moment ago, the boards still vent, or are on their way.
    assert np.all((pressures > -5.0) & (pressures < 55.0))


def test_pressures_follow_their_commands(controller):
    target = np.array([50.0, 100.0, 150.0, 0.0])
    deadline = time.monotonic() + 10.0
    pressures = ATMOSPHERE
    while time.monotonic() < deadline and not np.allclose(pressures, target, atol=5.0):
        controller.set_pressure_commands(1, target)
        pressures = controller.get_pressure_data(1)
        time.sleep(0.01)
    np.testing.assert_allclose(pressures, target, atol=5.0)
    # The other board was commanded nothing.
    controller.set_pressure_commands(0, ATMOSPHERE)
    np.testing.assert_allclose(controller.get_pressure_data(0), 0.0, atol=5.0)


def test_exchange_all_takes_and_gives_one_row_per_board(controller):
    pressures = controller.exchange_all(np.zeros((2, 4)))
    assert pressures.shape == (2, 4)
    with pytest.raises(CommandError, match=r"shape \(2, 4\), got shape \(3, 4\)"):
        controller.exchange_all(np.zeros((3, 4)))


@pytest.mark.parametrize(
    ("pressures", "message"),
    [
        ([np.nan, 0, 0, 0], "channel 0: commanded pressure is NaN"),
        ([0, 0, np.inf, 0], "channel 2: commanded pressure is inf"),
        ([0, -1.0, 0, 0], "channel 1: commanded pressure is -1 kPa"),
        ([0, 0, 0, 776.0], "channel 3: commanded pressure is 776 kPa, above the sensor's full scale"),
        ([0, 0, 0], r"expected 4 numbers in kPa, shape \(4,\), got shape \(3,\)"),
        (np.zeros((2, 2)), r"expected 4 numbers in kPa, shape \(4,\), got shape \(2, 2\)"),
        (["a"] * 4, r"expected 4 numbers in kPa, shape \(4,\), got texts"),
        ("100", r"expected 4 numbers in kPa, shape \(4,\), got str"),
        (None, r"expected 4 numbers in kPa, shape \(4,\), got NoneType"),
    ],
)
def test_what_cannot_be_commanded_is_refused_before_anything_is_sent(controller, pressures, message):
    controller.set_pressure_commands(0, ATMOSPHERE)
    before = controller.get_pressure_data(0)
    with pytest.raises(CommandError, match=message):
        controller.set_pressure_commands(0, pressures)
    # Nothing was sent, so the last pressures are still the current ones.
    np.testing.assert_array_equal(controller.get_pressure_data(0), before)


@pytest.mark.parametrize("device", [-1, 2, 256, 2**40])
def test_there_are_only_so_many_boards(controller, device):
    with pytest.raises(CommandError, match=f"there is no board {device}: this controller has 2, counted from 0"):
        controller.set_pressure_commands(device, ATMOSPHERE)
    with pytest.raises(CommandError):
        controller.get_pressure_data(device)


def test_an_unplugged_board_is_an_error_and_not_its_last_pressure():
    with PressureController("sim", 1, timing="instant") as boards:
        boards.ping_devices()
        port = boards.port
        boards.close()
        # The same line, with one board more than there is.
        with pytest.warns(VentWarning, match=r"board\(s\) \[1\]"), PressureController(port, 2, timeout=0.2) as controller:
            controller.set_pressure_commands(0, ATMOSPHERE)
            with pytest.raises(NoAnswerError) as failure:
                controller.set_pressure_commands(1, ATMOSPHERE)
            assert failure.value.board == 1
            assert isinstance(failure.value, TimeoutError)
            with pytest.raises(StaleDataError, match="board 1: no current pressures"):
                controller.get_pressure_data(1)
            with pytest.raises(NoAnswerError, match="no answer from 1 of 2 boards"):
                controller.ping_devices(timeout=0.1)
            controller.get_pressure_data(0)


def test_before_the_first_exchange_there_is_nothing_to_give():
    with PressureController("sim", 1) as controller, pytest.raises(StaleDataError):
        controller.get_pressure_data(0)


def test_a_port_that_is_not_there():
    with pytest.raises(PortError, match='/dev/does-not-exist: no such port.*pass "sim"') as failure:
        PressureController("/dev/does-not-exist", 1)
    assert isinstance(failure.value, OSError)


def test_a_second_controller_on_the_same_port_is_refused(controller):
    with pytest.raises(PortError, match="another PressureController of this program has it; close that one first"):
        PressureController(controller.port, 2)


def test_another_program_that_has_the_port_is_named_as_such(controller):
    program = "import sys, pneudrive_py as p\ntry:\n    p.PressureController(sys.argv[1], 2)\nexcept p.PortError as e:\n    print(e)"
    said = subprocess.run([sys.executable, "-c", program, controller.port], capture_output=True, text=True).stdout
    assert "in use by another process" in said


def test_what_is_polled_is_not_used_by_hand(controller):
    with controller.poll(rate_hz=100) as poller:
        for call in (
            controller.ping_devices,
            lambda: controller.set_pressure_commands(0, ATMOSPHERE),
            lambda: controller.exchange_all(np.zeros((2, 4))),
            controller.poll,
        ):
            with pytest.raises(PortError, match="this controller is being polled: use the poller's .* or stop the poller first"):
                call()
        with pytest.raises(StaleDataError, match="board 0: this controller is being polled"):
            controller.get_pressure_data(0)
        assert "polling" in repr(poller) and "polled" in repr(controller)
    assert "ended: it was stopped" in repr(poller)
    controller.set_pressure_commands(0, ATMOSPHERE)
    with controller.poll(rate_hz=100) as poller:
        poller.set_pressure_commands(0, ATMOSPHERE)


def test_a_lost_answer_is_asked_for_again():
    """The board answers every third request only."""

    requests = itertools.count(1)

    def obeys(board, counts):
        return next(requests) % 3 == 0

    with Boards(obeys=obeys) as boards, PressureController(boards.port, 1, timeout=0.1) as controller:
        for _ in range(3):
            controller.set_pressure_commands(0, [50.0] * 4)
        np.testing.assert_allclose(controller.get_pressure_data(0), 50.0, atol=0.5)
        controller.close()
        requests = itertools.count(1)
        with PressureController(boards.port, 1, timeout=0.1, retries=0) as controller, pytest.raises(NoAnswerError):
            controller.set_pressure_commands(0, [50.0] * 4)


@pytest.mark.parametrize("retries", [-1, 101])
def test_numbers_of_retries_that_cannot_be(retries):
    with pytest.raises(CommandError, match=f"retries is {retries}; it must be 0 to 100"):
        PressureController("sim", 1, retries=retries)


@pytest.mark.parametrize("devices", [0, -1, 5, 256])
def test_numbers_of_boards_that_cannot_be(devices, tmp_path):
    with pytest.raises(ValueError, match=f"num_devices is {devices}; it must be 1 to 4") as refused:
        PressureController("sim", devices)
    assert isinstance(refused.value, CommandError) and ("max_devices=" in str(refused.value)) == (devices > 4)
    with pytest.raises(CommandError, match="max_devices is 256; it must be 1 to 255"):
        PressureController("sim", devices, max_devices=256)


def test_more_boards_than_switches_tell_apart_have_to_be_asked_for(tmp_path):
    rig = tmp_path / "rig.toml"
    rig.write_text('[bus]\nport = "sim"\nboards = 9\n')
    with pytest.raises(CommandError, match="num_devices is 9; it must be 1 to 4; boards with more"):
        PressureController(rig=rig)
    with PressureController(rig=rig, max_devices=9, timing="instant") as controller:
        assert controller.num_devices == 9


def test_a_closed_controller_says_so(controller):
    controller.close()
    controller.close()
    with pytest.raises(PortError, match="closed"):
        controller.set_pressure_commands(0, ATMOSPHERE)
    with pytest.raises(StaleDataError, match="board 0: no current pressures, because this controller is closed"):
        controller.get_pressure_data(0)
    assert "closed" in repr(controller)


def test_polling_in_the_background(controller):
    with controller.poll(rate_hz=200, history_s=5.0) as poller:
        poller.set_pressure_commands(1, [10.0, 20.0, 30.0, 40.0])
        while len(poller.history()["t_s"]) < 50:
            time.sleep(0.01)
        history = poller.history()
        pressures = poller.get_pressure_data(1)
        with pytest.raises(PneuDriveError):
            poller.set_pressure_commands(2, ATMOSPHERE)
    assert pressures.shape == (4,)
    rows = len(history["t_s"])
    assert history["commands_kpa"].shape == history["pressures_kpa"].shape == (rows, 2, 4)
    assert np.all(np.diff(history["t_s"]) > 0)
    np.testing.assert_allclose(history["commands_kpa"][-1, 1], [10.0, 20.0, 30.0, 40.0], atol=0.5)
    assert poller.statistics()["lost"] == 0
    # The bus is the controller's again.
    controller.set_pressure_commands(0, ATMOSPHERE)
    with pytest.raises(PneuDriveError, match="ended"):
        poller.set_pressure_commands(0, ATMOSPHERE)


def test_the_history_keeps_the_time_it_was_asked_to(controller):
    with controller.poll(rate_hz=500, history_s=0.1) as poller:
        time.sleep(0.5)
        times = poller.history()["t_s"]
    assert 0 < times[-1] - times[0] <= 0.1 + 1e-9


def test_exchanges_do_not_hold_the_interpreter():
    """Other threads run while an exchange waits for a board that is not there."""
    with PressureController("sim", 1, timing="instant") as boards:
        port = boards.port
        boards.close()
        with pytest.warns(VentWarning), PressureController(port, 2, timeout=0.5, retries=0) as controller:
            ticks = []
            done = threading.Event()

            def tick():
                while not done.is_set():
                    ticks.append(time.monotonic())
                    time.sleep(0.005)

            thread = threading.Thread(target=tick)
            thread.start()
            with pytest.raises(NoAnswerError):
                controller.set_pressure_commands(1, ATMOSPHERE)
            during = len(ticks)
            done.set()
            thread.join()
    assert during > 20


def test_a_close_ends_another_threads_exchange():
    with Boards(obeys=lambda board, counts: counts == [102] * 4) as boards:
        controller = PressureController(boards.port, 1, timeout=1.0, retries=100)
        failures = []

        def work():
            try:
                controller.set_pressure_commands(0, [50.0] * 4)
            except PneuDriveError as error:
                failures.append(str(error))

        thread = threading.Thread(target=work)
        thread.start()
        time.sleep(0.2)
        controller.close()
        thread.join()
        assert failures == ["this controller is closed"]
        assert boards.is_vented()


def test_threads_may_share_a_controller(controller):
    failures = []

    def work(board):
        try:
            for _ in range(200):
                controller.set_pressure_commands(board, ATMOSPHERE)
                assert controller.get_pressure_data(board).shape == (4,)
        except Exception as error:  # noqa: BLE001
            failures.append(error)

    threads = [threading.Thread(target=work, args=(board,)) for board in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failures
