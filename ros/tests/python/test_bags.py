"""Recordings of `pneudrive-host`, read by the tools that others read ROS bags with, and by `pneudrive-model`."""

import json
import math
import pathlib
import subprocess
import sys
import time

import pytest
from conftest import binary, compare
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader, ReaderError
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """Two boards, four seconds, one step; its folder."""
    folder = tmp_path_factory.mktemp("bag")
    steps = folder / "steps.csv"
    steps.write_text("t_s,b1_cmd2_kpa\n0,0\n2.2,150\n4,150\n")
    command = [binary("pneudrive-host"), "--port", "sim", "-n", "2", "--rate", "500", "--json"]
    command += ["--trajectory", steps, "--record", folder / "run.mcap"]
    done = subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True, timeout=120)
    rows = json.loads(done.stdout)["recording"]["rows"]
    assert rows > 100
    return folder, rows


def check_step(messages):
    """Channel 2 was commanded 150 kPa at the end, and has moved. How far depends on how fast the machine simulates."""
    rows = [dict(zip(message.name, message.effort)) for message in messages]
    assert rows[0]["b1_cmd2_kpa"] == 0
    assert rows[-1]["b1_cmd2_kpa"] == pytest.approx(150, abs=0.5)
    # A row without an answer has no pressure.
    pressures = [row["b1_p2_kpa"] for row in rows if not math.isnan(row["b1_p2_kpa"])]
    assert pressures[0] == pytest.approx(0, abs=6)
    assert 50 < max(pressures) < 200


@pytest.mark.parametrize("what", ["folder", "file"])
def test_rosbags_reads_every_message(bag, what):
    folder, rows = bag
    path = folder if what == "folder" else folder / "run.mcap"
    with Reader(path) as reader:
        topics = {connection.topic: connection for connection in reader.connections}
        of_boards = {f"/pneudrive/joint_{n}/pressure_{kind}" for n in (0, 1) for kind in ("state", "command")}
        assert set(topics) == of_boards | {"/pneudrive/events"}
        state = topics["/pneudrive/joint_1/pressure_state"]
        assert state.msgtype == "sensor_msgs/msg/JointState"
        assert state.msgcount == rows
        messages = [
            STORE.deserialize_cdr(raw, connection.msgtype)
            for connection, _, raw in reader.messages(connections=[state])
        ]
        assert len(messages) == rows
        total = sum(1 for _ in reader.messages())
        assert total == reader.message_count >= 2 * rows + 3
        assert 3.0 < reader.duration * 1e-9 < 60.0
    check_step(messages)
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages]
    assert all(a < b for a, b in zip(stamps, stamps[1:]))
    assert abs(stamps[-1] * 1e-9 - time.time()) < 3600, "stamps are of today"


def test_rosbags_reads_what_happened(bag):
    folder, _ = bag
    with Reader(folder) as reader:
        events = [connection for connection in reader.connections if connection.topic == "/pneudrive/events"]
        logs = [STORE.deserialize_cdr(raw, "rcl_interfaces/msg/Log") for _, _, raw in reader.messages(events)]
    assert logs[-1].function == "end" and logs[-1].msg.startswith("trajectory: ")
    assert all(log.level in (20, 30) and log.name == "pneudrive" for log in logs)


def test_a_bag_says_what_it_is(bag):
    folder, _ = bag
    with open(folder / "run.mcap", "rb") as file:
        records = [record.metadata for record in make_reader(file).iter_metadata() if record.name == "pneudrive"]
    assert len(records) == 1
    says = {key: json.loads(value) for key, value in records[0].items()}
    assert says["pneudrive_recording"] == 1 and says["port"] == "sim" and says["rate_hz"] == 500
    assert "--trajectory" in says["command_line"]


def test_rosbags_high_level_reader_needs_no_type_store(bag):
    folder, rows = bag
    with AnyReader([folder]) as reader:
        connections = [c for c in reader.connections if c.topic == "/pneudrive/joint_0/pressure_state"]
        messages = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(connections)]
    assert len(messages) == rows
    assert list(messages[0].name[:4]) == [f"b0_p{k}_kpa" for k in range(4)]


def test_mcap_ros2_support_reads_every_message(bag):
    folder, rows = bag
    with open(folder / "run.mcap", "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        states = [
            message
            for _, channel, _, message in reader.iter_decoded_messages()
            if channel.topic == "/pneudrive/joint_1/pressure_state"
        ]
        assert reader.get_summary().statistics.message_count >= 2 * rows
    assert len(states) == rows
    check_step(states)


def test_the_toolkit_reads_the_same(bag, tmp_path):
    folder, rows = bag
    assert f"{folder / 'run.mcap'}: {rows} rows" in compare(folder / "run.mcap", "b1c2", tmp_path)


def test_types_have_the_hashes_that_ros_gives_them(bag):
    """metadata.yaml and the file say which definition of each type it is; ROS installations have the hashes with their messages."""
    folder, _ = bag
    share = pathlib.Path(sys.prefix) / "share"
    expected = {}
    for kind in ("sensor_msgs/msg/JointState", "rcl_interfaces/msg/Log"):
        hashes = json.loads((share / f"{kind}.json").read_text())["type_hashes"]
        expected[kind] = next(one["hash_string"] for one in hashes if one["type_name"] == kind)
    with Reader(folder) as reader:
        assert {c.msgtype: c.digest for c in reader.connections} == expected
    with open(folder / "run.mcap", "rb") as file:
        summary = make_reader(file).get_summary()
    told = {summary.schemas[c.schema_id].name: c.metadata["topic_type_hash"] for c in summary.channels.values()}
    assert told == expected


@pytest.fixture
def killed(tmp_path):
    """A bag whose recorder was killed."""
    file = tmp_path / "run.mcap"
    command = [binary("pneudrive-host"), "--port", "sim", "--rate", "500", "--record", str(file)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as host:
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and (not file.exists() or file.stat().st_size < 20_000):
            time.sleep(0.05)
        host.kill()
    return file


def test_a_killed_recording_is_repaired(killed):
    with pytest.raises(ReaderError):
        Reader(killed.parent).open()
    done = subprocess.run([binary("pneudrive-model"), "repair", killed], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "run.mcap stops in the middle" in done.stdout
    whole = killed.parent / "run_repaired"
    for path in (whole, whole / "run.mcap"):
        with Reader(path) as reader:
            states = [c for c in reader.connections if c.topic == "/pneudrive/joint_0/pressure_state"]
            messages = [STORE.deserialize_cdr(raw, c.msgtype) for c, _, raw in reader.messages(states)]
            assert len(messages) == states[0].msgcount > 100
            assert f"{reader.message_count} messages" in done.stdout
    with open(whole / "run.mcap", "rb") as file:
        records = [record.name for record in make_reader(file).iter_metadata()]
    assert sorted(records) == ["pneudrive", "rosbag2"]
    again = subprocess.run([binary("pneudrive-model"), "repair", killed], capture_output=True, text=True, timeout=60)
    assert again.returncode == 1 and "run_repaired: cannot be written" in again.stderr


def test_a_killed_recording_is_read_as_far_as_it_goes(killed):
    count = 0
    with open(killed, "rb") as stream:
        messages = NonSeekingReader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages(
            log_time_order=False
        )
        try:
            for _, channel, _, message in messages:
                if channel.topic.endswith("/pressure_state"):
                    count += 1
                    assert not math.isnan(message.effort[-1])
        except Exception as error:  # the reader's word for the missing end depends on its version
            assert "EndOfFile" in type(error).__name__ or "end" in str(error).lower(), repr(error)
    assert count > 100
