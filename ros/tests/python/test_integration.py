"""What launch files and ROS's own tools do with the node: parameter files, descriptions, /rosout, standard messages."""

import re
import time
import xml.etree.ElementTree as ElementTree

from conftest import ROOT
from peers import RELIABLE, Joint, Node, Peer, seconds, until
from rcl_interfaces.msg import Log, Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParametersAtomically
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import FluidPressure, JointState

# After which a question is asked again.
REPEAT_S = 10.0
EXAMPLE = ROOT / "ros" / "config" / "pneudrive.yaml"


def call(peer, kind, service, request):
    """Calls a service of the node and returns the answer.

    A node that has not yet discovered the client answers into the void, as ROS 2 services may: so the request is repeated.
    """
    client = peer.node.create_client(kind, service)
    until(service, client.service_is_ready)
    asked = [client.call_async(request)]
    began = time.monotonic()

    def answered():
        if time.monotonic() > began + REPEAT_S * len(asked):
            asked.append(client.call_async(request))
        return next((future for future in asked if future.done()), None)

    return until(f"an answer of {service}", answered).result()


def number(value):
    return ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)


def test_a_launch_file_configures_it(tmp_path):
    """As `launch_ros` starts a node: name and namespace as remapping rules, a file of parameters, and remappings of topics."""
    own = tmp_path / "launch_params"
    own.write_text("/arm/air:\n  ros__parameters:\n    publish_rate_hz: 50.0\n    first_joint: 3\n")
    line = ["--ros-args", "-r", "__node:=air", "-r", "__ns:=/arm"]
    line += ["--params-file", str(own), "-r", "~/joint_3/pressure_state:=shoulder/pressure"]
    with Node(*line) as node, Peer() as peer:
        states = []
        peer.node.create_subscription(JointState, "/arm/shoulder/pressure", states.append, RELIABLE)
        until("states under their new name", lambda: states)
        assert "/arm/air: joint_3 to joint_3" in node.said
        request = GetParameters.Request(names=["publish_rate_hz", "first_joint"])
        values = call(peer, GetParameters, "/arm/air/get_parameters", request).values
        assert (values[0].double_value, values[1].integer_value) == (50.0, 3)


def test_the_example_of_a_parameter_file_works():
    with Node("--ros-args", "--params-file", EXAMPLE) as node, Peer() as peer:
        assert "joint_0 to joint_1" in node.said
        request = GetParameters.Request(names=["port", "devices", "max_kpa", "publish_rate_hz"])
        port, devices, max_kpa, rate = call(peer, GetParameters, "/pneudrive/get_parameters", request).values
        assert list(port.string_array_value) == ["sim"] and list(devices.integer_array_value) == [2]
        assert (max_kpa.double_value, rate.double_value) == (300.0, 200.0)


def test_what_was_dumped_can_be_given_back(tmp_path):
    """`ros2 param dump` writes every parameter, also those that were not given."""
    with Node() as _, Peer() as peer:
        names = call(peer, ListParameters, "/pneudrive/list_parameters", ListParameters.Request()).result.names
        assert "rate_hz" in names and "use_sim_time" in names
        values = call(peer, GetParameters, "/pneudrive/get_parameters", GetParameters.Request(names=names)).values
    lines = ["/pneudrive:", "  ros__parameters:"]
    lines += [f"    {name}: {written(value)}" for name, value in zip(names, values) if name != "port"]
    dumped = tmp_path / "dumped.yaml"
    dumped.write_text("\n".join(lines) + "\n")
    with Node("--ros-args", "--params-file", dumped) as _, Peer() as peer:
        again = call(peer, GetParameters, "/pneudrive/get_parameters", GetParameters.Request(names=names)).values
    assert [written(value) for value in again] == [written(value) for value in values]


def written(value):
    """A parameter's value as the YAML that `ros2 param dump` makes of it."""
    match value.type:
        case ParameterType.PARAMETER_BOOL:
            return str(value.bool_value).lower()
        case ParameterType.PARAMETER_INTEGER:
            return str(value.integer_value)
        case ParameterType.PARAMETER_DOUBLE:
            return ".inf" if value.double_value == float("inf") else repr(value.double_value)
        case ParameterType.PARAMETER_STRING:
            return f"'{value.string_value}'"
        case ParameterType.PARAMETER_INTEGER_ARRAY:
            return str(list(value.integer_array_value))
        case ParameterType.PARAMETER_STRING_ARRAY:
            return str(list(value.string_array_value))
    raise AssertionError(value)


def test_parameters_are_described():
    with Node(), Peer() as peer:
        names = ["command_timeout_s", "port", "first_joint", "no_such"]
        request = DescribeParameters.Request(names=names)
        timeout, port, joint, unknown = call(
            peer, DescribeParameters, "/pneudrive/describe_parameters", request
        ).descriptors
        assert "Command 0 kPa to channels" in timeout.description and not timeout.read_only
        assert (timeout.floating_point_range[0].from_value, timeout.floating_point_range[0].to_value) == (0.0, 1e6)
        assert port.read_only and port.type == ParameterType.PARAMETER_STRING_ARRAY
        assert (joint.integer_range[0].from_value, joint.integer_range[0].to_value) == (0, 60_000)
        assert unknown.name == "no_such" and unknown.type == ParameterType.PARAMETER_NOT_SET


def test_parameters_are_set_together_or_not_at_all():
    with Node(), Peer() as peer:

        def set_them(**values):
            parameters = [Parameter(name=name, value=number(value)) for name, value in values.items()]
            request = SetParametersAtomically.Request(parameters=parameters)
            return call(peer, SetParametersAtomically, "/pneudrive/set_parameters_atomically", request).result

        def rate():
            request = GetParameters.Request(names=["publish_rate_hz"])
            return call(peer, GetParameters, "/pneudrive/get_parameters", request).values[0].double_value

        refused = set_them(publish_rate_hz=77.0, watchdog_s=5.0)
        assert not refused.successful and "watchdog_s cannot change" in refused.reason
        assert rate() == 1000.0
        assert set_them(publish_rate_hz=77.0, command_timeout_s=2.0).successful
        assert rate() == 77.0


def test_what_it_says_is_on_rosout():
    """A late subscriber gets it too, as from any other node."""
    with Node() as node, Peer() as peer:
        logs = []
        kept = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        peer.node.create_subscription(Log, "/rosout", lambda log: logs.append(log), kept)
        until("what was said at the start", lambda: any("DDS domain" in log.msg for log in logs))
        joint = Joint(peer)
        joint.wait_until_connected()
        # The node may have found the topic later than the topic has found the node.
        until("the warning", lambda: joint.command(1, 2, 3) or any("command refused" in log.msg for log in logs))
        own = [log for log in logs if log.name == "pneudrive"]
        refused = next(log for log in own if "command refused" in log.msg)
        assert refused.level == 30 and refused.file.endswith(".rs") and refused.line > 0
        assert abs(seconds(refused.stamp) - seconds(joint.states[-1].header.stamp)) < 60
        # Everything on standard error of the node's own, in order.
        said = re.findall(r"^(?:info|warn): (.*)$", node.said, re.MULTILINE)
        assert [log.msg for log in own][: len(said)] == said[: len(own)]


def test_chambers_as_fluid_pressures():
    """sensor_msgs/FluidPressure in Pa, a topic for each chamber."""
    with Node("--message-type", "fluid_pressure", "--command-timeout-s", 30) as node, Peer() as peer:
        states = {}
        prefix = "/pneudrive/joint_0/chamber_"
        for k in range(4):
            take = lambda message, k=k: states.__setitem__(k, message)  # noqa: E731
            peer.node.create_subscription(FluidPressure, f"{prefix}{k}/pressure_state", take, RELIABLE)
        publishers = [
            peer.node.create_publisher(FluidPressure, f"{prefix}{k}/pressure_command", RELIABLE) for k in range(4)
        ]
        until("all four", lambda: len(states) == 4)
        assert [states[k].header.frame_id for k in range(4)] == [f"joint_0_chamber_{k}_gauge" for k in range(4)]
        assert all(abs(states[k].fluid_pressure) < 6_000 for k in range(4)), "gauge: about 0 when vented"
        until("subscribers", lambda: all(one.get_subscription_count() for one in publishers))

        def there():
            for k in (1, 3):
                publishers[k].publish(FluidPressure(fluid_pressure=100_000.0))
            return all(abs(states[k].fluid_pressure - 100_000) < 6_000 for k in (1, 3))

        until("100 kPa in two chambers", there)
        assert all(abs(states[k].fluid_pressure) < 6_000 for k in (0, 2)), "the others were not commanded"
        assert node.end() == 0, node.said


def test_the_package_names_what_it_uses():
    """package.xml lists the packages whose messages the node speaks, and the version of the workspace."""
    root = ElementTree.parse(ROOT / "ros" / "package.xml").getroot()
    needs = {element.text for element in root.iter("exec_depend")}
    assert {"sensor_msgs", "diagnostic_msgs", "rcl_interfaces", "std_srvs", "launch_ros"} <= needs
    version = re.search(r'^version = "(.*)"$', (ROOT / "Cargo.toml").read_text(), re.MULTILINE)[1]
    assert root.findtext("version") == version
    # Whoever parses it as ROS does.
    from catkin_pkg.package import parse_package

    assert parse_package(ROOT / "ros" / "package.xml").get_build_type() == "ament_cmake"


def test_the_launch_file_names_what_is_there():
    """Its names are in no checker's reach without ROS's `launch`: the program, the parameter file, and that it is Python."""
    text = (ROOT / "ros" / "launch" / "pneudrive.launch.py").read_text()
    compile(text, "pneudrive.launch.py", "exec")
    assert 'executable="pneudrive-ros"' in text and "pneudrive-ros" in (ROOT / "ros" / "CMakeLists.txt").read_text()
    assert '"config", "pneudrive.yaml"' in text and EXAMPLE.exists()
