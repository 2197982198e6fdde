"""The node's parameters: declared with descriptors, checked, read as one frozen record."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from drake_geom_ros.geometry import ACCURACY_LEVELS


@dataclass(frozen=True)
class NodeParameters:
    """The values of all parameters at one moment."""

    scene_file: str = ''
    world_frame: str = 'world'
    rate: float = 0.0
    max_distance: float = 0.1
    accuracy: str = 'exact'
    stale_after: float = 1.0
    use_tf: bool = False
    publish_markers: bool = False
    autostart: bool = True


_NOT_YET = ' Not available yet: only false is accepted.'
_TEXTS = {
    'scene_file': 'Scene to load when the node is configured (YAML or URDF); empty: an empty one.',
    'world_frame': 'Name of the world frame in headers.',
    'rate': 'Cycles per second [Hz]; 0: one cycle for each pose message.',
    'max_distance': 'Pairs farther apart than this are left out of ~/signed_distances [m].',
    'accuracy': f'Accuracy level of the queries: {", ".join(ACCURACY_LEVELS)}.',
    'stale_after': 'Age at which the pose of a frame counts as stale [s].',
    'use_tf': 'Take frame poses from /tf and /tf_static.' + _NOT_YET,
    'publish_markers': 'Publish ~/markers for RViz.' + _NOT_YET,
    'autostart': 'Configure and activate by itself at start.',
}
_READ_ONLY = {'scene_file', 'world_frame', 'autostart'}
_RANGES = {'rate': (0.0, 10000.0), 'max_distance': (0.0, math.inf), 'stale_after': (0.0, math.inf)}


class ParameterRefusedError(ValueError):
    """A start value that cannot be."""


class ParameterStore:
    """Declares the parameters on a node and keeps their latest values."""

    def __init__(self, node: Node, on_change) -> None:
        """Declare; ``on_change(old, new)`` is called after a change was accepted."""
        self._on_change = on_change
        values = {}
        for entry in fields(NodeParameters):
            descriptor = ParameterDescriptor(
                description=_TEXTS[entry.name], read_only=entry.name in _READ_ONLY
            )
            if entry.name in _RANGES:
                low, high = _RANGES[entry.name]
                descriptor.floating_point_range = [
                    FloatingPointRange(from_value=low, to_value=high)
                ]
            values[entry.name] = node.declare_parameter(
                entry.name, entry.default, descriptor
            ).value
        self.values = NodeParameters(**values)
        if reason := _refusal(self.values):
            raise ParameterRefusedError(reason)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._take)

    def _proposal(self, parameters: list[Parameter]) -> NodeParameters:
        names = {entry.name for entry in fields(NodeParameters)}
        return replace(self.values, **{p.name: p.value for p in parameters if p.name in names})

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        reason = _refusal(self._proposal(parameters))
        return SetParametersResult(successful=not reason, reason=reason)

    def _take(self, parameters: list[Parameter]) -> None:
        old, self.values = self.values, self._proposal(parameters)
        if self.values != old:
            self._on_change(old, self.values)


def _refusal(values: NodeParameters) -> str:
    """Return why the values cannot be, or an empty text."""
    if values.accuracy not in ACCURACY_LEVELS:
        allowed = ', '.join(ACCURACY_LEVELS)
        return f'accuracy is {values.accuracy!r}; it must be one of {allowed}'
    for name, (low, high) in _RANGES.items():
        value = getattr(values, name)
        if not low <= value <= high:
            return f'{name} is {value}; it must lie in [{low}, {high}]'
    for name in ('use_tf', 'publish_markers'):
        if getattr(values, name):
            return f'{name} is true; this version of the node does not offer it yet'
    return ''
