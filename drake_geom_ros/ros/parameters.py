"""The node's parameters: declared with descriptors, checked, read as one frozen record."""

from __future__ import annotations

import array
import importlib.util
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import ACCURACY_LEVELS, ArgumentError, accuracy_of
from drake_geom_ros.live.conversions.file_access import ALL_PACKAGES, FileAccess
from drake_geom_ros.live.conversions.paddings import paddings_of
from drake_geom_ros.live.gates import gates_of_parameter
from drake_geom_ros.live.inputs.obstacle_refusals import refusal_of_obstacles
from drake_geom_ros.live.inputs.obstacle_sources import obstacle_sources_of
from drake_geom_ros.scene_files import robot_topics_of_text


@dataclass(frozen=True)
class NodeParameters:
    """The values of all parameters at one moment."""

    scene_file: str = ''
    world_frame: str = 'world'
    rate: float = 0.0
    max_distance: float = 0.1
    accuracy: str = 'exact'
    time_budget: float = 0.0
    stale_after: float = 1.0
    point_threshold: float = 0.1
    use_tf: bool = False
    use_joint_states: bool = False
    use_planning_scene: bool = False
    robot_description_topic: str = 'robot_description'
    robot_description_semantic_topic: str = 'robot_description_semantic'
    robot_descriptions: str = ''
    filter_self_collisions: bool = False
    frame_prefix: str = ''
    solid_meshes: tuple[str, ...] = ()
    paddings: tuple[str, ...] = ()
    publish_markers: bool = False
    marker_rate: float = 10.0
    mesh_roots: tuple[str, ...] = (ALL_PACKAGES, '.')
    package_roots: tuple[str, ...] = ()
    allow_writes: bool = True
    filters_per_owner: int = 1000
    replay_dir: str = ''
    replay_limit: int = 20
    cross_check: float = 0.0
    closing_speeds: bool = False
    contact_polygons: bool = False
    lcm_url: str = ''
    obstacles: tuple[str, ...] = ()
    obstacle_sources: str = ''
    gate: str = ''
    obstacle_resolution: float = 0.03
    obstacle_reach: float = 3.0
    obstacle_box: tuple[float, ...] = ()
    obstacle_self_filter: str = 'robots'
    obstacle_padding: float = 0.05
    obstacle_paddings: tuple[str, ...] = ()
    obstacle_noise: float = 0.01
    obstacle_least_points: int = 1
    obstacle_keep: float = 0.0
    obstacle_keep_hidden: float = math.inf
    obstacle_rays: bool = False
    obstacle_margin: float = 0.0
    tracked_markers: str = ''
    tracked_detections: str = ''
    tracked_lifetime: float = 1.0
    service_depth: int = 1000
    max_answer_size: float = 64.0
    watchdog: float = 60.0
    watchdog_exits: bool = False
    autostart: bool = True


QOS_OVERRIDES = 'qos_overrides.'
_LIVE = ' May change while the node runs.'
TEXTS = {
    'scene_file': 'Scene to load at configuration (YAML or URDF); empty: an empty scene.',
    'world_frame': 'Name of the world frame in headers and poses.',
    'rate': 'Cycles per second [Hz]; 0: one cycle for each pose message.' + _LIVE,
    'max_distance': 'Pairs farther apart are left out of ~/signed_distances [m].' + _LIVE,
    'accuracy': (
        f'Accuracy of the queries: {", ".join(ACCURACY_LEVELS)}, or a length [m] as text.' + _LIVE
    ),
    'time_budget': (
        'Limit [s] of the narrow phase of a cycle, nearest pairs first, the rest by certified '
        'bounds, and of its contact surfaces and those of a call, the rest with a reason; 0: '
        'none.' + _LIVE
    ),
    'stale_after': 'Age at which the pose of a frame counts as stale [s].' + _LIVE,
    'point_threshold': (
        'Geometries farther from a point of ~/query_points are left out of ~/point_distances [m].'
        + _LIVE
    ),
    'use_tf': 'Also take frame poses from /tf and /tf_static; needs tf2_msgs.',
    'use_joint_states': (
        'Pose the links of robots by the topic joint_states (sensor_msgs/JointState); a robot of '
        'a scene file that names a topic of its own is driven by that one anyhow.'
    ),
    'use_planning_scene': (
        "Take MoveIt's objects from /collision_object, /attached_collision_object and "
        '/planning_scene; needs moveit_msgs.'
    ),
    'robot_description_topic': (
        'Topic (std_msgs/String, latched) whose URDF becomes a source of the scene; empty: none.'
    ),
    'robot_description_semantic_topic': (
        'Topic (std_msgs/String, latched) of the SRDF of that robot, whose disabled pairs are '
        'left out; empty: none.'
    ),
    'robot_descriptions': (
        'Robots with topics of their own, in YAML: {left: {namespace: /left, pose: {position: '
        '[0, 1, 0]}}, right: {topic: /right/robot_description, joint_states: /right/joint_states,'
        ' frame_prefix: right/}}; empty: none.'
    ),
    'filter_self_collisions': (
        'Leave out all pairs of a robot with itself, of the robot of that topic and of a URDF.'
    ),
    'frame_prefix': (
        'What TF puts before the names of the links, of the robot of that topic and of a URDF, as '
        'the frame_prefix of its robot_state_publisher, slash included.'
    ),
    'solid_meshes': (
        'Links, or link/geometry, of the robot of that topic and of a URDF whose meshes are '
        'solids, with * and ?; other meshes count as their convex hulls.'
    ),
    'paddings': (
        'By how much [m] geometries of the robot of that topic and of a URDF are larger all '
        'around in proximity queries: PATTERN=METRES of links, or link/geometry, with * and ?; '
        'of those that fit, the last one counts.'
    ),
    'publish_markers': 'Publish ~/markers for RViz, while there is a subscriber.' + _LIVE,
    'marker_rate': 'Messages per second on ~/markers [Hz].',
    'mesh_roots': (
        'Folders in which files may be opened for a service or a robot description; package:// '
        "stands for all packages' share folders, and the folder of scene_file always counts."
        + _LIVE
    ),
    'package_roots': (
        'Folders that package:// searches first, each a package or a folder of packages; files in '
        'them may be opened like those in mesh_roots.' + _LIVE
    ),
    'allow_writes': (
        'Whether the node may write files: by ~/save_scene in the folders of mesh_roots, and in '
        'replay_dir, which must be empty if false.'
    ),
    'filters_per_owner': (
        'Transient filters that one owner may have; requests without an owner count as '
        'one owner.' + _LIVE
    ),
    'replay_dir': (
        'Folder for files of results that exceed their tolerance, one for each pair of shape '
        'types, for `python -m drake_geom_ros replay FILE`; empty: none.' + _LIVE
    ),
    'replay_limit': 'Number of replay files in that folder at which writing stops.' + _LIVE,
    'cross_check': (
        'Cycles per second [Hz] of which python-fcl, in its own process, checks a sample of the '
        'pairs; 0: none. Needs python-fcl.' + _LIVE
    ),
    'closing_speeds': (
        'Messages of pairs tell how fast these come together and when they meet, from '
        '~/frame_twists or from the last two stamped poses of a frame.'
    ),
    'contact_polygons': (
        'Messages on ~/contact_surfaces hold the polygons of the surfaces, too.' + _LIVE
    ),
    'lcm_url': (
        'LCM network, such as udpm://239.255.76.67:7667?ttl=0, on which the scene is shown to '
        "Drake's visualiser, marker_rate times a second; empty: none. Needs lcm."
    ),
    'obstacles': (
        'Maps of what sensors see: points (~/obstacles/points), depth (~/obstacles/depth/...), '
        'octomap (~/obstacles/octomap, needs octomap_msgs); empty: none.'
    ),
    'obstacle_sources': (
        'More sensors with a map each, as the key obstacle_sources of a scene file, in YAML: '
        '{front: {type: laser_scan, topic: /scan}}; empty: none.'
    ),
    'gate': (
        'Commands of velocity that go from one topic to another, scaled by the proximity rules '
        'about a robot, as the key gate of a scene file, in YAML: '
        '{in: cmd_vel_in, out: cmd_vel, robot: base}; empty: none.'
    ),
    'obstacle_resolution': 'Edge length of the cells that points and depths become [m].' + _LIVE,
    'obstacle_reach': (
        'Points farther from their sensor are left out, but the nearest one of all [m].' + _LIVE
    ),
    'obstacle_box': (
        'What is taken of the world, as x, y, z of the lowest and of the highest corner [m]; what '
        'lies beyond is left out, but the nearest point where all does; empty: no limit.' + _LIVE
    ),
    'obstacle_self_filter': (
        'Bodies on which points are left out: none, robots, or all that the scene knows (scene).'
        + _LIVE
    ),
    'obstacle_padding': 'How far from these bodies points are in no map, but near [m].' + _LIVE,
    'obstacle_paddings': (
        'obstacle_padding of single bodies: PATTERN=METRES of robots, links or geometries, with * '
        'and ?; of those that fit, the last one counts.' + _LIVE
    ),
    'obstacle_noise': 'How far from them points count as their own surface [m].' + _LIVE,
    'obstacle_least_points': 'Points that make a cell of a map occupied.' + _LIVE,
    'obstacle_keep': (
        'How long a cell is held since a point was last in it [s]; 0: until the next message.'
        + _LIVE
    ),
    'obstacle_keep_hidden': (
        'How long a cell that a body hides from its sensor stays since a point was last in it '
        '[s]; .inf: until the sensor can see it.' + _LIVE
    ),
    'obstacle_rays': (
        'Whether cells that are held go where a sensor looks through them to something behind.'
        + _LIVE
    ),
    'obstacle_margin': 'By how much each cell of a map is larger on every side [m].',
    'tracked_markers': (
        'Topic (visualization_msgs/MarkerArray) whose spheres, cubes, cylinders and line strips '
        'are tracked bodies, as those of ~/tracked_objects; empty: none.'
    ),
    'tracked_detections': (
        'Topic (vision_msgs/Detection3DArray) whose boxes are tracked bodies; empty: none. Needs '
        'vision_msgs.'
    ),
    'tracked_lifetime': (
        'Time [s] after which a body of detections is taken out that is not named again.'
    ),
    'service_depth': (
        'Largest number of waiting calls, and of answers being sent, of each service; further '
        'ones are lost.'
    ),
    'max_answer_size': (
        'Largest answer of a service, and largest images of a camera [MB]; what is larger is '
        'refused, with the reason.' + _LIVE
    ),
    'watchdog': (
        'Time [s] after which a callback that does not return, or a process that does nothing, is '
        'reported on standard error, with traces of all threads; 0: never.'
    ),
    'watchdog_exits': (
        'The watchdog also ends the process (exit code 1), so that a supervisor can restart it.'
    ),
    'autostart': 'Configure and activate automatically at start.',
}
_RANGES = {
    'rate': (0.0, 10000.0),
    'max_distance': (0.0, math.inf),
    'time_budget': (0.0, math.inf),
    'stale_after': (0.0, math.inf),
    'point_threshold': (0.0, math.inf),
    'marker_rate': (0.1, 100.0),
    'filters_per_owner': (1, 1000000),
    'replay_limit': (0, 10000),
    'cross_check': (0.0, 1000.0),
    'obstacle_resolution': (0.002, 10.0),
    'obstacle_reach': (0.01, 1000.0),
    'obstacle_padding': (0.0, 10.0),
    'obstacle_noise': (0.0, 10.0),
    'tracked_lifetime': (0.05, 3600.0),
    'obstacle_least_points': (1, 10000),
    'obstacle_keep': (0.0, math.inf),
    'obstacle_keep_hidden': (0.0, math.inf),
    'obstacle_margin': (0.0, 10.0),
    'service_depth': (1, 5000),
    'max_answer_size': (0.0, 2000.0),
    'watchdog': (0.0, 86400.0),
}
# Rarer than once in this time [s] is no sensible rate, and periods that do not fit into
# 64 bits of nanoseconds are far beyond; a rate of 0 means none.
_LONGEST_PERIOD = 1000.0
_LEAST_RATES = dict.fromkeys(('rate', 'cross_check'), 1.0 / _LONGEST_PERIOD)


_DEFAULTS = {entry.name: entry.default for entry in fields(NodeParameters)}
_KINDS = {
    bool: 'true or false',
    int: 'a whole number',
    float: 'a number',
    str: 'a text',
    tuple: 'a list of texts',
}
_OF_NUMBERS = ('obstacle_box',)  # lists of numbers


class ParameterRefusedError(ValueError):
    """A start value that cannot be."""


class ParameterStore:
    """Declares the parameters on a node and keeps their latest values."""

    def __init__(
        self, node: Node, on_change: Callable[[NodeParameters, NodeParameters], None]
    ) -> None:
        """Declare; ``on_change(old, new)`` is called after a change was accepted."""
        self._on_change = on_change
        values = {}
        for name, default in _DEFAULTS.items():
            text = TEXTS[name]
            descriptor = ParameterDescriptor(description=text, read_only=not text.endswith(_LIVE))
            if name in _RANGES:
                low, high = _RANGES[name]
                if isinstance(default, int):
                    descriptor.integer_range = [IntegerRange(from_value=low, to_value=high)]
                else:
                    descriptor.floating_point_range = [
                        FloatingPointRange(from_value=low, to_value=high)
                    ]
            values[name] = declared(node, name, default, descriptor)
        self.values = NodeParameters(**values)
        if reason := _refusal(self.values):
            raise ParameterRefusedError(reason)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._take)

    def _proposal(self, parameters: list[Parameter]) -> NodeParameters:
        parameters_of_table = (p for p in parameters if p.name in _DEFAULTS)
        plain = {p.name: _plain(p.name, p.value, _DEFAULTS[p.name]) for p in parameters_of_table}
        return replace(self.values, **plain)

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        reason = _refusal(self._proposal(parameters))
        return SetParametersResult(successful=not reason, reason=reason)

    def _take(self, parameters: list[Parameter]) -> None:
        old, self.values = self.values, self._proposal(parameters)
        if self.values != old:
            self._on_change(old, self.values)


def unknown_parameters(node: Node, prefix: str = '') -> list[str]:
    """Return in words which parameters were given to a node that has none of that name.

    Looked at are those that begin with ``prefix``, or, where it is empty, all but the overrides
    of QoS, which a node declares with its topics. rclpy takes what is unknown without a word.
    """
    texts = []
    for name in node._parameter_overrides:
        if node.has_parameter(name) or not name.startswith(prefix):
            continue
        if prefix or not name.startswith(QOS_OVERRIDES):
            names = node._parameters
            texts.append(f'the parameter {name!r} does not exist{nearest(name, names)}')
    return texts


def file_access(values: NodeParameters) -> FileAccess:
    """Return which files may be opened for others."""
    return FileAccess(
        values.mesh_roots, values.scene_file, values.package_roots, writes=values.allow_writes
    )


def declared(node: Node, name: str, default: object, descriptor: ParameterDescriptor) -> Any:
    """Declare a parameter and return its value, of the type of ``default``.

    A number may be given without its decimal point: ROS by itself would not take 1 for 1.0, nor
    an empty list for a list of texts. Raises ParameterRefusedError for what was given and cannot
    be.
    """
    start = list(default) if isinstance(default, tuple) else default
    # Values of any type are declared, and then refused with the types that are allowed.
    anything = ParameterDescriptor(dynamic_typing=True)
    set_value = node.declare_parameter(name, start, anything).value
    value = (
        ()
        if set_value is None and isinstance(default, tuple)
        else _plain(name, set_value, default)
    )
    ranges = [*descriptor.floating_point_range, *descriptor.integer_range]
    limits = [(each.from_value, each.to_value) for each in ranges]
    if reason := _wrong_type(name, value, default) or _out_of_range(name, value, limits):
        raise ParameterRefusedError(reason)
    descriptor.dynamic_typing = True
    node.set_descriptor(name, descriptor)
    return value


def _plain(name: str, value: Any, default: object) -> Any:
    """Return the value of a parameter: a list as a tuple, a whole number as a float."""
    if isinstance(default, tuple) and isinstance(value, list | tuple | array.array):
        of_numbers = name in _OF_NUMBERS
        return tuple(float(x) if of_numbers and type(x) is int else x for x in value)
    return float(value) if isinstance(default, float) and type(value) is int else value


def _wrong_type(name: str, value: Any, default: object) -> str:
    fits = type(value) is type(default)
    kind = _KINDS[type(default)]
    if isinstance(default, tuple):
        part, kind = (float, 'a list of numbers') if name in _OF_NUMBERS else (str, kind)
        fits = fits and all(isinstance(each, part) for each in value)
    return '' if fits else f'{name} is {value!r}; it must be {kind}'


def _out_of_range(name: str, value: Any, limits: Sequence[tuple[float, float]]) -> str:
    for low, high in limits:
        if not low <= value <= high:
            return f'{name} is {value}; it must lie in [{low}, {high}]'
    return ''


def _refusal(values: NodeParameters) -> str:
    """Return why the values cannot be, or an empty text."""
    for name, default in _DEFAULTS.items():
        value, limits = getattr(values, name), [_RANGES[name]] if name in _RANGES else []
        if reason := _wrong_type(name, value, default) or _out_of_range(name, value, limits):
            return reason
    for name, least in _LEAST_RATES.items():
        if 0.0 < (value := getattr(values, name)) < least:
            return f'{name} is {value}; it must be 0 or lie in [{least}, {_RANGES[name][1]}]'
    try:
        accuracy_of(values.accuracy)
    except ArgumentError as error:
        return str(error)
    if not values.world_frame or values.world_frame.startswith('/'):
        return f'world_frame is {values.world_frame!r}; it must be a frame name without leading /'
    if values.use_tf and importlib.util.find_spec('tf2_msgs') is None:
        return (
            'use_tf is true, and the package tf2_msgs cannot be imported; install it (it is part '
            'of every ROS distribution) or send poses on ~/frame_poses'
        )
    if values.use_planning_scene and importlib.util.find_spec('moveit_msgs') is None:
        return (
            'use_planning_scene is true, and the package moveit_msgs cannot be imported; install '
            'it (ros-$ROS_DISTRO-moveit-msgs), or register objects by register_geometry'
        )
    obstacle_values = values.obstacles, values.obstacle_self_filter, values.obstacle_box
    if reason := refusal_of_obstacles(*obstacle_values):
        return reason
    if values.replay_dir and not values.allow_writes:
        return f'replay_dir is {values.replay_dir!r}; it must be empty while allow_writes is false'
    try:
        paddings_of(values.paddings)
        paddings_of(values.obstacle_paddings, 'obstacle_paddings')
        obstacle_sources_of(values.obstacle_sources)
        gates_of_parameter(values.gate)
        if values.robot_descriptions.strip():
            robot_topics_of_text(values.robot_descriptions, 'robot_descriptions')
    except RuntimeError as error:
        return str(error)
    return _refusal_of_cross_check() if values.cross_check > 0.0 else ''


def _refusal_of_cross_check() -> str:
    """Return why no second opinion is available, or an empty text."""
    from drake_geom_ros.cross_check.asker import missing

    if not (names := missing()):
        return ''
    return (
        f'cross_check needs {" and ".join(names)}, which cannot be imported here: '
        f'pip install {" ".join(names)}'
    )
