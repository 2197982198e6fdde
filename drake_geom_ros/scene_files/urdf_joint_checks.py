"""Checks of URDF joints for values that are invalid or that other readers interpret differently.

The references are urdfdom, the reader of ROS, and Drake. Values that both refuse are refused.
Values that only one accepts are refused if no interpretation makes sense, and otherwise reported
in a warning. ``jointed_links`` refuses mimics that follow no joint, or one another.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from drake_geom_ros.scene_files.link_tree import UrdfJoint
from drake_geom_ros.scene_files.xml_tree import local_name

TYPES = ('revolute', 'continuous', 'prismatic', 'fixed', 'floating', 'planar')
_LIMITED = ('revolute', 'prismatic')
_WITH_AXIS = (*_LIMITED, 'continuous', 'planar')
_ROUNDED = 2.0**-10  # of a range [-]: limits are written with three or four digits
_SHOWN = 3  # joints in a warning


def check_joint(joint: UrdfJoint, element: Any) -> None:
    """Raise SceneFileError for a type, an axis or limits that make no sense."""
    if joint.type not in TYPES:
        plain = joint.type.strip().lower()
        meant = f'; write {plain!r}' if plain in TYPES else ''
        raise joint.where.error(
            f'type {joint.type!r} is no joint type, which are {", ".join(TYPES)}{meant}'
        )
    axis = element.find('axis')
    if joint.type in _WITH_AXIS and axis is not None:
        if axis.get('xyz') is None:
            raise joint.where.error(
                '<axis/> has no attribute `xyz`: urdfdom reads 0 0 0, and Drake 1 0 0. Write the '
                'axis, or leave the element out for 1 0 0'
            )
        if not any(joint.axis):
            raise joint.where.error(
                f'axis xyz = {axis.get("xyz")!r} has no direction; it must not be zero'
            )
    if joint.type in _LIMITED and joint.lower > joint.upper:
        raise joint.where.error(
            f'limit: lower = {joint.lower:g} is above upper = {joint.upper:g}; no value is within'
        )


def warnings_about(root: Any, joints: Sequence[UrdfJoint]) -> Iterator[str]:
    """Yield warnings, with file and line, about joints that other readers interpret differently.

    ``root`` is the robot's element. Each kind is reported once, with the number of joints.
    """
    elements = {e.get('name'): e for e in root if local_name(e) == 'joint'}
    by_name = {joint.name: joint for joint in joints}
    for reason in (_unlimited, _without_range, _backwards, _unknown_leader, _beyond_its_limits):
        reasons = [(joint, reason(joint, elements[joint.name], by_name)) for joint in joints]
        affected = [(joint, text) for joint, text in reasons if text]
        if affected:
            joint, text = affected[0]
            others = [other.name for other, _ in affected[1 : 1 + _SHOWN]]
            more = ', ...' * (len(affected) > 1 + _SHOWN)
            names = ', '.join(others)
            suffix = f' (so do {len(affected) - 1} more: {names}{more})' * bool(others)
            yield str(joint.where.error(f'{text}{suffix}'))


def _unlimited(joint: UrdfJoint, element: Any, _: Mapping[str, UrdfJoint]) -> str:
    if joint.type not in _LIMITED or element.find('limit') is not None:
        return ''
    return (
        f'a {joint.type} joint without <limit>: read as one without limits, as Drake does; '
        'urdfdom, and with it robot_state_publisher and MoveIt, refuses the robot'
    )


def _without_range(joint: UrdfJoint, element: Any, _: Mapping[str, UrdfJoint]) -> str:
    limit = element.find('limit')
    if joint.type not in _LIMITED or limit is None:
        return ''
    if limit.get('lower') is not None or limit.get('upper') is not None:
        return ''
    return (
        'a <limit> without lower and upper: both count as 0, as in urdfdom, and so no other value '
        'is within; Drake reads no limits'
    )


def _backwards(joint: UrdfJoint, element: Any, _: Mapping[str, UrdfJoint]) -> str:
    limit = element.find('limit')
    speed = None if limit is None else limit.get('velocity')
    if speed is None or not float(speed) < 0.0:
        return ''
    return f'a velocity limit of {speed}: read as none, for Drake refuses it'


def _unknown_leader(joint: UrdfJoint, _: Any, by_name: Mapping[str, UrdfJoint]) -> str:
    if joint.mimic is None or joint.mimic.joint in by_name:
        return ''
    return (
        f'it mimics {joint.mimic.joint!r}, which is not a joint: joint values pose no link of '
        'this robot. Drake refuses it'
    )


def _beyond_its_limits(joint: UrdfJoint, _: Any, by_name: Mapping[str, UrdfJoint]) -> str:
    leader = None if joint.mimic is None else by_name.get(joint.mimic.joint)
    if joint.mimic is None or leader is None or joint.type not in _LIMITED:
        return ''
    ends = [_following(joint, end) for end in (leader.lower, leader.upper)]
    low, high = min(ends), max(ends)
    slack = _ROUNDED * max(joint.upper - joint.lower, 0.0)
    if math.isinf(joint.lower) or (low >= joint.lower - slack and high <= joint.upper + slack):
        return ''
    return (
        f'it mimics {leader.name!r}, whose limits take it from {low:.6g} to {high:.6g}, beyond '
        f'its own, {joint.lower:.6g} to {joint.upper:.6g}: it goes where the leader takes it'
    )


def _following(joint: UrdfJoint, value: float) -> float:
    """Return the value of a mimicking joint for a value of its leader."""
    assert joint.mimic is not None
    if joint.mimic.multiplier == 0.0:  # 0 * inf would be NaN
        return joint.mimic.offset
    return joint.mimic.multiplier * value + joint.mimic.offset
