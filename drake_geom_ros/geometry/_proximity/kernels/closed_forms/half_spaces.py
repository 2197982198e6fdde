"""Signed distance of a box, capsule, cylinder, ellipsoid or convex hull to a half space.

The half space is B, except against a convex hull, which has the higher type number. The normal is
always along the z axis of the half space. The distance is that of the other shape's lowest point,
from its support function. If a face or an edge is lowest, the witness point is its midpoint.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import Aim, OrientedShape, write
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import vertex_at
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    column,
    dot,
    norm,
    rotate,
    scale,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import (
    CLOSED_FORM,
    CONVEX,
    HALF_LENGTH,
    SHAPE_RADIUS,
    VERTEX_COUNT,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.tolerances import CLOSED_FORM_ROUNDING, RIGHT_ANGLE


@compiled
def _lowest(n: float, half: float) -> float:
    """Return the lowest coordinate in [-half, half] of an axis with the slope n; 0 if level."""
    if n > RIGHT_ANGLE:
        return -half
    if n < -RIGHT_ANGLE:
        return half
    return 0.0


@compiled
def _write(
    out: Floats,
    R_WA: Floats,
    R_WB: Floats,
    p_AB_W: Floats,
    size: float,
    depth: float,
    p_ACa: Vector,
) -> None:
    """Write the row, for A's lowest point Ca (in A) ``depth`` [m] below Ao."""
    nhat_BA_W = column(R_WB, 2)
    p = vector_at(p_AB_W, 0)
    distance = -dot(p, nhat_BA_W) - depth
    p_ACa_W = rotate(R_WA, p_ACa)
    p_ACb_W = add_scaled(p_ACa_W, -distance, nhat_BA_W)
    bound = CLOSED_FORM_ROUNDING * (size + norm(p))
    write(out, distance, nhat_BA_W, p_ACa_W, p_ACb_W, bound, True, CLOSED_FORM)


@compiled
def box_half_space(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of a box and a half space."""
    n = unrotate(A.R_W, column(B.R_W, 2))
    h = vector_at(A.shape, 0)
    depth = h[0] * abs(n[0]) + h[1] * abs(n[1]) + h[2] * abs(n[2])
    p_ACa = (_lowest(n[0], h[0]), _lowest(n[1], h[1]), _lowest(n[2], h[2]))
    _write(out, A.R_W, B.R_W, p_AB_W, norm(h), depth, p_ACa)


@compiled
def capsule_half_space(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of a capsule and a half space."""
    n = unrotate(A.R_W, column(B.R_W, 2))
    radius, half = A.shape[SHAPE_RADIUS], A.shape[HALF_LENGTH]
    p_ACa = (-radius * n[0], -radius * n[1], _lowest(n[2], half) - radius * n[2])
    depth = half * abs(n[2]) + radius
    _write(out, A.R_W, B.R_W, p_AB_W, radius + half, depth, p_ACa)


@compiled
def cylinder_half_space(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of a cylinder and a half space."""
    n = unrotate(A.R_W, column(B.R_W, 2))
    radius, half = A.shape[SHAPE_RADIUS], A.shape[HALF_LENGTH]
    across = math.sqrt(n[0] * n[0] + n[1] * n[1])
    reach = radius / across if across > RIGHT_ANGLE else 0.0
    p_ACa = (-reach * n[0], -reach * n[1], _lowest(n[2], half))
    depth = half * abs(n[2]) + radius * across
    _write(out, A.R_W, B.R_W, p_AB_W, radius + half, depth, p_ACa)


@compiled
def ellipsoid_half_space(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of an ellipsoid and a half space."""
    n = unrotate(A.R_W, column(B.R_W, 2))
    e = vector_at(A.shape, 0)
    v = (e[0] * n[0], e[1] * n[1], e[2] * n[2])
    depth = norm(v)
    p_ACa = (-e[0] * (v[0] / depth), -e[1] * (v[1] / depth), -e[2] * (v[2] / depth))
    _write(out, A.R_W, B.R_W, p_AB_W, max(e), depth, p_ACa)


@compiled
def half_space_convex(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of a half space A and a hull or solid B, by its lowest vertices.

    The witness point is the mean of the vertices that are lowest within rounding. For a solid it
    is the first of them, because there may be a hole between them.
    """
    z_W = column(A.R_W, 2)
    n = unrotate(B.R_W, z_W)
    count = int(B.shape[VERTEX_COUNT])
    lowest, size = math.inf, 0.0
    for k in range(1, count + 1):
        v = vertex_at(B.shape, k)
        lowest = min(lowest, dot(n, v))
        size = max(size, norm(v))
    mean, level = (0.0, 0.0, 0.0), 0
    for k in range(1, count + 1):
        v = vertex_at(B.shape, k)
        if dot(n, v) <= lowest + RIGHT_ANGLE * size:
            mean = add_scaled(mean, 1.0, v)
            level += 1
            if B.kind != CONVEX:
                break
    mean = scale(1.0 / level, mean)
    p = vector_at(p_AB_W, 0)
    distance = dot(p, z_W) + lowest
    p_ACb_W = add_scaled(p, 1.0, rotate(B.R_W, mean))
    p_ACa_W = add_scaled(p_ACb_W, -distance, z_W)
    bound = CLOSED_FORM_ROUNDING * (size + norm(p))
    write(out, distance, scale(-1.0, z_W), p_ACa_W, p_ACb_W, bound, True, CLOSED_FORM)
