"""The scene graph node; `ros2 launch drake_geom_ros scene_graph.launch.py -s` lists the arguments.

An argument that is left empty is not passed on: the parameter file counts then, or the node's own
default. The node is a managed one that configures and activates itself, unless autostart is false.
"""

import os
import typing
from dataclasses import fields

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, LogInfo, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.ros.parameters import TEXTS, NodeParameters
from drake_geom_ros.ros.recorder.recorded_topics import topics_of

TEXT_LIST = typing.List[str]  # noqa: UP006 - launch does not know list[str]
# Arguments that are parameters of the node, all of them: type, description.
PARAMETERS = {
    entry.name: (TEXT_LIST if isinstance(entry.default, tuple) else type(entry.default), text)
    for entry in fields(NodeParameters)
    for text in [TEXTS[entry.name]]
} | {'use_sim_time': (bool, 'Take the time from /clock.')}


ARGUMENTS = {
    'name': ('scene_graph', 'Name of the node.'),
    'namespace': ('', 'Namespace of the node: one for each of several scenes.'),
    'params_file': ('', 'Parameter file, such as config/scene_graph.yaml.'),
    'own_tf': ('false', 'true: /tf and /tf_static are those of the namespace.'),
    'record': ('false', 'true: record what `report` takes, by `ros2 bag record` (MCAP).'),
    'log_level': ('info', 'debug, info, warn, error or fatal.'),
}
OWN_TF = [('/tf', 'tf'), ('/tf_static', 'tf_static')]
# Clients that are killed leave mutexes in shared memory locked: a node waits for them for ever.
TRANSPORTS = {'FASTDDS_BUILTIN_TRANSPORTS': 'UDPv4'}


def start_node(context: LaunchContext) -> list:
    """Return the node with the parameters that were given, and what is wrong with these."""
    values = {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, (kind, _) in PARAMETERS.items()
        if context.launch_configurations[name]
    }
    file = context.launch_configurations['params_file']
    # What includes this file has arguments of its own, so only what is like one of these is told.
    known = [*ARGUMENTS, *PARAMETERS]
    told = [
        LogInfo(msg=f'the launch argument {name!r} does not exist{hint}')
        for name in context.launch_configurations
        if name not in known and (hint := nearest(name, known))
    ]
    node = LifecycleNode(
        package='drake_geom_ros',
        executable='scene_graph_node',
        name=LaunchConfiguration('name'),
        namespace=LaunchConfiguration('namespace'),
        parameters=[*filter(None, [file, values])],
        ros_arguments=['--log-level', LaunchConfiguration('log_level')],
        remappings=OWN_TF if context.launch_configurations['own_tf'] == 'true' else [],
        output='screen',
        additional_env={k: os.environ.get(k, value) for k, value in TRANSPORTS.items()},
    )
    recorder = [recording(context)] if context.launch_configurations['record'] == 'true' else []
    return [*told, *recorder, node]


def recording(context: LaunchContext) -> ExecuteProcess:
    """Return what records the node's run."""
    given = context.launch_configurations
    space = given['namespace'].strip('/')
    names = 'joint_states', 'robot_description', 'robot_description_semantic'
    topics = topics_of(
        f'{f"/{space}" if space else ""}/{given["name"]}',
        own_tf=given['own_tf'] == 'true',
        **{name: given.get(f'{name}_topic') or '' for name in names},
    )
    command = ['ros2', 'bag', 'record', '--storage', 'mcap', *topics]
    return ExecuteProcess(cmd=command, output='screen')


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and the node."""
    arguments = {
        **ARGUMENTS,
        **{name: ('', text) for name, (_, text) in PARAMETERS.items()},
    }
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=text)
                for name, (default, text) in arguments.items()
            ),
            OpaqueFunction(function=start_node),
        ]
    )
