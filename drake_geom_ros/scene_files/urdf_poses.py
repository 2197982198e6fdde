"""Poses of URDF elements: the ``<origin>`` in them."""

import math
from typing import Any

from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files.xml_tree import numbers

_ORIENTATIONS = ('rpy', 'quat_xyzw', 'wxyz')
# A quaternion of few digits is of unit length to this; the factor that is left is divided away.
_UNIT_TOLERANCE = 0.01


def pose_of(element: Any) -> RigidTransform:
    """Return the pose that the ``<origin>`` of an element stands for, the identity without one.

    The orientation is ``rpy``, roll, pitch and yaw about fixed axes [rad], or ``quat_xyzw``
    (URDF 1.1), or ``wxyz`` (Tesseract). Raises ValueError, which names no line, for numbers that
    are none, for two orientations, and for a quaternion that is not of unit length.
    """
    origin = element.find('origin')
    if origin is None:
        return RigidTransform()
    given = [name for name in _ORIENTATIONS if origin.get(name) is not None]
    if len(given) > 1:
        raise ValueError(f'origin has {" and ".join(given)}; give one orientation')
    count = 3 if given in ([], ['rpy']) else 4
    turn = numbers(origin, given[0] if given else 'rpy', count, '0 0 0')
    xyz = numbers(origin, 'xyz', 3, '0 0 0')
    if not all(map(math.isfinite, (*xyz, *turn))):
        told = ' '.join(f'{name} = {value!r}' for name, value in origin.attrib.items())
        raise ValueError(f'origin: {told}; all numbers must be finite')
    if count == 3:
        return RigidTransform(RollPitchYaw(turn).ToRotationMatrix(), xyz)
    if not abs(math.hypot(*turn) - 1.0) <= _UNIT_TOLERANCE:
        raise ValueError(f'origin: {given[0]} = {origin.get(given[0])!r} must be of unit length')
    q = [component / math.hypot(*turn) for component in turn]
    return RigidTransform.FromArray([*xyz, *(q if given == ['quat_xyzw'] else [*q[1:], q[0]])])
