"""The scene graph node; `ros2 launch drake_geom_ros scene_graph.launch.py -s` lists the arguments.

An argument that is left empty is not passed on: the parameter file counts then, or the node's own
default. The node is a managed one that configures and activates itself, unless autostart is false.
"""

import os

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.parameter_descriptions import ParameterValue

# Arguments that are parameters of the node: type, description.
PARAMETERS = {
    'scene_file': (str, 'Scene to load (YAML or URDF), best with its full path.'),
    'rate': (float, 'Cycles per second [Hz]; 0: one cycle for each pose message.'),
    'max_distance': (float, 'Pairs farther apart are left out of ~/signed_distances [m].'),
    'accuracy': (str, 'Accuracy level of the queries: bound, fast, balanced or exact.'),
    'use_tf': (bool, 'Take frame poses from /tf and /tf_static too.'),
    'publish_markers': (bool, 'Publish ~/markers for RViz.'),
    'autostart': (bool, 'Configure and activate by itself at start.'),
    'use_sim_time': (bool, 'Take the time from /clock.'),
}


# Clients that are killed leave mutexes in shared memory locked: a node waits for them for ever.
TRANSPORTS = {'FASTDDS_BUILTIN_TRANSPORTS': 'UDPv4'}


def start_node(context: LaunchContext) -> list[LifecycleNode]:
    """Return the node with the parameters that were given."""
    values = {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, (kind, _) in PARAMETERS.items()
        if context.launch_configurations[name]
    }
    file = context.launch_configurations['params_file']
    node = LifecycleNode(
        package='drake_geom_ros',
        executable='scene_graph_node',
        name=LaunchConfiguration('name'),
        namespace=LaunchConfiguration('namespace'),
        parameters=[*filter(None, [file, values])],
        ros_arguments=['--log-level', LaunchConfiguration('log_level')],
        output='screen',
        additional_env={k: os.environ.get(k, value) for k, value in TRANSPORTS.items()},
    )
    return [node]


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and the node."""
    arguments = {
        'name': ('scene_graph', 'Name of the node.'),
        'namespace': ('', 'Namespace of the node: one for each of several scenes.'),
        'params_file': ('', 'Parameter file, such as config/scene_graph.yaml.'),
        'log_level': ('info', 'debug, info, warn, error or fatal.'),
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
