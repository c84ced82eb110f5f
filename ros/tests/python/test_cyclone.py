"""The node and Cyclone DDS, the other DDS that ROS 2 installations use, by its own Python package: no ROS in between."""

import time
from dataclasses import dataclass

import pytest
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from peers import Node, until


@dataclass
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs.msg.dds_.Header_"):
    stamp: Time
    frame_id: str


@dataclass
class JointState(IdlStruct, typename="sensor_msgs.msg.dds_.JointState_"):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(100))
BEST_EFFORT = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(100))


@pytest.mark.parametrize("qos", [RELIABLE, BEST_EFFORT], ids=["reliable", "best effort"])
def test_both_directions(qos, domain):
    with Node() as node:
        participant = DomainParticipant(domain)
        states = DataReader(participant, Topic(participant, "rt/pneudrive/joint_0/pressure_state", JointState), qos=qos)
        commands = DataWriter(
            participant, Topic(participant, "rt/pneudrive/joint_0/pressure_command", JointState), qos=qos
        )

        def there():
            now = time.time()
            stamp = Time(sec=int(now), nanosec=int(now % 1 * 1e9))
            header = Header(stamp=stamp, frame_id="")
            commands.write(JointState(header=header, name=[], position=[], velocity=[], effort=[40.0, 60.0, 80.0, 100.0]))
            taken = [state for state in states.take(100) if isinstance(state, JointState)]
            return next((s for s in reversed(taken) if near(s.effort[:4], [40, 60, 80, 100])), None)

        state = until("the pressures that were commanded", there)
        assert state.name[:4] == [f"b0_p{k}_kpa" for k in range(4)]
        assert state.header.frame_id == "bus0" and abs(state.header.stamp.sec - time.time()) < 60
        assert node.end() == 0, node.said


def near(kpa, wanted):
    return all(abs(one - other) < 6 for one, other in zip(kpa, wanted))
