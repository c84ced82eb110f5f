"""How a node with several buses does: rates, losses, latencies and processor time, with one virtual bus a process.

    cargo build --release -p pneudrive-ros -p pneudrive-sim
    PNEUDRIVE_PROFILE=release python ros/tests/python/measure.py --buses 4 --boards 4 --seconds 20
"""

import argparse
import os
import subprocess
import time

import numpy as np
from conftest import binary
from peers import Joint, Node, Peer, until

TICKS = os.sysconf("SC_CLK_TCK")


def cpu_s(pid):
    """Processor time of a process so far, s."""
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def measure(arguments):
    sims = []
    for _ in range(arguments.buses):
        command = [binary("pneudrive-sim"), *arguments.sim.split(), "--devices", str(arguments.boards)]
        sims.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True))
    try:
        ports = ",".join(sim.stdout.readline().strip() for sim in sims)
        options = ["--devices", arguments.boards, "--diagnostics-period-s", 1, *arguments.node.split()]
        with Node(*options, port=ports) as node, Peer() as peer:
            total = arguments.buses * arguments.boards
            joints = [Joint(peer, number) for number in range(min(total, arguments.heard))]
            for joint in joints:
                joint.wait_until_connected()
            until("diagnostics", lambda: len(peer.diagnostics) == total + arguments.buses)
            for joint in joints:
                joint.states.clear(), joint.latencies_s.clear()
            before = {name: status[2] for name, status in peer.diagnostics.items()}
            start, node_s, sims_s = time.monotonic(), cpu_s(node.process.pid), [cpu_s(sim.pid) for sim in sims]
            time.sleep(arguments.seconds)
            elapsed = time.monotonic() - start
            node_s = cpu_s(node.process.pid) - node_s
            sims_s = sum(cpu_s(sim.pid) for sim in sims) - sum(sims_s)
            time.sleep(1.5)
            report(arguments, peer, joints, before, elapsed)
            print(
                f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores; "
                f"node {100 * node_s / elapsed:.0f} % of a core, virtual boards {100 * sims_s / elapsed:.0f} %"
            )
    finally:
        for sim in sims:
            sim.terminate()
            sim.wait(timeout=30)


def report(arguments, peer, joints, before, elapsed):
    for bus in range(arguments.buses):
        name = f"/pneudrive: bus{bus}"
        then, now = before[name], peer.diagnostics[name][2]
        change = {key: float(now[key]) - float(then[key]) for key in ("exchanges", "lost", "missed ticks")}
        dropped = sum(float(now[key]) for key in ("states refused by DDS", "states dropped before DDS"))
        print(
            f"bus{bus}: {float(now['rate since start (Hz)']):.0f} Hz, cycle p99 {now['cycle time p99 (us)']} us, "
            f"{change['exchanges']:.0f} exchanges, {change['lost']:.0f} lost, {change['missed ticks']:.0f} missed ticks, "
            f"{dropped:.0f} states not published"
        )
    if not joints:
        return
    latencies = 1e6 * np.concatenate([joint.latencies_s for joint in joints])
    received = sum(len(joint.states) for joint in joints)
    print(
        f"one rclpy subscriber of {len(joints)} joints: {received / elapsed:.0f} states/s, measurement to callback "
        f"p50 {np.percentile(latencies, 50):.0f} us, p99 {np.percentile(latencies, 99):.0f} us"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--buses", type=int, default=4)
    parser.add_argument("--boards", type=int, default=4)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--heard", type=int, default=4, help="joints that rclpy subscribes to; it is slower than the node")
    parser.add_argument("--node", default="", help="more arguments for pneudrive-ros")
    parser.add_argument("--sim", default="", help="more arguments for pneudrive-sim")
    os.environ.setdefault("ROS_DOMAIN_ID", "88")
    measure(parser.parse_args())
