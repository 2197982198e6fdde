"""Test whether an extreme point lies inside its segment or face, or on the border.

On a border, any motion may make another feature extreme: the normal of a contact there is not
unique, and the point has no derivative.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.shapes.features import FACE, POINT, Feature
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import farthest_vertex
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    dot,
    norm,
    scale,
    sub,
    unit,
)
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CYLINDER,
    HALF_LENGTH,
    HALF_SPACE,
    SHAPE_RADIUS,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.tolerances import DISTINCT_NORMALS

# Directions in which the corners of a hull's face are searched. A face with more corners counts as
# the polygon of those found.
SIDES = 16
# Tangent [-] of the tilt that makes a corner of a hull's face extreme: too small for adjacent
# faces, and larger than DISTINCT_NORMALS, within which edges count as parallel.
TILT = 4.0 * DISTINCT_NORMALS


@compiled
def _in_box(shape: Floats, n: Vector, q: Vector, slack: float) -> bool:
    """Return whether q is inside its edge or face of a box."""
    for k in range(3):
        if abs(n[k]) <= DISTINCT_NORMALS and abs(q[k]) > shape[k] - slack:
            return False
    return True


@compiled
def _in_hull_edge(shape: Floats, along: Vector, n: Vector, q: Vector, slack: float) -> bool:
    """Return whether q is between the end vertices of an edge along a unit vector."""
    for k in range(2):
        side = scale(1.0 - 2.0 * k, along)
        x, y, z = unit(add_scaled(n, TILT, side))
        if dot(sub(farthest_vertex(shape, x, y, z), q), side) <= slack:
            return False
    return True


@compiled
def _in_hull_face(shape: Floats, n: Vector, u: Vector, v: Vector, q: Vector, slack: float) -> bool:
    """Return whether q is inside the polygon of the corners of a face."""
    step = 2.0 * math.pi / SIDES
    x, y, z = unit(add_scaled(n, TILT, u))
    before = farthest_vertex(shape, x, y, z)
    for k in range(1, SIDES + 1):
        aside = add_scaled(scale(math.cos(k * step), u), math.sin(k * step), v)
        x, y, z = unit(add_scaled(n, TILT, aside))
        corner = farthest_vertex(shape, x, y, z)
        edge, from_corner = sub(corner, before), sub(q, before)
        length = norm(edge)
        if length > 0.0:
            left = dot(edge, u) * dot(from_corner, v) - dot(edge, v) * dot(from_corner, u)
            if left <= slack * length:
                return False
        before = corner
    return True


@compiled
def is_inside(
    kind: int,
    shape: Floats,
    feature: Feature,
    n: Vector,
    u: Vector,
    v: Vector,
    q: Vector,
    slack: float,
) -> bool:
    """Return whether the extreme point q is inside its segment or face by more than ``slack`` [m].

    Everything is in the shape's frame; n is out of it, and u, v, n right-handed. A single point is
    always inside.
    """
    if feature.freedom == POINT or kind == HALF_SPACE:
        return True
    if kind == BOX:
        return _in_box(shape, n, q, slack)
    if kind == CAPSULE or kind == CYLINDER:
        if feature.freedom == FACE:
            return math.hypot(q[0], q[1]) <= shape[SHAPE_RADIUS] - slack
        return abs(q[2]) <= shape[HALF_LENGTH] - slack
    if feature.freedom == FACE:
        return _in_hull_face(shape, n, u, v, q, slack)
    along = add_scaled(scale(feature.du, u), feature.dv, v)
    return _in_hull_edge(shape, along, n, q, slack)
