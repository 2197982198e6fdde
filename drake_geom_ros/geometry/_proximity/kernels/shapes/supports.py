"""Support mappings of shapes by type number, the only interface of shapes to iterative kernels.

Every body is a *core* grown by a ball: ``h(n) = h_core(n) + core_radius``. A capsule is a segment
with a radius. The core of an ellipsoid is the ellipsoid minus its largest rolling ball, of radius
c^2 / a (the least radius of curvature, with c and a the least and largest semi-axis). Its support
function is still convex (Schneider, *Convex Bodies: The Brunn-Minkowski Theory*, 2nd ed., theorem
3.2.11), and a ball becomes a point. So the cores of a shallow contact are disjoint, which GJK
solves many times faster than EPA solves an overlap.

Where the direction is normal to an edge within ``right_angle``, the support point is the midpoint
of the edge. GJK uses that (RIGHT_ANGLE): resting faces take a step or two, with witness points in
the middle. EPA does not (0), because three collinear points make a triangle without area.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import (
    farthest_vertex,
    hull_radius,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import norm, rotate, unrotate
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    HALF_LENGTH,
    SHAPE_RADIUS,
    SPHERE,
    TRIANGLE,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined


@inlined
def core_radius(kind: int, shape: Floats) -> float:
    """Return the radius [m] of the ball by which the core of a shape is grown."""
    if kind == SPHERE or kind == CAPSULE:
        return shape[SHAPE_RADIUS]
    if kind == ELLIPSOID:
        least = min(shape[0], shape[1], shape[2])
        return least * (least / max(shape[0], shape[1], shape[2]))
    return 0.0


@compiled
def bounding_radius(kind: int, shape: Floats) -> float:
    """Return the radius [m] of the bounding ball about the shape's origin."""
    if kind == SPHERE:
        return shape[SHAPE_RADIUS]
    if kind == BOX:
        return norm((shape[0], shape[1], shape[2]))
    if kind == CAPSULE:
        return shape[SHAPE_RADIUS] + shape[HALF_LENGTH]
    if kind == CYLINDER:
        return norm((shape[SHAPE_RADIUS], shape[HALF_LENGTH], 0.0))
    if kind == ELLIPSOID:
        return max(shape[0], shape[1], shape[2])
    return hull_radius(shape)


@inlined
def signed(size: float, direction: float, right_angle: float) -> float:
    """Return size with the sign of direction, or 0 if |direction| is below ``right_angle``."""
    if direction >= right_angle:
        return size
    if direction <= -right_angle:
        return -size
    return 0.0


@inlined
def farthest_corner(shape: Floats, x: float, y: float, z: float) -> Vector:
    """Return the corner of a TRIANGLE (3 x 3 parameters) extreme along (x, y, z)."""
    best = 0
    value = shape[0] * x + shape[1] * y + shape[2] * z
    for k in (3, 6):
        candidate = shape[k] * x + shape[k + 1] * y + shape[k + 2] * z
        if candidate > value:
            value = candidate
            best = k
    return shape[best], shape[best + 1], shape[best + 2]


@compiled
def local_support(kind: int, shape: Floats, n: Vector, right_angle: float) -> Vector:
    """Return the point of the core extreme along the unit vector n, both in G."""
    x, y, z = n
    if kind == BOX:
        return (
            signed(shape[0], x, right_angle),
            signed(shape[1], y, right_angle),
            signed(shape[2], z, right_angle),
        )
    if kind == CAPSULE:
        return 0.0, 0.0, signed(shape[HALF_LENGTH], z, right_angle)
    if kind == CYLINDER:
        radius, end = shape[SHAPE_RADIUS], signed(shape[HALF_LENGTH], z, right_angle)
        rho = math.sqrt(x * x + y * y)
        if rho < right_angle:
            return 0.0, 0.0, end
        if rho == 0.0:
            return radius, 0.0, end
        return radius * (x / rho), radius * (y / rho), end
    if kind == ELLIPSOID:
        a, b, c = shape[0], shape[1], shape[2]
        h = math.sqrt((a * x) * (a * x) + (b * y) * (b * y) + (c * z) * (c * z))
        r = core_radius(kind, shape)
        return x * (a * (a / h) - r), y * (b * (b / h) - r), z * (c * (c / h) - r)
    if kind == CONVEX:
        return farthest_vertex(shape, x, y, z)
    if kind == TRIANGLE:
        return farthest_corner(shape, x, y, z)
    return 0.0, 0.0, 0.0


@inlined
def support(kind: int, shape: Floats, R: Floats, n: Vector, right_angle: float) -> Vector:
    """Return the point of the core extreme along the unit n, from Go, both in World axes [m]."""
    return rotate(R, local_support(kind, shape, unrotate(R, n), right_angle))
