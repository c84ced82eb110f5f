"""Whatever ends, ends with the boards at 0 kPa. Each program ends in a process of its own; boards without a command timeout show
what they were commanded last."""

import re

import pytest
from boards import Boards, run

BY_HAND = """
controller = pneu.PressureController(port, 1, timeout=0.2)
controller.set_pressure_commands(0, [100.0] * 4)
"""

POLLED = """
controller = pneu.PressureController(port, 1, timeout=0.2)
poller = controller.poll(rate_hz=200)
poller.set_pressure_commands(0, [100.0] * 4)
until(lambda: len(poller.history()["t_s"]) and poller.history()["pressures_kpa"][-1].min() > 99.0)
"""

# What runs at the interpreter's end does not run after this: the boards must be vented before.
AT_ONCE = "os._exit(0)\n"

ENDINGS = {
    "close": ("controller.close()\n" + AT_ONCE, 0),
    "the end of a with block": ("with controller:\n    pass\n" + AT_ONCE, 0),
    "an exception in a with block": (
        "try:\n    with controller:\n        raise KeyError\nexcept KeyError:\n    pass\n" + AT_ONCE,
        0,
    ),
    "del": ("del controller\n" + AT_ONCE, 0),
    "garbage collection": (
        "loop = [controller]\nloop.append(loop)\ndel loop, controller\ngc.collect()\n" + AT_ONCE,
        0,
    ),
    "the interpreter's end": ("", 0),
    "the interpreter's end with the controller in a cycle": ("loop = [controller]\nloop.append(loop)\n", 0),
    "sys.exit": ("sys.exit(3)\n", 3),
    "sys.exit in a function that holds it": ("def f(c):\n    sys.exit(3)\nf(controller)\n", 3),
    "an exception that nobody catches": ("raise KeyError\n", 1),
    "Ctrl-C that nobody catches": ("interrupt_soon()\ntime.sleep(60)\n", -2),
    "a SIGTERM handler that calls sys.exit": (
        "signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))\nos.kill(os.getpid(), signal.SIGTERM)\ntime.sleep(60)\n",
        143,
    ),
}


@pytest.mark.parametrize("drive", [BY_HAND, POLLED], ids=["by hand", "polled"])
@pytest.mark.parametrize("ending", ENDINGS)
def test_boards_are_left_vented(drive, ending):
    program, status = ENDINGS[ending]
    with Boards() as boards:
        ended, _, said = run(drive + program, boards)
        assert ended == status, said
        assert boards.were_under_pressure()
        assert boards.is_vented()


@pytest.mark.parametrize("ending", ["poller.stop()", "with poller:\n    pass", "del poller"])
def test_a_poller_that_ends_leaves_the_boards_vented(ending):
    with Boards() as boards:
        ended, _, said = run(POLLED + ending + "\n" + AT_ONCE, boards)
        assert ended == 0, said
        assert boards.were_under_pressure() and boards.is_vented()


def test_killed_by_sigterm_python_can_do_nothing():
    """What the documentation says: without a handler there is nobody to vent. Boards with a command timeout vent by it."""
    with Boards() as boards:
        ended, _, _ = run(POLLED + "os.kill(os.getpid(), signal.SIGTERM)\ntime.sleep(60)\n", boards)
        assert ended == -15
        assert boards.were_under_pressure() and not boards.is_vented()


def test_a_poller_does_not_outlive_its_controller():
    with Boards() as boards:
        ended, said, errors = run(
            POLLED
            + """
print(controller, poller, sep="\\n")
controller.close()
print(controller, poller, sep="\\n")
for call in (lambda: poller.set_pressure_commands(0, [50.0] * 4), lambda: poller.get_pressure_data(0)):
    try:
        call()
    except pneu.PneuDriveError as error:
        print(type(error).__name__, error)
poller.stop()
print(poller.statistics()["cycles"] > 0, len(poller.history()["t_s"]) > 0)
# The port is free.
with pneu.PressureController(port, 1, timeout=0.2) as again:
    again.ping_devices()
""",
            boards,
        )
        assert ended == 0, errors
        lines = said.splitlines()
        assert re.fullmatch(r'<PressureController ".*", 1 board, polled>', lines[0])
        assert lines[1] == "<Poller of 1 board, polling, 0 to 689 kPa>"
        assert re.fullmatch(r'<PressureController ".*", 1 board, closed>', lines[2])
        assert lines[3] == "<Poller of 1 board, ended: its controller was closed, 0 to 689 kPa>"
        assert lines[4] == "PortError this poller has ended: its controller was closed"
        assert lines[5] == "StaleDataError board 0: no current pressures; this poller has ended: its controller was closed"
        assert lines[6] == "True True"
        assert boards.is_vented()


def test_boards_that_do_not_confirm_are_named():
    with Boards(count=1) as boards:
        ended, _, said = run("pneu.PressureController(port, 2, timeout=0.1).close()\n", boards)
        assert ended == 0
        assert "VentWarning: 0 kPa was not confirmed by board(s) [1]" in said
        assert boards.is_vented(0)


def test_a_port_is_free_for_the_next_even_where_a_forked_child_lives_on():
    with Boards() as boards:
        ended, said, errors = run(
            POLLED
            + """
child = os.fork()
if child == 0:
    time.sleep(60)
    os._exit(0)
poller.stop()
controller.set_pressure_commands(0, [20.0] * 4)
print(controller.get_pressure_data(0).shape)
os.kill(child, signal.SIGKILL)
""",
            boards,
        )
        assert (ended, said) == (0, "(4,)\n"), errors
        assert boards.is_vented()
