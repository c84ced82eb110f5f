"""The node of one robot: `ros2 launch pneudrive_ros pneudrive.launch.py namespace:=arm params:=arm.yaml`."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def generate_launch_description():
    params = PathJoinSubstitution([FindPackageShare("pneudrive_ros"), "config", "pneudrive.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("namespace", default_value="", description="Namespace of the node"),
            DeclareLaunchArgument("params", default_value=params, description="File of parameters"),
            Node(
                package="pneudrive_ros",
                executable="pneudrive-ros",
                name="pneudrive",
                namespace=LaunchConfiguration("namespace"),
                parameters=[LaunchConfiguration("params")],
                # What another node calls the pressures of joint 0.
                remappings=[("~/joint_0/pressure_state", "shoulder/pressure")],
                output="screen",
            ),
        ]
    )
