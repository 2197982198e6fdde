"""Signed distance of two boxes.

The Minkowski difference of two boxes has facets along 15 axes: the faces of A, the faces of B, and
each edge of A crossed with each edge of B (S. Gottschalk, *Separating axis theorem*, 1996). The
largest separation along them is the signed distance where the boxes overlap, with the least
translation along that axis. For separated boxes it is a lower bound. Their distance is the least
of the 24 edges, each against the other box as a solid, which covers vertices, edges and faces.

All is computed in A's frame with B's axes expressed there, so the cross product of nearly parallel
edges is normal to both to the last digit. Only parallel edges are skipped, because their cross
products are face normals. Among equal separations, a face precedes crossed edges, A's faces B's,
and the lowest axis comes first, towards its positive side. Where a face lies on a face, the
witness points are at the centroid of the outline of the common patch.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import Aim, OrientedShape, write
from drake_geom_ros.geometry._proximity.kernels.closed_forms.box_contact import (
    closest_points,
    common_point,
    seen_from_other,
    to_first,
    to_second,
)
from drake_geom_ros.geometry._proximity.kernels.closed_forms.points import (
    along,
    length_and_direction,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    column,
    cross,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import CLOSED_FORM
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.tolerances import (
    ALONG_AXIS,
    CLEAR_SEPARATION,
    CLOSED_FORM_ROUNDING,
    DISTINCT_NORMALS,
    RIGHT_ANGLE,
    TIE,
)

AXES = 15


@compiled
def _axis(b: tuple[Vector, Vector, Vector], m: int) -> Vector:
    """Return candidate m of the separating axes, in A: a unit vector, or 0 for none."""
    if m < 3:
        return along(m, 1.0)
    if m < 6:
        return b[m - 3]
    n = cross(along((m - 6) // 3, 1.0), b[(m - 6) % 3])
    sine = math.sqrt(dot(n, n))
    # Parallel edges are not needed: boxes with exactly parallel edges are prisms along these, and
    # face normals suffice to separate their cross sections. Turning one box until the edges are
    # parallel changes no separation by more than RIGHT_ANGLE times the extent: a quarter of
    # CLOSED_FORM_ROUNDING, which is in the error bound.
    if sine <= RIGHT_ANGLE:
        return 0.0, 0.0, 0.0
    return scale(1.0 / sine, n)


@compiled
def _separation(
    h: Vector, g: Vector, b: tuple[Vector, Vector, Vector], c: Vector, n: Vector, slack: float
) -> tuple[float, float]:
    """Return the larger separation of the boxes along n and -n, and its sign."""
    side = -1.0 if dot(c, n) < -slack else 1.0
    size_A = h[0] * abs(n[0]) + h[1] * abs(n[1]) + h[2] * abs(n[2])
    size_B = g[0] * abs(dot(b[0], n)) + g[1] * abs(dot(b[1], n)) + g[2] * abs(dot(b[2], n))
    return side * dot(c, n) - size_A - size_B, side


@compiled
def _separating_axis(
    h: Vector, g: Vector, b: tuple[Vector, Vector, Vector], c: Vector, slack: float
) -> tuple[float, Vector, int, bool]:
    """Return the largest separation, its unit normal out of A, its axis number, uniqueness."""
    phi, n, best, tie = -math.inf, (1.0, 0.0, 0.0), 0, False
    for m in range(AXES):
        axis = _axis(b, m)
        if dot(axis, axis) > 0.0:
            separation, side = _separation(h, g, b, c, axis, slack)
            if separation > phi + slack:
                tie = separation <= phi + 2.0 * slack
                phi, n, best = separation, scale(side, axis), m
            elif separation >= phi - slack and norm(cross(axis, n)) > DISTINCT_NORMALS:
                tie = True
    return phi, n, best, not tie and abs(dot(c, n)) > slack


@compiled
def _witness_on_first(
    h: Vector,
    g: Vector,
    b: tuple[Vector, Vector, Vector],
    c: Vector,
    phi: float,
    n: Vector,
    axis: int,
    slack: float,
) -> tuple[Vector, float]:
    """Return the point of A, in A, that touches B moved by -phi n, and its distance from B."""
    moved = add_scaled(c, -phi, n)
    if 3 <= axis < 6:
        a, origin = seen_from_other(b, moved)
        p, miss = common_point(g, h, a, origin, scale(-1.0, to_second(b, n)), True, slack)
        return add(moved, to_first(b, p)), miss
    return common_point(h, g, b, moved, n, axis < 3, slack)


@compiled
def _signed_distance(
    h: Vector, g: Vector, b: tuple[Vector, Vector, Vector], c: Vector, slack: float
) -> tuple[float, Vector, Vector, bool]:
    """Return (phi, n, p_ACa, unique) in A; the unit n points out of A."""
    phi, n, axis, unique = _separating_axis(h, g, b, c, slack)
    if phi <= -slack:
        p, _ = _witness_on_first(h, g, b, c, phi, n, axis, slack)
        return phi, n, p, unique
    p_CaCb, p_ACa = closest_points(h, g, b, c, max(phi, 0.0) + slack)
    distance, direction = length_and_direction(p_CaCb)
    apart, clear = distance > slack, distance > CLEAR_SEPARATION * slack
    if apart and distance > phi + slack:
        return distance, direction, p_ACa, clear
    # The axis separates as widely as the closest points, so it is the normal. The exception are
    # faces that are nearly parallel, whose distance differs from the axis's only by rounding.
    p, miss = _witness_on_first(h, g, b, c, phi, n, axis, slack)
    if apart and miss > 4.0 * slack:
        return distance, direction, p_ACa, clear
    turned = norm(sub(p_CaCb, scale(phi, n))) > ALONG_AXIS * distance
    return phi, n, p, clear or (unique and not (apart and turned))


@compiled
def box_box(A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats) -> None:
    """Write the signed distance of two boxes."""
    h, g = vector_at(A.shape, 0), vector_at(B.shape, 0)
    c = unrotate(A.R_W, vector_at(p_AB_W, 0))
    b = (
        unrotate(A.R_W, column(B.R_W, 0)),
        unrotate(A.R_W, column(B.R_W, 1)),
        unrotate(A.R_W, column(B.R_W, 2)),
    )
    extent = norm(h) + norm(g) + norm(c)
    phi, n, p_ACa, unique = _signed_distance(h, g, b, c, TIE * extent)
    write(
        out,
        phi,
        rotate(A.R_W, scale(-1.0, n)),
        rotate(A.R_W, p_ACa),
        rotate(A.R_W, add_scaled(p_ACa, phi, n)),
        CLOSED_FORM_ROUNDING * extent,
        unique,
        CLOSED_FORM,
    )
