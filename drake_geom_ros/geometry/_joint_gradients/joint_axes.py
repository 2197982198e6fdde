"""The chain rule from the motions of frames to joint values.

A revolute joint with the unit axis a through p_WJ gives a frame F that it moves the spatial
velocity [a, a x (p_WF - p_WJ)] per radian, a prismatic one [0, a] (R. Featherstone, *Rigid Body
Dynamics Algorithms*, 2008, chapter 4). A distance with the derivatives [t, s] by the velocity of F
therefore changes by a . (t + (p_WF - p_WJ) x s), or by a . s.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._joint_gradients.compiled import inlined
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    cross,
    dot,
    rotate,
    scale,
    sub,
    vector_at,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.handles import (
    Integers,
    Reals,
    Rows,
    Vectors,
    taker,
)
from drake_geom_ros.geometry._proximity.runtime.views import row
from drake_geom_ros.geometry._proximity.world.joint_poses import REVOLUTE

FlagTable: TypeAlias = Annotated[NDArray[np.bool_], np.bool_, (None,)]


class JointAxes(NamedTuple):
    """The m joints with a column in a state, and the nf frames that each of them moves."""

    columns: Integers  # (m,) of the state
    multipliers: Reals  # (m,)
    kinds: Integers  # (m,)
    axes: Vectors  # (m, 3) unit, in the link
    links: Integers  # (m,) row of the link that the joint carries
    X_PLs: Rows  # (links, 7) in the frame P that carries the robot; scratch of ``pose_links``
    bases: Integers  # (m,) row of the frame P
    moves: FlagTable  # (m, nf)
    # Scratch: the derivative of the motion by the joint value, and the joint's position [m].
    axes_W: Vectors  # (m, 3)
    p_WJs: Vectors  # (m, 3)


axes_of = taker(JointAxes)


@inlined
def _turned(X_PL: Floats, a: Vector) -> Vector:
    """Return the vector a, in L, in the axes of P, for a pose x y z qx qy qz qw."""
    v, w = vector_at(X_PL, 3), X_PL[6]
    # a + 2 w (v x a) + 2 v x (v x a) for a unit quaternion (v, w), Rodrigues' formula.
    t = scale(2.0, cross(v, a))
    return add(add_scaled(a, w, t), cross(v, t))


@inlined
def put_axes(joints: JointAxes, R_WFs: Floats, p_WFs: Floats) -> None:
    """Write the axes and positions of all joints in World, from posed links and frames."""
    for j in range(joints.columns.size):
        X_PL, P = row(joints.X_PLs, joints.links[j]), joints.bases[j]
        R_WP, p_WP = row(R_WFs, P), vector_in(p_WFs, P)
        a = scale(joints.multipliers[j], rotate(R_WP, _turned(X_PL, vector_in(joints.axes, j))))
        p = add(p_WP, rotate(R_WP, vector_at(X_PL, 0)))
        for c in range(3):
            joints.axes_W[j, c], joints.p_WJs[j, c] = a[c], p[c]


@inlined
def put_joint_gradient(
    joints: JointAxes, p_WFs: Floats, frames: tuple[int, int], by_frames: Floats, out: Floats
) -> None:
    """Write the derivatives of a distance by the joint values to ``out`` (c,).

    ``by_frames`` (12,) are those by the spatial velocities of two ``frames``, given by their rows.
    A joint that moves both frames moves the pair as one body and leaves the distance unchanged.
    """
    for c in range(out.size):
        out[c] = 0.0
    for j in range(joints.columns.size):
        moves_A, moves_B = joints.moves[j, frames[0]], joints.moves[j, frames[1]]
        if moves_A == moves_B:
            continue
        first, frame = (0, frames[0]) if moves_A else (6, frames[1])
        a, shift = vector_in(joints.axes_W, j), vector_at(by_frames, first + 3)
        if joints.kinds[j] == REVOLUTE:
            arm = sub(vector_in(p_WFs, frame), vector_in(joints.p_WJs, j))
            shift = add(vector_at(by_frames, first), cross(arm, shift))
        out[joints.columns[j]] += dot(a, shift)
