"""What a command may do, how long it holds, and how the node leaves the boards."""

import signal
import subprocess
import time

import pytest
from boards import Boards
from conftest import binary
from peers import PATIENCE_S, Joint, Node, Peer, until
from std_srvs.srv import Trigger
from test_node import BUS_0, JOINT_0

NAMES = [f"b0_cmd{k}_kpa" for k in range(4)]


def call(peer, service):
    """Calls a service without arguments of the node; returns its answer."""
    client = peer.node.create_client(Trigger, f"/pneudrive/{service}")
    assert client.wait_for_service(timeout_sec=PATIENCE_S)
    future = client.call_async(Trigger.Request())
    until(f"an answer of {service}", future.done)
    return future.result()


def test_a_command_that_is_not_repeated_expires():
    """Without any flag. The joint is commanded again by the next command."""
    with Node(), Peer() as peer:
        joint = Joint(peer)
        joint.wait_until_connected()
        for count in (1, 2):
            before = peer.counter(JOINT_0, "command timeouts") or 0
            joint.wait_until_near(100)
            until("0 kPa", lambda: joint.commands() == pytest.approx([0] * 4, abs=0.5))
            until("the count", lambda: peer.counter(JOINT_0, "command timeouts") > before)
            until("venting", lambda: all(p < 6 for p in joint.pressures()))


def test_a_command_holds_for_ever_only_where_that_is_asked_for():
    with Node("--command-timeout-s", "never") as node, Peer() as peer:
        joint = Joint(peer)
        joint.wait_until_connected()
        joint.wait_until_near(100)
        joint.wait_for_new_states(2000)
        assert joint.commands() == pytest.approx([100] * 4, abs=0.5)
        assert "no command for too long" not in node.said


def test_positions_are_not_obeyed_as_pressures():
    with Node() as node, Peer() as peer:
        joint = Joint(peer)
        joint.wait_until_connected()
        until(
            "the count",
            lambda: joint.command(position=[50.0] * 4) or peer.counter(JOINT_0, "commands refused: not in effort"),
        )
        until("a sentence", lambda: "pressures in kPa come in `effort`" in node.said)
        assert joint.commands() == pytest.approx([0] * 4, abs=0.5)


def test_names_key_the_values():
    with Node() as node, Peer() as peer:
        joint = Joint(peer)
        joint.wait_until_connected()

        def commanded(kpa, *values, name):
            def there():
                joint.command(*values, name=name)
                time.sleep(0.02)
                return joint.commands() == pytest.approx(kpa, abs=0.5)

            until(str(kpa), there)

        commanded([10, 20, 30, 40], 40, 30, 20, 10, name=NAMES[::-1])
        commanded([0, 0, 60, 0], 60, name=NAMES[2:3])
        until(
            "the count",
            lambda: joint.command(50, name=["left_elbow"]) or peer.counter(JOINT_0, "commands refused: wrong names"),
        )
        until("a sentence", lambda: "left_elbow is no command of joint_0: its names are b0_cmd0_kpa to" in node.said)


def test_limits_refuse_and_ramp():
    with Node("--max-kpa", 150, "--max-rate-kpa-s", 100, "--command-timeout-s", "never") as node, Peer() as peer:
        joint = Joint(peer)
        joint.wait_until_connected()
        until("the count", lambda: joint.command(*[151] * 4) or peer.counter(JOINT_0, "commands refused: out of range"))
        until("a sentence", lambda: "151.0 kPa for channel 0 of board 0 is above its limit of 150 kPa" in node.said)
        first = len(joint.states)
        joint.wait_until_near(150)
        states = joint.states[first:]
        times = [s.header.stamp.sec + 1e-9 * s.header.stamp.nanosec for s in states]
        sent = [s.effort[4] for s in states]
        rising = [(t, kpa) for t, kpa in zip(times, sent) if 20 < kpa < 140]
        assert len(rising) > 20, "it is ramped"
        # A step is late by at most what the ramp makes up for at once, 50 ms, and rounded to a
        # count.
        (from_s, from_kpa), (to_s, to_kpa) = rising[0], rising[-1]
        assert to_kpa - from_kpa <= 100 * (to_s - from_s + 0.06) + 2


def test_vent_and_release():
    with Node() as node, Peer() as peer:
        joint = Joint(peer)
        joint.wait_until_connected()
        joint.wait_until_near(100)
        answer = call(peer, "vent")
        assert answer.success and "until ~/release is called" in answer.message
        until("0 kPa whatever comes", lambda: joint.command(*[100] * 4) or all(p < 6 for p in joint.pressures()))
        until("diagnostics", lambda: peer.diagnostics[BUS_0][1] == "vented until ~/release is called")
        assert call(peer, "release").success
        joint.wait_until_near(60)
        assert "released" in node.said


def test_boards_stay_vented_after_a_port_came_back(tmp_path):
    link = tmp_path / "bus"

    def boards():
        command = [binary("pneudrive-sim"), "--devices", "1", "--link", str(link)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert process.stdout.readline()
        return process

    first = boards()
    with Node(port=str(link)) as node, Peer() as peer:
        joint = Joint(peer)
        joint.wait_until_connected()
        joint.wait_until_near(100)
        first.terminate()
        first.wait()
        second = boards()
        try:
            until("what it says", lambda: "0 kPa is commanded until ~/release is called" in node.said)
            joint.wait_for_new_states(20)
            for _ in range(50):
                joint.command(*[100] * 4)
                time.sleep(0.02)
            assert joint.commands() == pytest.approx([0] * 4, abs=0.5)
            assert call(peer, "release").success
            joint.wait_until_near(60)
        finally:
            second.terminate()
            second.wait()


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_node_that_is_told_to_end_leaves_the_boards_vented(how):
    with Boards() as boards:
        with Node("--allowance-us", 200_000, "--command-timeout-s", "never", port=boards.port) as node, Peer() as peer:
            joint = Joint(peer)
            joint.wait_until_connected()
            joint.wait_until_near(100)
            assert boards.were_under_pressure() and not boards.is_vented()
            assert node.end(how) == 0, node.said
        assert boards.is_vented()


def test_a_joint_that_never_answered_is_told_and_fails_nothing_that_was_not_commanded():
    with Boards() as boards:
        with Node("--devices", 2, "--allowance-us", 200_000, port=boards.port) as node, Peer() as peer:
            joint = Joint(peer)
            joint.wait_until_connected()
            joint.wait_for_new_states()
            assert node.end() == 0, node.said
        assert "joint(s) 1 never answered" in node.said
        assert "shut off the air supply" not in node.said
        assert boards.is_vented()


def test_a_node_that_fails_leaves_the_boards_vented(tmp_path):
    """Its recording cannot be written any more: the file may not grow."""
    with Boards() as boards:
        arguments = ["--allowance-us", 200_000, "--command-timeout-s", "never", "--record", tmp_path / "run.mcap"]
        with Node(*arguments, port=boards.port, file_bytes=200_000) as node, Peer() as peer:
            joint = Joint(peer)
            joint.wait_until_connected()
            joint.wait_until_near(100)
            assert node.process.wait(timeout=PATIENCE_S) == 1, node.said
        assert boards.were_under_pressure() and boards.is_vented()
