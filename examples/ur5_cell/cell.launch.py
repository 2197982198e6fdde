"""A UR5's cell: ros2 launch examples/ur5_cell/cell.launch.py [namespace:=...] [rviz:=true].

The joints come from joint_state_publisher with `player:=false`, or from a robot's driver in its
place; without it from this package's own pose_player. Nobody has to send TF.
"""

import sys
from pathlib import Path

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from drake_geom_ros.scene_files import read_scene

HERE = Path(__file__).resolve().parent
PUBLISHER = 'joint_state_publisher'


def installed(package: str) -> bool:
    """Return whether a distribution has a package."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        return False
    return True


def start(context: LaunchContext) -> list:
    """Return the processes of the cell."""
    given = context.launch_configurations
    params, scene = str(HERE / 'cell_params.yaml'), str(HERE / 'cell.yaml')
    common = {'namespace': LaunchConfiguration('namespace')}
    monitor = [
        sys.executable,
        str(HERE / 'stop_monitor.py'),
        '--ros-args',
        '--params-file',
        params,
        '-r',
        f'__ns:=/{given["namespace"].strip("/")}',
    ]
    processes = [
        Node(
            package='drake_geom_ros',
            executable='scene_graph_node',
            name='scene_graph',
            parameters=[params, {'scene_file': scene}],
            output='screen',
            **common,
        ),
        ExecuteProcess(cmd=monitor, output='screen'),
    ]
    if given['player'] == 'true' or not installed(PUBLISHER):
        motion = {'scene_file': scene, 'trajectory_file': str(HERE / 'motion.yaml')}
        processes.append(
            Node(
                package='drake_geom_ros',
                executable='pose_player',
                parameters=[{**motion, 'joint_states': True}],
                **common,
            )
        )
    else:
        (robot,) = read_scene(scene).robots
        description = {'robot_description': robot.urdf.read_text()}
        processes.append(
            Node(package=PUBLISHER, executable=PUBLISHER, parameters=[description], **common)
        )
    if given['rviz'] == 'true':
        processes.append(
            Node(
                package='rviz2',
                executable='rviz2',
                arguments=['-d', str(HERE / 'cell.rviz')],
                **common,  # the topics of cell.rviz are in the namespace
            )
        )
    return processes


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and the processes."""
    arguments = {
        'namespace': ('', 'Namespace of the cell: one for each of several.'),
        'player': ('true', 'Play motion.yaml; false: the joints come from elsewhere.'),
        'rviz': ('false', 'Show the cell in RViz.'),
    }
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=text)
                for name, (default, text) in arguments.items()
            ),
            OpaqueFunction(function=start),
        ]
    )
