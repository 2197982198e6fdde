"""Intersection intervals of a ray and a primitive: closed forms, in the body's frame.

Quadrics are solved about the point of the ray nearest to their centre or axis, because the usual
discriminant, b^2 - a c, loses all digits for a small body far away.
"""

import math

from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._rendering.compiled import inlined

MISSED = (math.inf, -math.inf)


@inlined
def ball(
    ox: float, oy: float, oz: float, dx: float, dy: float, dz: float, r: float
) -> tuple[float, float]:
    """Return the interval of the ray within a ball about the origin."""
    a = dx * dx + dy * dy + dz * dz
    middle = -(ox * dx + oy * dy + oz * dz) / a
    x, y, z = ox + middle * dx, oy + middle * dy, oz + middle * dz
    rest = r * r - (x * x + y * y + z * z)
    if not rest >= 0.0:
        return MISSED
    half = math.sqrt(rest / a)
    return middle - half, middle + half


@inlined
def disc(ox: float, oy: float, dx: float, dy: float, r: float) -> tuple[float, float]:
    """Return the interval of the ray within an infinite cylinder about z."""
    a = dx * dx + dy * dy
    if a == 0.0:
        if ox * ox + oy * oy <= r * r:
            return -math.inf, math.inf
        return MISSED
    middle = -(ox * dx + oy * dy) / a
    x, y = ox + middle * dx, oy + middle * dy
    rest = r * r - (x * x + y * y)
    if not rest >= 0.0:
        return MISSED
    half = math.sqrt(rest / a)
    return middle - half, middle + half


@inlined
def slab(o: float, d: float, h: float) -> tuple[float, float]:
    """Return the interval of the ray between the planes -h and h of one axis."""
    if d == 0.0:
        if math.fabs(o) <= h:
            return -math.inf, math.inf
        return MISSED
    first, second = (-h - o) / d, (h - o) / d
    if first <= second:
        return first, second
    return second, first


@inlined
def capsule(
    ox: float, oy: float, oz: float, dx: float, dy: float, dz: float, r: float, half_length: float
) -> tuple[float, float]:
    """Return the interval of the ray within a capsule, whose ends are on the side or the caps."""
    enter, leave = disc(ox, oy, dx, dy, r)
    if enter > leave:
        return MISSED
    low = ball(ox, oy, oz + half_length, dx, dy, dz, r)
    high = ball(ox, oy, oz - half_length, dx, dy, dz, r)
    # A ray along the axis meets the side at no finite depth.
    z_in, z_out = oz, oz
    if dz != 0.0:
        z_in, z_out = oz + enter * dz, oz + leave * dz
    if z_in > half_length:
        enter = high[0]
    elif z_in < -half_length:
        enter = low[0]
    if z_out > half_length:
        leave = high[1]
    elif z_out < -half_length:
        leave = low[1]
    return enter, leave


@inlined
def interval(
    kind: int,
    s0: float,
    s1: float,
    s2: float,
    ox: float,
    oy: float,
    oz: float,
    dx: float,
    dy: float,
    dz: float,
) -> tuple[float, float]:
    """Return (t_in, t_out) of the ray in a primitive; a HALF_SPACE is its plane z = 0."""
    if kind == BOX:
        x, y, z = slab(ox, dx, s0), slab(oy, dy, s1), slab(oz, dz, s2)
        return max(x[0], y[0], z[0]), min(x[1], y[1], z[1])
    if kind == CYLINDER:
        side, ends = disc(ox, oy, dx, dy, s0), slab(oz, dz, s1)
        return max(side[0], ends[0]), min(side[1], ends[1])
    if kind == SPHERE:
        return ball(ox, oy, oz, dx, dy, dz, s0)
    if kind == CAPSULE:
        return capsule(ox, oy, oz, dx, dy, dz, s0, s1)
    if kind == ELLIPSOID:
        return ball(ox / s0, oy / s1, oz / s2, dx / s0, dy / s1, dz / s2, 1.0)
    if dz == 0.0:
        return MISSED
    return -oz / dz, -oz / dz


@inlined
def normal(kind: int, s0: float, s1: float, s2: float, x: float, y: float, z: float) -> Vector:
    """Return the direction of the normal, of any length, at a point of a primitive's surface."""
    if kind == SPHERE:
        return x, y, z
    if kind == ELLIPSOID:
        return x / (s0 * s0), y / (s1 * s1), z / (s2 * s2)
    if kind == CAPSULE:
        return x, y, z - min(max(z, -s1), s1)
    if kind == CYLINDER:
        if math.fabs(z) - s1 > math.sqrt(x * x + y * y) - s0:
            return 0.0, 0.0, z
        return x, y, 0.0
    if kind == BOX:
        gap_x, gap_y, gap_z = math.fabs(x) - s0, math.fabs(y) - s1, math.fabs(z) - s2
        if gap_x >= gap_y and gap_x >= gap_z:
            return x, 0.0, 0.0
        if gap_y >= gap_z:
            return 0.0, y, 0.0
        return 0.0, 0.0, z
    return 0.0, 0.0, 1.0
