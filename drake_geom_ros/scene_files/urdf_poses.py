"""Poses of URDF elements, from the ``<origin>`` in them."""

import math
from typing import Any

from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files.xml_tree import numbers

_ORIENTATIONS = ('rpy', 'quat_xyzw', 'wxyz')
# Quaternions written with few digits are unit within this tolerance, and normalised then.
_UNIT_TOLERANCE = 0.01


def pose_of(element: Any) -> RigidTransform:
    """Return the pose of an element's ``<origin>``; the identity if it has none.

    The orientation is ``rpy``, roll, pitch and yaw about fixed axes [rad], or ``quat_xyzw``
    (URDF 1.1), or ``wxyz`` (Tesseract). Raises ValueError, which names no line, for invalid
    numbers, two orientations, and a quaternion that is not unit.
    """
    origin = element.find('origin')
    if origin is None:
        return RigidTransform()
    orientations = [name for name in _ORIENTATIONS if origin.get(name) is not None]
    if len(orientations) > 1:
        raise ValueError(f'origin has {" and ".join(orientations)}; give one orientation')
    kind = orientations[0] if orientations else 'rpy'
    count = 3 if kind == 'rpy' else 4
    turn = numbers(origin, kind, count, '0 0 0')
    xyz = numbers(origin, 'xyz', 3, '0 0 0')
    if not all(map(math.isfinite, (*xyz, *turn))):
        attributes = ' '.join(f'{name} = {value!r}' for name, value in origin.attrib.items())
        raise ValueError(f'origin: {attributes}; all numbers must be finite')
    if count == 3:
        return RigidTransform(RollPitchYaw(turn).ToRotationMatrix(), xyz)
    if not abs(math.hypot(*turn) - 1.0) <= _UNIT_TOLERANCE:
        raise ValueError(f'origin: {kind} = {origin.get(kind)!r} must be of unit length')
    q = [component / math.hypot(*turn) for component in turn]
    return RigidTransform.FromArray([*xyz, *(q if kind == 'quat_xyzw' else [*q[1:], q[0]])])
