"""Ctrl-C at any call comes through at once as KeyboardInterrupt, and the boards are left vented."""

import numpy as np
import pytest
from boards import ATMOSPHERE_COUNTS, Boards, run
from conftest import RIG_TOML

import pneudrive_py as pneu

# Board 1 answers nothing but vents: whoever commands it waits for as long as the timeout says.
TWO_BOARDS = """
controller = pneu.PressureController(port, 2, timeout=1.0)
controller.set_pressure_commands(0, [100.0] * 4)
"""


def only_vents(board, counts):
    return board == 0 or counts == [ATMOSPHERE_COUNTS] * 4


# Board 1 answers nothing at all: whoever vents it waits for some seconds.
ONE_MISSING = TWO_BOARDS.replace("1.0", "0.4")


def not_there(board, counts):
    return board == 0


CALLS = {
    "an exchange": (TWO_BOARDS, only_vents, "controller.set_pressure_commands(1, [10.0] * 4)"),
    "retries of an exchange": (
        TWO_BOARDS.replace("1.0", "0.2, retries=100"),
        only_vents,
        "controller.set_pressure_commands(1, [10.0] * 4)",
    ),
    "all boards": (TWO_BOARDS, only_vents, "controller.exchange_all([[100.0] * 4, [10.0] * 4])"),
    "a ping": (TWO_BOARDS.replace("1.0", "0.01"), not_there, "controller.ping_devices(timeout=60.0)"),
    "opening": (TWO_BOARDS, only_vents, "controller.close()\n    pneu.PressureController(port, 1, timeout=60.0)"),
    "a close": (ONE_MISSING, not_there, "controller.close()"),
    "the end of a with block": (ONE_MISSING, not_there, "with controller:\n        pass"),
    "a wait for another thread's exchange": (
        TWO_BOARDS,
        only_vents,
        "threading.Thread(target=lambda: controller.set_pressure_commands(1, [10.0] * 4), daemon=True).start()\n"
        "    while True:\n"
        "        controller.set_pressure_commands(0, [100.0] * 4)",
    ),
}


def interrupted(call):
    """The program's lines that make the call while a signal is on its way."""
    return f"""
interrupt_soon()
try:
    {call}
    print("it returned")
except BaseException as error:
    print(type(error).__name__)
"""


@pytest.mark.parametrize("call", CALLS)
def test_calls_of_a_controller(call):
    drive, obeys, call = CALLS[call]
    with Boards(count=2, obeys=obeys) as boards:
        ended, said, errors = run(drive + interrupted(call), boards)
        assert (ended, said) == (0, "KeyboardInterrupt\n"), errors
        assert boards.were_under_pressure() and boards.is_vented()


def test_an_interrupt_at_the_end_of_the_interpreter_does_not_keep_it_from_venting():
    with Boards(count=2, obeys=not_there) as boards:
        ended, _, errors = run(ONE_MISSING + "interrupt_soon()\n", boards)
        assert ended == 0, errors
        assert boards.were_under_pressure() and boards.is_vented()
        # Board 1 was asked to the end: it is named.
        assert "0 kPa was not confirmed by board(s) [1]" in errors


POLLER_CALLS = {
    "waiting beside a poller": "time.sleep(60)",
    "stopping": "poller.stop()",
    "the end of its with block": "with poller:\n        pass",
    "closing the controller": "controller.close()",
    "reading in a loop": "while True:\n        poller.get_pressure_data(0)",
    "commanding in a loop": "while True:\n        poller.set_pressure_commands(0, [100.0] * 4)",
    "history in a loop": "while True:\n        poller.history()",
    "statistics in a loop": "while True:\n        poller.statistics()",
}


@pytest.mark.parametrize("call", POLLER_CALLS)
def test_calls_beside_a_poller(call):
    with Boards(count=2, obeys=not_there) as boards:
        program = """
controller = pneu.PressureController(port, 2, timeout=0.3)
poller = controller.poll()
poller.set_pressure_commands(0, [100.0] * 4)
until(lambda: np.any(poller.history()["pressures_kpa"][:, 0] > 99.0))
"""
        ended, said, errors = run(program + interrupted(POLLER_CALLS[call]), boards)
        assert (ended, said) == (0, "KeyboardInterrupt\n"), errors
        assert boards.were_under_pressure() and boards.is_vented()


@pytest.fixture(scope="module")
def recording_file(tmp_path_factory, columns):
    path = tmp_path_factory.mktemp("interrupts") / "run.csv"
    names = list(columns)
    table = np.column_stack([columns[name] for name in names])
    np.savetxt(path, table, delimiter=",", header=",".join(names), comments="")
    return path


TOOLKIT_CALLS = {
    "simulate": "while True:\n        pneu.simulate(recording, parameters)",
    "fit": "while True:\n        pneu.fit(recording, rig, starts=50)",
    "compare": "while True:\n        pneu.compare(recording, rig, starts=50)",
    "diagnose": "while True:\n        pneu.diagnose(recording, rig)",
    "load": "while True:\n        pneu.load(sys.argv[2], rig)",
    "a large batch": "batch(400, 20_000)",
    "small batches": "while True:\n        batch(1, 20)",
}


@pytest.mark.parametrize("call", TOOLKIT_CALLS)
def test_calls_of_the_toolkit(call, recording_file, tmp_path, fit):
    stored = tmp_path / "parameters.toml"
    fit.save(stored)
    with Boards() as boards:
        program = f"""
rig = pneu.Rig.parse({RIG_TOML!r})
recording = pneu.load({str(recording_file)!r}, rig)
parameters = pneu.Parameters.load({str(stored)!r})
sys.argv.append({str(recording_file)!r})

def batch(chambers, rows):
    table = np.tile([0.02, 0.02, 2.0, 0.05, 0.03, 0.1, 1.0], (chambers, 1))
    pneu.simulate_batch("nonlinear", table, 0.01, drive=np.sin(np.arange(rows) / 20.0), start_kpa=100.0, rig=rig, substeps=20)

controller = pneu.PressureController(port, 1, timeout=0.2)
controller.set_pressure_commands(0, [100.0] * 4)
"""
        ended, said, errors = run(program + interrupted(TOOLKIT_CALLS[call]), boards)
        assert (ended, said) == (0, "KeyboardInterrupt\n"), errors
        assert boards.were_under_pressure() and boards.is_vented()


def test_an_interrupt_while_an_argument_is_read_is_no_wrong_argument():
    class Interrupting:
        def __array__(self, *_, **__):
            raise KeyboardInterrupt

    with pneu.PressureController("sim", 1, timing="instant") as controller:
        with pytest.raises(KeyboardInterrupt):
            controller.set_pressure_commands(0, Interrupting())
    with pytest.raises(KeyboardInterrupt):
        pneu.simulate_batch("nonlinear", Interrupting(), 0.01, drive=[0.0])
    with pytest.raises(KeyboardInterrupt):
        pneu.Recording.from_columns({"t_s": Interrupting()})
