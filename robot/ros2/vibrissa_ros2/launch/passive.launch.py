"""The bridge of a robot whose topics exist already: `ros2 launch vibrissa_ros2 passive.launch.py namespace:=crawler pressures:=gauge`.

The agent runs as a service, and so as another user than the nodes: its socket would refuse them. Its configuration has in its
section [driver] `listen = "127.0.0.1:7411"` and `token_file = "driver_token"`, and `air_control = "NONE"` if the mapping has no
setpoints. docs/ros2.md describes the token and the mapping.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("namespace", default_value="vibrissa"),
        # "gauge" or "absolute", as the nodes publish them. There is no default: a mistake is 0.1 MPa.
        DeclareLaunchArgument("pressures", choices=["gauge", "absolute"]),
        DeclareLaunchArgument("mapping", default_value="/etc/vibrissa/mapping.yaml"),
        DeclareLaunchArgument("agent", default_value="tcp:127.0.0.1:7411"),
        DeclareLaunchArgument("agent_token_file", default_value="/etc/vibrissa/ros_token"),
        Node(
            package="vibrissa_ros2",
            executable="vibrissa-ros2",
            name="vibrissa",
            namespace=LaunchConfiguration("namespace"),
            parameters=[{
                "pressures": LaunchConfiguration("pressures"),
                "robot": LaunchConfiguration("namespace"),
                "agent": LaunchConfiguration("agent"),
                "agent_token_file": LaunchConfiguration("agent_token_file"),
                "mapping": LaunchConfiguration("mapping"),
            }],
            respawn=True,
            respawn_delay=2.0,
        ),
    ])
