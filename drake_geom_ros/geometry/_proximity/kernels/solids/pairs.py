"""Signed distance of a core or a solid from a solid: one kernel for every row with a solid.

A solid is the closed body that a mesh bounds, dents, holes and cavities and all. Apart, the answer
is the distance of the surfaces (``distance``), as exact as that of two cores. Overlapping, it is
minus the length of a translation that is verified to separate, and ``error_bound`` tells how much
shorter the shortest may be (``overlap``); the method OPEN says that this is much. Where surfaces
do not cross, triangles that touch tell, and one of each piece (``containment``).
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    NORMAL,
    Aim,
    OrientedShape,
    write,
)
from drake_geom_ros.geometry._proximity.kernels.cores.gjk import BEYOND_CUTOFF, OVERLAP
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import (
    bounding_radius,
    core_radius,
    local_support,
)
from drake_geom_ros.geometry._proximity.kernels.solids.containment import is_contained
from drake_geom_ros.geometry._proximity.kernels.solids.distance import Nearest, nearest
from drake_geom_ros.geometry._proximity.kernels.solids.hulls import hull_support
from drake_geom_ros.geometry._proximity.kernels.solids.overlap import (
    BACK_OFF,
    bounds_of_depth,
)
from drake_geom_ros.geometry._proximity.kernels.solids.reach import nearest_within
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    Solid,
    TreeBody,
    body_of,
    solid_of,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unit,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, CONVEX, MESH, OPEN, SPHERE
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import EPS, ROUNDING

OPEN_SHARE = 0.1  # of a depth [-] that the shortest way out may be less by: more leaves it open
LOOSE = 4.0 * BACK_OFF  # roundings that a depth may be off by all the same


@compiled
def first_direction(out: Floats, R_WB: Floats, p: Vector) -> Vector:
    """Return the unit n out of A by the hint in a result row, in B's axes; else towards Bo."""
    n = unit((-out[NORMAL], -out[NORMAL + 1], -out[NORMAL + 2]))
    if dot(n, n) > 0.5:
        return unrotate(R_WB, n)
    n = unit(scale(-1.0, p))
    return n if dot(n, n) > 0.5 else (1.0, 0.0, 0.0)


@compiled
def write_row(
    out: Floats,
    R_WB: Floats,
    p: Vector,
    m: Vector,
    a: Vector,
    b: Vector,
    interval: tuple[float, float],
    unique: bool,
    method: int,
) -> None:
    """Fill the row: m out of B, points a and b from Bo, all in B; interval (distance, error)."""
    distance, error = interval
    write(
        out,
        distance,
        rotate(R_WB, m),
        rotate(R_WB, sub(a, p)),
        rotate(R_WB, sub(b, p)),
        error,
        unique,
        method,
    )


@compiled
def write_beyond(
    out: Floats,
    A: TreeBody,
    B: Solid,
    R_WB: Floats,
    p: Vector,
    n: Vector,
    lower: float,
    radius: float,
    noise: float,
) -> None:
    """Fill the row of a pair that is farther apart than ``lower``, which is beyond the cutoff."""
    a = add_scaled(add(p, hull_support(A, n)), radius, n)
    upper = norm(sub(local_support(CONVEX, B.shape, scale(-1.0, n), 0.0), a))
    b = add_scaled(a, lower, n)
    error = max(upper - lower, 0.0) + noise
    write_row(out, R_WB, p, scale(-1.0, n), a, b, (lower, error), True, BOUND_ONLY)


@compiled
def write_overlap(
    out: Floats,
    A: TreeBody,
    B: Solid,
    R_WB: Floats,
    p: Vector,
    found: Nearest,
    size: float,
    tolerance: float,
    radius: float,
) -> None:
    """Fill the row of a pair that overlaps."""
    depth, least, t, b, alone = bounds_of_depth(A, B, p, found, size, tolerance, radius)
    noise = ROUNDING * EPS * size
    m, unique = unit(t), alone and depth - least <= tolerance + LOOSE * noise
    depth = max(depth - BACK_OFF * noise, 0.0)
    error = max(depth - least, 0.0) + (1.0 + BACK_OFF) * noise
    a = add_scaled(b, -depth, m)
    method = OPEN if depth - least > max(OPEN_SHARE * depth, tolerance + LOOSE * noise) else MESH
    write_row(out, R_WB, p, m, a, b, (-depth, error), unique, method)


@allocating
def signed_distance_to_solid(
    shaped_A: OrientedShape, shaped_B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the result row of any bounded shape and a solid."""
    kind_A, shape_A, R_WA = shaped_A
    kind_B, shape_B, R_WB = shaped_B
    tolerance, cutoff = aim.tolerance, aim.cutoff
    radius = core_radius(kind_A, shape_A)
    p = scale(-1.0, unrotate(R_WB, vector_at(p_AB_W, 0)))
    size = bounding_radius(kind_A, shape_A) + bounding_radius(kind_B, shape_B) + norm(p)
    noise = ROUNDING * EPS * size
    R = np.empty((3, 3))
    for j in range(3):
        R[0, j], R[1, j], R[2, j] = unrotate(R_WB, (R_WA[0, j], R_WA[1, j], R_WA[2, j]))
    A, B = body_of(kind_A, shape_A, R), solid_of(shape_B)
    n = first_direction(out, R_WB, p)
    found = nearest_within(A, B, p, n, size, tolerance, max(cutoff, 0.0) + radius + noise)
    end, upper, lower, n, a, b, unique = found
    if end == OVERLAP or upper - radius < -noise or is_contained(A, B, p, lower <= noise, size):
        if end == BEYOND_CUTOFF:
            found = nearest(A, B, p, n, size, tolerance, math.inf)
        if kind_A == SPHERE and radius == 0.0:  # a point is out where the surface is nearest
            _, depth, _, n, a, b, unique = found
            write_row(out, R_WB, p, n, a, b, (-depth, noise), unique, MESH)
        else:
            write_overlap(out, A, B, R_WB, p, found, size, tolerance, radius)
    elif end == BEYOND_CUTOFF:
        write_beyond(out, A, B, R_WB, p, n, lower - radius - noise, radius, noise)
    else:
        distance = upper - radius
        a = add_scaled(a, radius, n)
        b = add_scaled(a, distance, n)
        error = max(upper - lower, 0.0) + noise
        if kind_A == SPHERE and lower <= noise:  # its middle may be on the other side
            error += 2.0 * upper
        write_row(out, R_WB, p, scale(-1.0, n), a, b, (distance, error), unique, MESH)
