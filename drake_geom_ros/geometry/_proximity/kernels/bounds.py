"""Bounds of one shape: its box in World axes, the ball around it and the ball inside it."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import write
from drake_geom_ros.geometry._proximity.kernels.cores.hulls import (
    farthest_along_axes,
    farthest_vertex,
    hull_defect,
)
from drake_geom_ros.geometry._proximity.kernels.cores.supports import bounding_radius
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    column,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unit,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import (
    BOUND_ONLY,
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    HALF_LENGTH,
    HALF_SPACE,
    SHAPE_RADIUS,
    SOLID,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.tolerances import EPS

Floats = NDArray[np.float64]


class PosedShape(NamedTuple):
    """A shape, its orientation, and the radius [m] of a ball about Go that lies in it."""

    kind: int
    shape: Floats
    R_WG: Floats
    inner_radius: float


@inlined
def has_hull(shape_type):
    """Tell whether the shape's parameters begin with the vertices of its hull."""
    return shape_type == CONVEX or shape_type == SOLID


@inlined
def support_value(shape_type, shape, n_G):
    """Return the support value h(n) [m] from Go; n a unit vector in G. A half space has none.

    Every shape but a hull is symmetric about Go: h(-n) is the same. That of a solid is its hull's.
    """
    x, y, z = abs(n_G[0]), abs(n_G[1]), abs(n_G[2])
    if shape_type == SPHERE:
        return shape[SHAPE_RADIUS]
    if shape_type == BOX:
        return x * shape[0] + y * shape[1] + z * shape[2]
    if shape_type == CAPSULE:
        return shape[SHAPE_RADIUS] + z * shape[HALF_LENGTH]
    if shape_type == CYLINDER:
        return shape[SHAPE_RADIUS] * math.sqrt(x * x + y * y) + z * shape[HALF_LENGTH]
    if shape_type == ELLIPSOID:
        return norm((x * shape[0], y * shape[1], z * shape[2]))
    if has_hull(shape_type):
        farthest = farthest_vertex(shape, n_G[0], n_G[1], n_G[2])
        return dot(n_G, farthest) + hull_defect(shape)
    return math.inf


@compiled
def box_half_extents(shape_type, shape, R_WG, half_extents):
    """Write the half extents (3,) [m] of the World-aligned box about Go that holds the shape."""
    if has_hull(shape_type):
        half_extents[0], half_extents[1], half_extents[2] = farthest_along_axes(shape, R_WG)
        return
    for k in range(3):
        e_G = (R_WG[k, 0], R_WG[k, 1], R_WG[k, 2])
        half_extents[k] = support_value(shape_type, shape, e_G)


@compiled
def outer_radius(shape_type, shape):
    """Return the largest distance [m] of a point of the shape from Go; infinite for a plane."""
    return math.inf if shape_type == HALF_SPACE else bounding_radius(shape_type, shape)


@compiled
def inner_radius(shape_type, shape):
    """Return the radius of a ball about Go that lies in the shape; 0 for hulls and solids."""
    if shape_type == SPHERE or shape_type == CAPSULE:
        return shape[SHAPE_RADIUS]
    if shape_type == BOX or shape_type == ELLIPSOID:
        return min(shape[0], shape[1], shape[2])
    if shape_type == CYLINDER:
        return min(shape[SHAPE_RADIUS], shape[HALF_LENGTH])
    return 0.0


@allocating
def shape_radii(types, starts, pool):
    """Return outer and inner radii (n,), (n,) [m] about each Go."""
    outer, inner = np.empty(types.size), np.empty(types.size)
    for k in range(types.size):
        shape = pool[starts[k] : starts[k + 1]]
        outer[k] = outer_radius(types[k], shape)
        inner[k] = inner_radius(types[k], shape)
    return outer, inner


@inlined
def point_inside(shape_type, shape, R_WG, n_W):
    """Return the centre of the ball inside a shape, from Go in World: a vertex of a hull, else Go.

    The origin of a hull may lie outside it, and that of a solid too.
    """
    if not has_hull(shape_type):
        return 0.0, 0.0, 0.0
    x, y, z = unrotate(R_WG, n_W)
    return rotate(R_WG, farthest_vertex(shape, x, y, z))


@compiled
def bounding_interval(A, B, p_AB_W, out):
    """Write the middle and the half width of a certified interval of phi from bounds alone.

    For every unit n, ``phi >= -h_A(n) - h_B(-n)``; n is taken along the line of the centres, or
    along the normal of a half space, for which this is the exact value. Above, phi is at most the
    distance of the balls inside, that of a hull being its vertex towards the other. The witness
    points lie on the two supporting planes, above Ao.
    """
    p = vector_at(p_AB_W, 0)
    flat = A.kind == HALF_SPACE or B.kind == HALF_SPACE
    if A.kind == HALF_SPACE:
        n_AB_W = column(A.R_WG, 2)
    elif B.kind == HALF_SPACE:
        n_AB_W = scale(-1.0, column(B.R_WG, 2))
    else:
        n_AB_W = unit(p)
        if dot(n_AB_W, n_AB_W) == 0.0:
            n_AB_W = column(A.R_WG, 0)
    h_A, h_B = 0.0, 0.0
    if A.kind != HALF_SPACE:
        h_A = support_value(A.kind, A.shape, unrotate(A.R_WG, n_AB_W))
    if B.kind != HALF_SPACE:
        h_B = support_value(B.kind, B.shape, scale(-1.0, unrotate(B.R_WG, n_AB_W)))
    lower = dot(n_AB_W, p) - h_A - h_B
    upper = lower
    if not flat:
        a = point_inside(A.kind, A.shape, A.R_WG, n_AB_W)
        b = point_inside(B.kind, B.shape, B.R_WG, scale(-1.0, n_AB_W))
        upper = max(lower, norm(sub(add(p, b), a)) - A.inner_radius - B.inner_radius)
    distance = lower + 0.5 * (upper - lower)
    p_ACa_W = scale(h_A, n_AB_W)
    p_ACb_W = add_scaled(p_ACa_W, distance, n_AB_W)
    rounding = 8.0 * EPS * (norm(p) + h_A + h_B)
    for kind, shape in ((A.kind, A.shape), (B.kind, B.shape)):
        if has_hull(kind):  # its support value is rounded up by as much
            rounding += hull_defect(shape)
    bound = 0.5 * (upper - lower) + rounding
    write(out, distance, scale(-1.0, n_AB_W), p_ACa_W, p_ACb_W, bound, False, BOUND_ONLY)
