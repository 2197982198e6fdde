"""A UR5's cell: ros2 launch examples/ur5_cell/cell.launch.py [namespace:=...] [rviz:=true].

The joints come from joint_state_publisher and robot_state_publisher with `player:=false`, or where
a robot's driver takes the place of the first; without them from this package's own pose_player.
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
PUBLISHERS = ('robot_state_publisher', 'joint_state_publisher')


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
    # /tf has no namespace by itself, and two cells have one TF tree each.
    rules = [('/tf', 'tf'), ('/tf_static', 'tf_static')]
    common = {'namespace': LaunchConfiguration('namespace'), 'remappings': rules}
    monitor = [
        sys.executable,
        str(HERE / 'stop_monitor.py'),
        '--ros-args',
        '--params-file',
        params,
    ]
    for name, target in [('__ns', f'/{given["namespace"].strip("/")}'), *rules]:
        monitor += ['-r', f'{name}:={target}']
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
    if given['player'] == 'true' or not all(map(installed, PUBLISHERS)):
        motion = {'scene_file': scene, 'trajectory_file': str(HERE / 'motion.yaml'), 'tf': True}
        processes.append(
            Node(
                package='drake_geom_ros',
                executable='pose_player',
                parameters=[motion],
                **common,
            )
        )
    else:
        (robot,) = read_scene(scene).robots
        description = {'robot_description': robot.urdf.read_text()}
        for package in PUBLISHERS:
            processes.append(
                Node(package=package, executable=package, parameters=[description], **common)
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
