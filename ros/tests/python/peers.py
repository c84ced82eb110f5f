"""Both ends of the node's tests: the node as a process, and what talks to it through real rclpy."""

import ctypes
import os
import pathlib
import resource
import signal
import subprocess
import threading
import time

import rclpy
from conftest import binary
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

# What the machine may be slow by. Nothing waits so long that goes right.
PATIENCE_S = 60.0
RELIABLE = QoSProfile(depth=2000, history=HistoryPolicy.KEEP_LAST, reliability=ReliabilityPolicy.RELIABLE)
BEST_EFFORT = QoSProfile(
    depth=2000, history=HistoryPolicy.KEEP_LAST, reliability=ReliabilityPolicy.BEST_EFFORT
)


def until(what, condition):
    """Waits for `condition` and returns what it gave."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        result = condition()
        if result:
            return result
        time.sleep(0.02)
    raise AssertionError(f"waited in vain for {what}")


class Node:
    """`pneudrive-ros`, started with these arguments on virtual boards."""

    def __init__(self, *arguments, port="sim", file_bytes=None):
        """`file_bytes`: how large its files may grow."""
        # Peers on a busy machine may lag behind: only tests of stale commands want the usual limit.
        defaults = ["--port", port, "--max-command-age-s", "30", "--diagnostics-period-s", "0.2"]
        command = [binary("pneudrive-ros"), *defaults, *map(str, arguments)]

        def limit():
            if file_bytes is not None:
                # Without a handler the signal ends the process; ignored, the write fails.
                signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
                resource.setrlimit(resource.RLIMIT_FSIZE, (file_bytes, file_bytes))

        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=limit)
        self.said = ""
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()
        until("the node to start", lambda: "DDS domain" in self.said or self.process.poll() is not None)
        assert self.process.poll() is None, self.said

    def read(self):
        for line in self.process.stderr:
            self.said += line

    def end(self, how=signal.SIGTERM):
        """Ends it and returns its exit status; `said` then holds all of its standard error."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        self.process.wait(timeout=PATIENCE_S)
        self.reader.join(timeout=PATIENCE_S)
        return self.process.returncode

    def __enter__(self):
        return self

    def __exit__(self, *_):
        print(f"\nthe node said: {self.said}")
        self.end(signal.SIGKILL)


class Frozen:
    """Threads of a child process that stand still inside the `with`, while its others go on: all of this name."""

    SEIZE, INTERRUPT, DETACH, WALL = 0x4206, 0x4207, 17, 0x40000000

    def __init__(self, process, name):
        self.libc = ctypes.CDLL(None, use_errno=True)
        tasks = pathlib.Path(f"/proc/{process.pid}/task").iterdir()
        self.threads = [int(task.name) for task in tasks if (task / "comm").read_text().strip() == name]

    def ptrace(self, request, thread):
        if self.libc.ptrace(request, thread, None, None) != 0:
            raise OSError(ctypes.get_errno(), "ptrace")

    def __enter__(self):
        for thread in self.threads:
            self.ptrace(self.SEIZE, thread)
            self.ptrace(self.INTERRUPT, thread)
            os.waitpid(thread, self.WALL)

    def __exit__(self, *_):
        for thread in self.threads:
            self.ptrace(self.DETACH, thread)


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


class Joint:
    """A subscriber to the states of one joint, and a publisher of its commands."""

    def __init__(self, peer, number=0, node="/pneudrive", qos=RELIABLE):
        self.peer = peer
        self.states, self.latencies_s = [], []
        topic = f"{node}/joint_{number}"
        self.subscription = peer.node.create_subscription(JointState, f"{topic}/pressure_state", self.take, qos)
        self.publisher = peer.node.create_publisher(JointState, f"{topic}/pressure_command", qos)

    def take(self, message):
        self.latencies_s.append(time.time() - seconds(message.header.stamp))
        self.states.append(message)

    def command(self, *kpa, age_s=0.0, **fields):
        """Commands these pressures; `fields` are further ones of the message."""
        message = JointState(effort=[float(p) for p in kpa], **fields)
        stamp = time.time() - age_s
        message.header.stamp.sec, message.header.stamp.nanosec = int(stamp), int(stamp % 1 * 1e9)
        self.publisher.publish(message)

    def pressures(self):
        """The last measured pressures, kPa."""
        return list(self.states[-1].effort[:4]) if self.states else None

    def commands(self):
        """The last commands that the board was sent, kPa."""
        return list(self.states[-1].effort[4:]) if self.states else None

    def wait_until_connected(self):
        until("the node's topics", lambda: self.publisher.get_subscription_count() > 0 and self.states)

    def wait_for_new_states(self, count=50):
        before = len(self.states)
        until("new states", lambda: len(self.states) >= before + count)

    def wait_until_near(self, kpa, tolerance=6.0):
        """Repeats the command, as controllers do, until all four pressures are there."""

        def there():
            self.command(*[kpa] * 4)
            time.sleep(0.02)
            now = self.pressures()
            return now and all(abs(p - kpa) < tolerance for p in now)

        until(f"{kpa} kPa", there)


class Peer:
    """An rclpy node that spins on a thread."""

    def __init__(self, name="peer", domain=None):
        domain = int(os.environ["ROS_DOMAIN_ID"]) if domain is None else domain
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node(name, context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.diagnostics = {}
        self.closing = False
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self.take, 10)
        self.thread = threading.Thread(target=self.spin, daemon=True)
        self.thread.start()

    def spin(self):
        try:
            self.executor.spin()
        except Exception:
            # What is being destroyed cannot be waited for.
            if not self.closing:
                raise

    def take(self, array):
        for status in array.status:
            values = {pair.key: pair.value for pair in status.values}
            self.diagnostics[status.name] = (status.level, status.message, values)

    def counter(self, status, key):
        """A number out of the last diagnostics, or `None`."""
        if status not in self.diagnostics:
            return None
        return float(self.diagnostics[status][2][key])

    def close(self):
        self.closing = True
        self.executor.shutdown(timeout_sec=5.0)
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)
        self.thread.join(timeout=10.0)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
