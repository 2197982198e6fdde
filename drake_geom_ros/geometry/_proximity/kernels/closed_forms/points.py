"""Signed distance from a point to a primitive shape, in the shape's own frame G.

``<shape>_point(lengths, q, slack)`` returns a ``NearestOnSurface``. ``slack`` [m] is the rounding
of the coordinates of q: candidates that differ by less count as equal, and then the choice is

- at the centre of a sphere, or on the axis of a capsule or cylinder: +x;
- among equally near faces: the face of the lowest axis, on its positive side; a cylinder's barrel
  before its caps;
- among mirror images on an ellipsoid: the positive side of the (first) shortest axis.

``at_box_edge`` and ``at_cylinder_rim`` replace the gradient where q is within ``near`` [m] of an
edge, a corner or a rim. The gradient there is the normalised mean of the adjacent outward normals,
as in Drake's documentation of ``QueryObject`` for boxes.

``near_<shape>(shape, q)`` takes the parameters of a kernel. It returns the size of the pair [m],
sizes plus distance of the origins, and the nearest point with the rounding of that size as slack.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.closed_forms.ellipsoid_point import (
    NearestOnSurface,
    ellipsoid_point,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import norm, scale, sub, unit, vector_at
from drake_geom_ros.geometry._proximity.kinds import HALF_LENGTH, SHAPE_RADIUS
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined
from drake_geom_ros.geometry._proximity.tolerances import TIE


@inlined
def length_and_direction(v: Vector) -> tuple[float, Vector]:
    """Return |v| and v / |v|; the direction of the zero vector is +x."""
    length = norm(v)
    if length == 0.0:
        return 0.0, (1.0, 0.0, 0.0)
    return length, unit(v)


@inlined
def clamp(x: float, limit: float) -> float:
    """Return the number nearest to x in [-limit, limit]."""
    return min(max(x, -limit), limit)


@inlined
def excess(h: Vector, v: Vector) -> Vector:
    """Return v minus its nearest point of the box with half sizes h; zero inside."""
    return v[0] - clamp(v[0], h[0]), v[1] - clamp(v[1], h[1]), v[2] - clamp(v[2], h[2])


@inlined
def along(k: int, s: float) -> Vector:
    """Return s times the k-th unit vector."""
    return s if k == 0 else 0.0, s if k == 1 else 0.0, s if k == 2 else 0.0


@inlined
def sphere_point(radius: float, q: Vector, slack: float) -> NearestOnSurface:
    """Return the nearest point of a sphere to q."""
    rho, grad = length_and_direction(q)
    return NearestOnSurface(rho - radius, grad, scale(radius, grad), rho > slack)


@inlined
def box_point(h: Vector, q: Vector, slack: float) -> NearestOnSurface:
    """Return the nearest point of a box with half sizes h to q."""
    beyond = (abs(q[0]) - h[0], abs(q[1]) - h[1], abs(q[2]) - h[2])
    if max(beyond) > 0.0:
        p_NQ = excess(h, q)
        distance, grad = length_and_direction(p_NQ)
        faces = 0
        for k in range(3):
            if beyond[k] >= -slack:
                faces += 1
        return NearestOnSurface(distance, grad, sub(q, p_NQ), distance > slack or faces == 1)
    k = 0
    for i in range(1, 3):
        if beyond[i] > beyond[k] + slack:
            k = i
    unique = abs(q[k]) > slack
    for i in range(3):
        if i != k and beyond[i] >= beyond[k] - slack:
            unique = False
    side = -1.0 if q[k] < -slack else 1.0
    distance = side * q[k] - h[k]
    grad = along(k, side)
    face = side * h[k]
    p_GN = (face if k == 0 else q[0], face if k == 1 else q[1], face if k == 2 else q[2])
    return NearestOnSurface(distance, grad, p_GN, unique)


@inlined
def at_no_edge(
    shape: Floats, q: Vector, near: float, nearest: NearestOnSurface
) -> NearestOnSurface:
    """Return ``nearest`` unchanged, for shapes without edges."""
    return nearest


@inlined
def at_box_edge(
    shape: Floats, q: Vector, near: float, nearest: NearestOnSurface
) -> NearestOnSurface:
    """Return the nearest point of a box, with the gradient of an edge or corner if on one."""
    if not abs(nearest.distance) <= near:
        return nearest
    x, y, z = _side(q[0], shape[0], near), _side(q[1], shape[1], near), _side(q[2], shape[2], near)
    faces = abs(x) + abs(y) + abs(z)
    if faces < 2.0:
        return nearest
    grad = scale(1.0 / math.sqrt(faces), (x, y, z))
    return NearestOnSurface(nearest.distance, grad, nearest.p_GN, False)


@inlined
def _side(x: float, half: float, near: float) -> float:
    """Return the side, 1 or -1, on whose face a coordinate lies; 0 for neither."""
    if abs(x) < half - near:
        return 0.0
    return -1.0 if x < 0.0 else 1.0


@inlined
def capsule_point(radius: float, half_length: float, q: Vector, slack: float) -> NearestOnSurface:
    """Return the nearest point of a capsule to q: that of its segment along z, plus the radius."""
    z = clamp(q[2], half_length)
    rho, grad = length_and_direction((q[0], q[1], q[2] - z))
    p_GN = (radius * grad[0], radius * grad[1], radius * grad[2] + z)
    return NearestOnSurface(rho - radius, grad, p_GN, rho > slack)


@inlined
def cylinder_point(radius: float, half_length: float, q: Vector, slack: float) -> NearestOnSurface:
    """Return the nearest point of a cylinder to q: of a rectangle in the plane of axis and q."""
    rho, radial = length_and_direction((q[0], q[1], 0.0))
    barrel = rho - radius
    cap = abs(q[2]) - half_length
    if barrel > 0.0 or cap > 0.0:
        side = -1.0 if q[2] < 0.0 else 1.0
        distance, (dr, dz, _) = length_and_direction((max(barrel, 0.0), max(cap, 0.0), 0.0))
        grad = (dr * radial[0], dr * radial[1], side * dz)
        z = clamp(q[2], half_length)
        p_GN = (radius * radial[0], radius * radial[1], z) if barrel > 0.0 else (q[0], q[1], z)
        unique = distance > slack or barrel < -slack or cap < -slack
        return NearestOnSurface(distance, grad, p_GN, unique)
    if barrel >= cap - slack:
        p_GN = (radius * radial[0], radius * radial[1], q[2])
        return NearestOnSurface(barrel, radial, p_GN, rho > slack and barrel > cap + slack)
    side = -1.0 if q[2] < -slack else 1.0
    p_GN = (q[0], q[1], side * half_length)
    return NearestOnSurface(side * q[2] - half_length, (0.0, 0.0, side), p_GN, abs(q[2]) > slack)


@inlined
def at_cylinder_rim(
    shape: Floats, q: Vector, near: float, nearest: NearestOnSurface
) -> NearestOnSurface:
    """Return the nearest point of a cylinder, with the gradient of a rim if on one."""
    if not abs(nearest.distance) <= near:
        return nearest
    rho, radial = length_and_direction((q[0], q[1], 0.0))
    if rho < shape[SHAPE_RADIUS] - near or abs(q[2]) < shape[HALF_LENGTH] - near:
        return nearest
    side = -1.0 if q[2] < 0.0 else 1.0
    grad = scale(math.sqrt(0.5), (radial[0], radial[1], side))
    return NearestOnSurface(nearest.distance, grad, nearest.p_GN, False)


@inlined
def half_space_point(q: Vector) -> NearestOnSurface:
    """Return the nearest point of the half space z <= 0 to q."""
    return NearestOnSurface(q[2], (0.0, 0.0, 1.0), (q[0], q[1], 0.0), True)


@inlined
def near_sphere(shape: Floats, q: Vector) -> tuple[float, NearestOnSurface]:
    """Return the size of the pair and the nearest point of a sphere."""
    extent = shape[SHAPE_RADIUS] + norm(q)
    return extent, sphere_point(shape[SHAPE_RADIUS], q, TIE * extent)


@inlined
def near_box(shape: Floats, q: Vector) -> tuple[float, NearestOnSurface]:
    """Return the size of the pair and the nearest point of a box."""
    h = vector_at(shape, 0)
    extent = norm(h) + norm(q)
    return extent, box_point(h, q, TIE * extent)


@inlined
def near_capsule(shape: Floats, q: Vector) -> tuple[float, NearestOnSurface]:
    """Return the size of the pair and the nearest point of a capsule."""
    extent = shape[SHAPE_RADIUS] + shape[HALF_LENGTH] + norm(q)
    return extent, capsule_point(shape[SHAPE_RADIUS], shape[HALF_LENGTH], q, TIE * extent)


@inlined
def near_cylinder(shape: Floats, q: Vector) -> tuple[float, NearestOnSurface]:
    """Return the size of the pair and the nearest point of a cylinder."""
    extent = shape[SHAPE_RADIUS] + shape[HALF_LENGTH] + norm(q)
    return extent, cylinder_point(shape[SHAPE_RADIUS], shape[HALF_LENGTH], q, TIE * extent)


@inlined
def near_ellipsoid(shape: Floats, q: Vector) -> tuple[float, NearestOnSurface]:
    """Return the size of the pair and the nearest point of an ellipsoid."""
    e = vector_at(shape, 0)
    extent = max(e) + norm(q)
    return extent, ellipsoid_point(e, q, TIE * extent)


@inlined
def near_half_space(shape: Floats, q: Vector) -> tuple[float, NearestOnSurface]:
    """Return the size of the pair and the nearest point of a half space."""
    return norm(q), half_space_point(q)
