"""The node's parameters: declared with descriptors, checked, read as one frozen record."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from drake_geom_ros.geometry import ACCURACY_LEVELS
from drake_geom_ros.ros.file_access import ALL_PACKAGES


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
    robot_description_topic: str = 'robot_description'
    publish_markers: bool = False
    marker_rate: float = 10.0
    mesh_roots: tuple[str, ...] = (ALL_PACKAGES, '.')
    replay_dir: str = ''
    replay_limit: int = 20
    autostart: bool = True


_LIVE = ' May change while the node runs.'
_TEXTS = {
    'scene_file': 'Scene to load when the node is configured (YAML or URDF); empty: an empty one.',
    'world_frame': 'Name of the world frame in headers and poses.',
    'rate': 'Cycles per second [Hz]; 0: one cycle for each pose message.' + _LIVE,
    'max_distance': 'Pairs farther apart are left out of ~/signed_distances [m].' + _LIVE,
    'accuracy': f'Accuracy level of the queries: {", ".join(ACCURACY_LEVELS)}.' + _LIVE,
    'time_budget': (
        'Limit [s] of the narrow phase of a cycle, nearest pairs first, the rest by certified '
        'bounds; 0: none.' + _LIVE
    ),
    'stale_after': 'Age at which the pose of a frame counts as stale [s].' + _LIVE,
    'point_threshold': (
        'Geometries farther from a point of ~/query_points are left out of ~/point_distances [m].'
        + _LIVE
    ),
    'use_tf': 'Take frame poses from /tf and /tf_static too; needs tf2_msgs.',
    'robot_description_topic': (
        'Topic (std_msgs/String, latched) whose URDF becomes a source of the scene; empty: none.'
    ),
    'publish_markers': 'Publish ~/markers for RViz, when somebody subscribes.' + _LIVE,
    'marker_rate': 'Messages per second on ~/markers [Hz].',
    'mesh_roots': (
        'Folders in which files may be opened for a service or a robot description; package:// '
        "stands for all packages' share folders, and the folder of scene_file always counts."
        + _LIVE
    ),
    'replay_dir': (
        'Folder for files of results that break a promise, one for each pair of shape types, for '
        '`python -m drake_geom_ros replay FILE`; empty: none.' + _LIVE
    ),
    'replay_limit': 'Replay files in that folder at which no more are written.' + _LIVE,
    'autostart': 'Configure and activate by itself at start.',
}
_RANGES = {
    'rate': (0.0, 10000.0),
    'max_distance': (0.0, math.inf),
    'time_budget': (0.0, math.inf),
    'stale_after': (0.0, math.inf),
    'point_threshold': (0.0, math.inf),
    'marker_rate': (0.1, 100.0),
    'replay_limit': (0, 10000),
}


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
        for entry in fields(NodeParameters):
            text = _TEXTS[entry.name]
            descriptor = ParameterDescriptor(description=text, read_only=not text.endswith(_LIVE))
            if entry.name in _RANGES:
                low, high = _RANGES[entry.name]
                if isinstance(entry.default, int):
                    descriptor.integer_range = [IntegerRange(from_value=low, to_value=high)]
                else:
                    descriptor.floating_point_range = [
                        FloatingPointRange(from_value=low, to_value=high)
                    ]
            default = list(entry.default) if entry.name == 'mesh_roots' else entry.default
            values[entry.name] = _plain(node.declare_parameter(entry.name, default, descriptor))
        self.values = NodeParameters(**values)
        if reason := _refusal(self.values):
            raise ParameterRefusedError(reason)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._take)

    def _proposal(self, parameters: list[Parameter]) -> NodeParameters:
        names = {entry.name for entry in fields(NodeParameters)}
        return replace(self.values, **{p.name: _plain(p) for p in parameters if p.name in names})

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        reason = _refusal(self._proposal(parameters))
        return SetParametersResult(successful=not reason, reason=reason)

    def _take(self, parameters: list[Parameter]) -> None:
        old, self.values = self.values, self._proposal(parameters)
        if self.values != old:
            self._on_change(old, self.values)


def _plain(parameter: Parameter) -> object:
    """Return the value of a parameter; an array as a tuple."""
    value = parameter.value
    return tuple(value) if isinstance(value, (list, tuple)) else value


def _refusal(values: NodeParameters) -> str:
    """Return why the values cannot be, or an empty text."""
    if values.accuracy not in ACCURACY_LEVELS:
        allowed = ', '.join(ACCURACY_LEVELS)
        return f'accuracy is {values.accuracy!r}; it must be one of {allowed}'
    for name, (low, high) in _RANGES.items():
        value = getattr(values, name)
        if not low <= value <= high:
            return f'{name} is {value}; it must lie in [{low}, {high}]'
    if not values.world_frame or values.world_frame.startswith('/'):
        return f'world_frame is {values.world_frame!r}; it must be a frame name without leading /'
    if values.use_tf and importlib.util.find_spec('tf2_msgs') is None:
        return (
            'use_tf is true, and the package tf2_msgs cannot be imported; install it (it is part '
            'of every ROS distribution) or send poses on ~/frame_poses'
        )
    return ''
