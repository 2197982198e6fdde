"""Joints of a compiled model of MuJoCo as chains of simple joints.

A body stands at its pose in its parent and is then moved by its joints in their order: a hinge
turns it about an axis through an anchor in the body, a slide shifts it along an axis, and both
count from the reference value ``qpos0``.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.quaternions import AngleAxis
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.jointed_links import parts_of
from drake_geom_ros.scene_files.link_tree import UrdfJoint

_FREE, _BALL, _SLIDE, _HINGE = range(4)  # mujoco.mjtJoint
_Z = (0.0, 0.0, 1.0)
_STAYS = RigidTransform()


def joint_of(
    model: Any, body: int, ends: tuple[str, str], X_PB: RigidTransform, where: Location
) -> UrdfJoint:
    """Return the joint that is equivalent to all joints of a body.

    A mocap body, which programs pose, is free.
    """
    first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    ids = range(first, first + count)
    name = _name(model, ids[0]) if count == 1 else f'{ends[1]}_joints'
    is_free = (count and model.jnt_type[first] == _FREE) or model.body_mocapid[body] >= 0
    if is_free:
        free = name if count else f'{ends[1]}_mocap'
        return UrdfJoint('floating', *ends, free, _STAYS, _Z, where=where)
    if not count:
        return UrdfJoint('fixed', *ends, f'{ends[1]}_fixed', X_PB, _Z, where=where)
    parts: list[UrdfJoint] = []
    X = X_PB
    for id in ids:
        part, X = _part(model, id, ends, X, where)
        parts += part
    if len(parts) == 1 and X.IsExactlyIdentity():
        return parts[0]
    last = UrdfJoint('fixed', *ends, f'{name}/body', X, _Z, where=where)
    whole = replace(parts[0], name=name, parts=(*parts, last))
    kinds = {int(model.jnt_type[id]) for id in ids}
    if count > 1:
        return replace(whole, type='chain')
    return replace(whole, type='ball') if kinds == {_BALL} else whole


def _part(
    model: Any, id: int, ends: tuple[str, str], X: RigidTransform, where: Location
) -> tuple[list[UrdfJoint], RigidTransform]:
    """Return the simple joints of one joint, and the pose that remains behind them.

    X is the pose that remains before it.
    """
    name = _name(model, id)
    kind, start = int(model.jnt_type[id]), int(model.jnt_qposadr[id])
    p, axis = model.jnt_pos[id], model.jnt_axis[id]
    anchor = RigidTransform(p)
    if kind == _BALL:
        joint = UrdfJoint('ball', *ends, name, X @ anchor, _Z, where=where)
        return parts_of(joint), anchor.inverse()
    reference = float(model.qpos0[start])
    lower, upper = -math.inf, math.inf
    if model.jnt_limited[id]:
        lower, upper = map(float, model.jnt_range[id])
    unit = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    x, y, z = unit.tolist()
    if kind == _SLIDE:
        X_PJ, after = X @ RigidTransform(-reference * unit), _STAYS
    else:
        turned = RotationMatrix(theta_lambda=AngleAxis(-reference, unit))
        X_PJ, after = X @ anchor @ RigidTransform(turned, (0.0, 0.0, 0.0)), anchor.inverse()
    joint = UrdfJoint(
        'prismatic' if kind == _SLIDE else 'revolute',
        *ends,
        name,
        X_PJ,
        (x, y, z),
        lower,
        upper,
        where=where,
    )
    return [joint], after


def _name(model: Any, id: int) -> str:
    return str(model.joint(id).name) or f'joint_{id}'


def pose_of(position: Any, wxyz: Any) -> RigidTransform:
    """Return a pose from a position and a unit quaternion in MuJoCo's order."""
    w, x, y, z = (float(component) for component in wxyz)
    n = math.sqrt(w * w + x * x + y * y + z * z)
    return RigidTransform.FromArray([*map(float, position), x / n, y / n, z / n, w / n])
