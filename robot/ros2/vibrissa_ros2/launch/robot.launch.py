"""The agent of a robot, and its ROS node: `ros2 launch vibrissa_ros2 robot.launch.py namespace:=crawler pressures:=gauge`.

Both run as the user of the launch file. The agent's configuration has `unix = "/run/vibrissa/driver.sock"` in its section [driver].
The folder must belong to that user: `sudo install -d -o $USER /run/vibrissa`, after each start of the machine.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("namespace", default_value="vibrissa"),
        # "gauge" or "absolute", as the nodes publish them. There is no default: a mistake is 0.1 MPa.
        DeclareLaunchArgument("pressures", choices=["gauge", "absolute"]),
        DeclareLaunchArgument("config", default_value="/etc/vibrissa/agent.toml"),
        ExecuteProcess(
            cmd=["vibrissa-robot", "--config", LaunchConfiguration("config")],
            respawn=True,
            respawn_delay=2.0,
        ),
        Node(
            package="vibrissa_ros2",
            executable="vibrissa-ros2",
            name="vibrissa",
            namespace=LaunchConfiguration("namespace"),
            parameters=[{
                "pressures": LaunchConfiguration("pressures"),
                "robot": LaunchConfiguration("namespace"),
                "agent": "unix:/run/vibrissa/driver.sock",
            }],
            remappings=[],
            respawn=True,
            respawn_delay=2.0,
        ),
    ])
