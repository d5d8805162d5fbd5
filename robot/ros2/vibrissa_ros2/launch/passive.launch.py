"""The bridge of a robot whose topics exist already: `ros2 launch vibrissa_ros2 passive.launch.py namespace:=crawler pressures:=gauge`.

The agent runs as a service. Its configuration has `unix = "/run/vibrissa/driver.sock"` in its section [driver], and
`air_control = "NONE"` if the mapping has no setpoints. The mapping is described in docs/ros2.md.
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
        DeclareLaunchArgument("agent", default_value="unix:/run/vibrissa/driver.sock"),
        Node(
            package="vibrissa_ros2",
            executable="vibrissa-ros2",
            name="vibrissa",
            namespace=LaunchConfiguration("namespace"),
            parameters=[{
                "pressures": LaunchConfiguration("pressures"),
                "robot": LaunchConfiguration("namespace"),
                "agent": LaunchConfiguration("agent"),
                "mapping": LaunchConfiguration("mapping"),
            }],
            respawn=True,
            respawn_delay=2.0,
        ),
    ])
