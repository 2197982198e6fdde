"""Joints of SDFormat, with those that Drake adds to the format.

A joint J of SDFormat is posed in its child C, while the child of a joint of a URDF is where the
joint puts it. The difference X_JC is a fixed part at the end of the joint.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.jointed_links import parts_of
from drake_geom_ros.scene_files.link_tree import Mimic, UrdfJoint
from drake_geom_ros.scene_files.screws import screw_parts
from drake_geom_ros.scene_files.sdf_elements import SdfFile, flag_in, number_in, numbers_in
from drake_geom_ros.scene_files.urdf_tree import UNDRIVEN
from drake_geom_ros.scene_files.xml_tree import local_name

TYPES = ('revolute', 'continuous', 'prismatic', 'fixed', 'ball', 'universal', 'revolute2', 'screw')
DRAKES_TYPES = ('planar', UNDRIVEN)
_INFINITE = 1e15  # limits of this size stand for none: the default is 1e16
_Z = (0.0, 0.0, 1.0)
Rotate = Callable[[str], RigidTransform]  # from the name of a frame E to X_JE


def joint_of(
    element: Any,
    file: SdfFile,
    name: str,
    ends: tuple[str, str],
    X_PJ: RigidTransform,
    X_JC: RigidTransform,
    frame: Rotate,
) -> UrdfJoint:
    """Return the joint of an element between two links; ``frame`` poses frames in the joint.

    Raises ValueError or RuntimeError, which name no line, for a type, an axis or limits that make
    no sense.
    """
    kind = element.get('type', '')
    is_drakes = local_name(element) != str(element.tag)
    where = file.at(element)
    if kind not in (DRAKES_TYPES if is_drakes else TYPES):
        allowed = ', '.join(DRAKES_TYPES if is_drakes else TYPES)
        raise ValueError(f'type {kind!r} of a joint is not read; read are {allowed}')
    scope, _, _ = name.rpartition('::')
    joint = UrdfJoint(kind, *ends, name, X_PJ, _Z, where=where)
    if kind == 'fixed':
        return replace(joint, X_PJ=X_PJ @ X_JC)
    if is_drakes:
        return with_child_offset(joint, X_JC)
    axes = [axis for axis in (element.find('axis'), element.find('axis2')) if axis is not None]
    directions = [_axis(axis, file, frame) for axis in axes] or [_Z]
    mimic = _mimic(element, axes, scope)
    if kind == 'ball':
        return with_child_offset(joint, X_JC)
    limits = _limits(axes[0], kind) if axes else (-math.inf, math.inf, math.inf)
    joint = replace(joint, axis=directions[0], mimic=mimic)
    joint = replace(joint, lower=limits[0], upper=limits[1], max_speed=limits[2])
    if kind == 'screw':
        return _screw(joint, element, X_JC)
    if kind in ('universal', 'revolute2'):
        if len(directions) != 2:
            raise ValueError(f'a joint of type {kind!r} has <axis> and <axis2>')
        return _universal(joint, axes[1], directions, X_JC)
    return with_child_offset(joint, X_JC)


def with_child_offset(joint: UrdfJoint, X_JC: RigidTransform) -> UrdfJoint:
    """Return a joint whose child link stands at X_JC in its moved frame."""
    if X_JC.IsExactlyIdentity():
        return joint
    return replace(joint, parts=(*parts_of(joint), _fixed_part(joint, X_JC)))


def _fixed_part(joint: UrdfJoint, X_JC: RigidTransform) -> UrdfJoint:
    return UrdfJoint(
        'fixed', joint.parent, joint.child, f'{joint.name}/child', X_JC, _Z, where=joint.where
    )


def _universal(
    joint: UrdfJoint,
    second: Any,
    directions: Sequence[tuple[float, float, float]],
    X_JC: RigidTransform,
) -> UrdfJoint:
    """Return a joint about two axes, the second of which the first turns."""
    lower, upper, speed = _limits(second, joint.type)
    first = replace(joint, type='revolute', name=f'{joint.name}/qx', mimic=None)
    then = replace(
        first,
        name=f'{joint.name}/qy',
        X_PJ=RigidTransform(),
        axis=directions[1],
        lower=lower,
        upper=upper,
        max_speed=speed,
    )
    parts = (first, then, _fixed_part(joint, X_JC))
    return replace(joint, type='universal', mimic=None, parts=parts)


def _screw(joint: UrdfJoint, element: Any, X_JC: RigidTransform) -> UrdfJoint:
    """Return a screw joint, a revolute one that a prismatic one follows."""
    if element.find('screw_thread_pitch') is not None:
        (pitch,) = numbers_in(element, 'screw_thread_pitch', 1)
    else:
        (older,) = numbers_in(element, 'thread_pitch', 1, '1')
        if older == 0.0:
            raise ValueError('<thread_pitch> must not be 0')
        pitch = -2.0 * math.pi / older
    return replace(joint, parts=(*screw_parts(joint, pitch), _fixed_part(joint, X_JC)))


def _axis(axis: Any, file: SdfFile, frame: Rotate) -> tuple[float, float, float]:
    """Return the direction of an axis element in the joint's frame."""
    xyz = numbers_in(axis, 'xyz', 3, '0 0 1')
    if not any(xyz):
        raise ValueError('<xyz> of an axis is zero; it has no direction')
    element = axis.find('xyz')
    expressed_in = '' if element is None else element.get('expressed_in', '')
    if file.version < (1, 5) or (
        file.version < (1, 7) and flag_in(axis, 'use_parent_model_frame')
    ):
        expressed_in = '__model__'
    R_JE = frame(expressed_in).rotation().matrix() if expressed_in else np.eye(3)
    x, y, z = (R_JE @ np.array(xyz)).tolist()
    return x, y, z


def _limits(axis: Any, kind: str) -> tuple[float, float, float]:
    """Return lower, upper and speed limit of an axis; infinite where there is none."""
    limit = axis.find('limit')
    if limit is None:
        return -math.inf, math.inf, math.inf
    lower, upper, speed = (
        number_in(limit, name, default)
        for name, default in (('lower', -math.inf), ('upper', math.inf), ('velocity', math.inf))
    )
    lower = lower if lower > -_INFINITE else -math.inf
    upper = upper if upper < _INFINITE else math.inf
    if kind == 'continuous':
        lower, upper = -math.inf, math.inf
    if lower > upper:
        raise ValueError(f'limit: lower = {lower:g} is above upper = {upper:g}')
    return lower, upper, speed if 0.0 < speed < _INFINITE else math.inf


def _mimic(element: Any, axes: Sequence[Any], scope: str) -> Mimic | None:
    """Return the joint that a joint follows, by SDFormat's or Drake's element."""
    prefix = f'{scope}::' if scope else ''
    for child in element:
        if local_name(child) == 'mimic':
            multiplier, offset = (float(child.get(key, '0')) for key in ('multiplier', 'offset'))
            return Mimic(prefix + _leader(child), multiplier, offset)
    followed = axes[0].find('mimic') if axes else None
    if followed is None:
        return None
    (multiplier,) = numbers_in(followed, 'multiplier', 1, '1')
    (offset,), (reference,) = (numbers_in(followed, k, 1, '0') for k in ('offset', 'reference'))
    return Mimic(prefix + _leader(followed), multiplier, offset - multiplier * reference)


def _leader(element: Any) -> str:
    if not element.get('joint'):
        raise ValueError('mimic has no attribute `joint`')
    return str(element.get('joint'))
