"""A forked child has copies of what only its parent may use."""

import pytest
from boards import ATMOSPHERE_COUNTS, Boards, run
from test_endings import BY_HAND, POLLED

WAIT = """
_, status = os.waitpid(child, 0)
print("child:", os.waitstatus_to_exitcode(status), flush=True)
"""

# How a child may end: the interpreter's usual end, an exception, deleting what it has, all of it at
# once.
CHILDREN = {
    "its end": "sys.exit(5)",
    "an exception": "raise SystemExit(5)",
    "deleting": "globals().pop('poller', None); del controller; gc.collect(); os._exit(5)",
    "a with block": """
    try:
        with controller:
            pass
    except pneu.PneuDriveError:
        sys.exit(5)""",
}


@pytest.mark.parametrize("drive", [BY_HAND, POLLED], ids=["by hand", "polled"])
@pytest.mark.parametrize("child", CHILDREN)
def test_a_child_neither_vents_nor_disturbs(drive, child):
    with Boards() as boards:
        ended, said, errors = run(
            drive
            + "child = os.fork()\nif child == 0:\n    "
            + CHILDREN[child]
            + WAIT
            + """
if "poller" in globals():
    before = len(poller.history()["t_s"])
    until(lambda: len(poller.history()["t_s"]) > before + 5)
    print(poller)
os._exit(0)  # nothing of the parent's own ending
""",
            boards,
        )
        assert ended == 0 and "child: 5" in said, errors
        assert drive is BY_HAND or "polling" in said
        pressures = [values for _, values in boards.commands]
        first = next(at for at, values in enumerate(pressures) if min(values) > ATMOSPHERE_COUNTS)
        assert all(min(values) > ATMOSPHERE_COUNTS for values in pressures[first:]), "nobody vented"


CALLS = {
    BY_HAND: [
        "controller.ping_devices()",
        "controller.set_pressure_commands(0, [50.0] * 4)",
        "controller.get_pressure_data(0)",
        "controller.exchange_all([[50.0] * 4])",
        "controller.poll()",
        "controller.close()",
    ],
    POLLED: [
        "poller.set_pressure_commands(0, [50.0] * 4)",
        "poller.get_pressure_data(0)",
        "poller.history()",
        "poller.statistics()",
        "poller.stop()",
        "controller.poll()",
        "controller.close()",
    ],
}


@pytest.mark.parametrize("drive", CALLS, ids=["by hand", "polled"])
def test_what_a_child_calls_is_refused(drive):
    with Boards() as boards:
        ended, said, errors = run(
            drive
            + f"""
child = os.fork()
if child == 0:
    for call in {CALLS[drive]!r}:
        try:
            eval(call)
        except pneu.PneuDriveError as error:
            print(error, flush=True)
    print(repr(controller), flush=True)
    os._exit(5)
"""
            + WAIT
            + "print(os.getpid())",
            boards,
        )
        assert ended == 0, errors
        *refusals, representation, child, parent = said.splitlines()
        assert len(refusals) == len(CALLS[drive])
        for refusal in refusals:
            assert f"belongs to process {parent}, from which this process" in refusal
            assert "only that one may drive the boards; nothing was sent" in refusal
        assert representation.endswith("of another process>")
        assert child == "child: 5"
        assert boards.is_vented()


BATCH = """
def batch(rows):
    drive = np.sin(np.arange(rows) / 20.0)
    return pneu.simulate_batch(
        "nonlinear", np.tile([0.02, 0.02, 2.0, 0.05, 0.03, 0.1, 1.0], (64, 1)), 0.01, drive=drive, start_kpa=100.0,
        rig=pneu.Rig(supply={"pressure_kpa": 550.0}, chamber={"radius_m": 0.024, "length_m": 0.2, "offset_m": 0.045}),
    )

expected = batch(2000)
"""


def test_a_batch_in_children_and_their_children():
    with Boards() as boards:
        ended, said, errors = run(
            BATCH
            + """
def check(depth):
    assert np.array_equal(batch(2000), expected) and np.array_equal(batch(20), expected[:, :20])
    print("the same", depth, flush=True)
    if depth == 2:
        return
    child = os.fork()
    if child == 0:
        check(depth + 1)
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0

check(0)
""",
            boards,
        )
        assert ended == 0, errors
        assert said.splitlines() == [f"the same {depth}" for depth in range(3)]


def test_a_batch_in_the_workers_of_a_pool():
    with Boards() as boards:
        ended, said, errors = run(
            BATCH
            + """
import multiprocessing
with multiprocessing.get_context("fork").Pool(2) as pool:
    results = pool.map(batch, [2000, 2000, 20])
assert all(np.array_equal(result, expected[:, : result.shape[1]]) for result in results)
print("all the same")
""",
            boards,
        )
        assert (ended, said) == (0, "all the same\n"), errors
