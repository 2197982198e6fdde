"""Features of a shape extreme along a direction, and their motion as the direction turns.

At the normal n of two bodies, the extreme points of each along n determine how the distance
changes. There are three cases:

- one point, which stays (a vertex) or moves over the surface by the radii of curvature, the
  Hessian of the support function;
- a segment (an edge, or the side of a capsule or cylinder);
- a face.

Within a segment or a face the nearest point may be anywhere, and n stays normal to it.

All is expressed in two axes u, v normal to n. A direction counts as normal to an edge or face
within ``DISTINCT_NORMALS``. The Hessians are those of the support functions of ``kernels``: r for
a ball, that of h = |S n| for an ellipsoid, that of r hypot(n_x, n_y) for a cylinder.
"""

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import (
    LISTS,
    farthest,
    hull_defect,
    vertex_at,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import dot, norm, sub, unrotate
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HALF_SPACE,
    SHAPE_RADIUS,
    SPHERE,
    VERTEX_COUNT,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import DISTINCT_NORMALS

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

# Kinds of features.
POINT = 0
SEGMENT = 1
FACE = 2


class Feature(NamedTuple):
    """The extreme points: POINT, SEGMENT along the unit (du, dv), or FACE.

    When n turns by (a, b) along u, v, the point moves by the matrix [[uu, uv], [uv, vv]] [m] times
    (a, b). For a segment that holds only normal to it: along it, and in a face, the point is free.
    """

    freedom: int
    du: float
    dv: float
    uu: float
    uv: float
    vv: float


@inlined
def hold_one_point(A: Feature, B: Feature) -> bool:
    """Return whether the features of two bodies determine a single pair of nearest points.

    Parallel faces and edges do not: all points of their common part are equally near.
    """
    freedom = A.freedom + B.freedom
    if freedom != FACE or A.freedom != B.freedom:
        return freedom <= FACE
    return abs(A.du * B.dv - A.dv * B.du) > DISTINCT_NORMALS


@inlined
def along(d: Vector, u: Vector, v: Vector, uu: float, uv: float, vv: float) -> Feature:
    """Return the segment along the unit d, which is normal to n."""
    x, y = dot(d, u), dot(d, v)
    length = math.hypot(x, y)
    return Feature(SEGMENT, x / length, y / length, uu, uv, vv)


@inlined
def vertex(radius: float) -> Feature:
    """Return a vertex with a ball of a radius [m] around it."""
    return Feature(POINT, 0.0, 0.0, radius, 0.0, radius)


@inlined
def _face() -> Feature:
    return Feature(FACE, 0.0, 0.0, 0.0, 0.0, 0.0)


@compiled
def _of_box(n: Vector, u: Vector, v: Vector) -> Feature:
    """Return the vertex, edge or face of a box."""
    flat, axis = 0, (0.0, 0.0, 0.0)
    for k in range(3):
        if abs(n[k]) <= DISTINCT_NORMALS:
            flat += 1
            axis = AXES[k]
    if flat == 0:
        return vertex(0.0)
    if flat == 1:
        return along(axis, u, v, 0.0, 0.0, 0.0)
    return _face()


@compiled
def _of_cylinder(radius: float, n: Vector, u: Vector, v: Vector) -> Feature:
    """Return the rim point, side line or cap of a cylinder."""
    radial = math.hypot(n[0], n[1])
    if radial <= DISTINCT_NORMALS:
        return _face()
    t = (-n[1] / radial, n[0] / radial, 0.0)
    x, y, r = dot(t, u), dot(t, v), radius / radial
    if abs(n[2]) <= DISTINCT_NORMALS:
        return along(AXES[2], u, v, r * x * x, r * x * y, r * y * y)
    return Feature(POINT, 0.0, 0.0, r * x * x, r * x * y, r * y * y)


@inlined
def _times(axes: Vector, a: Vector) -> Vector:
    return axes[0] * a[0], axes[1] * a[1], axes[2] * a[2]


@compiled
def _of_ellipsoid(shape: Floats, n: Vector, u: Vector, v: Vector) -> Feature:
    """Return the point of an ellipsoid: (S^2 - s s^T) / h for s = S^2 n / h, h = |S n|."""
    largest = max(shape[0], shape[1], shape[2])
    axes = (shape[0] / largest, shape[1] / largest, shape[2] / largest)
    n, u, v = _times(axes, n), _times(axes, u), _times(axes, v)
    h = norm(n)
    if h == 0.0:
        return vertex(0.0)
    s_u, s_v = dot(n, u) / h, dot(n, v) / h
    scale = largest / h
    uu, uv, vv = dot(u, u) - s_u * s_u, dot(u, v) - s_u * s_v, dot(v, v) - s_v * s_v
    return Feature(POINT, 0.0, 0.0, scale * uu, scale * uv, scale * vv)


@compiled
def _of_hull(shape: Floats, n: Vector, u: Vector, v: Vector) -> Feature:
    """Return the vertex, edge or face of a hull, from the edges at an extreme vertex."""
    here = farthest(shape, n[0], n[1], n[2])
    end = 3 * int(shape[VERTEX_COUNT])
    first, last, listed = 1, end // 3 + 1, False
    if hull_defect(shape) > 0.0:
        place = end + LISTS + here - 1
        if shape[place] >= 0.0:
            first, last, listed = int(shape[place]), int(abs(shape[place + 1])), True
    freedom, du, dv = POINT, 0.0, 0.0
    for k in range(first, last):
        other = int(shape[k]) if listed else k
        edge = sub(vertex_at(shape, other), vertex_at(shape, here))
        length = norm(edge)
        if length > 0.0 and abs(dot(edge, n)) <= DISTINCT_NORMALS * length:
            x, y = dot(edge, u) / length, dot(edge, v) / length
            if freedom == POINT:
                freedom, du, dv = SEGMENT, x, y
            elif abs(du * y - dv * x) > DISTINCT_NORMALS:
                return _face()
    return Feature(freedom, du, dv, 0.0, 0.0, 0.0)


@compiled
def feature_of(kind: int, shape: Floats, R: Floats, n: Vector, u: Vector, v: Vector) -> Feature:
    """Return the extreme feature of a shape along its outward unit n, for axes u and v.

    The three are in World axes, in which the shape has the orientation R. A solid is taken for its
    hull.
    """
    if kind == SPHERE:
        return vertex(shape[SHAPE_RADIUS])
    if kind == HALF_SPACE:
        return _face()
    n, u, v = unrotate(R, n), unrotate(R, u), unrotate(R, v)
    if kind == BOX:
        return _of_box(n, u, v)
    if kind == CAPSULE:
        if abs(n[2]) <= DISTINCT_NORMALS:
            return along(AXES[2], u, v, shape[SHAPE_RADIUS], 0.0, shape[SHAPE_RADIUS])
        return vertex(shape[SHAPE_RADIUS])
    if kind == CYLINDER:
        return _of_cylinder(shape[SHAPE_RADIUS], n, u, v)
    if kind == ELLIPSOID:
        return _of_ellipsoid(shape, n, u, v)
    return _of_hull(shape, n, u, v)
