"""Caps of directions in which two cores overlap by at least a given depth, from balls inside them.

A ball in A and one in B give a ball in D = A - B, with centre c and radius R. So h(u) is at least
``c . u + R`` for any unit u: where ``c . u >= rival - R``, the overlap is at least ``rival`` wide.
That is a cap of directions (see ``caps``), usually more than half of them, because the balls are
behind the contact. EPA need not grow there.
"""

import math
from typing import NamedTuple

from drake_geom_ros.geometry._proximity.kernels.cores.polytope import OFFSET
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kernels.shapes.bounds import inner_radius
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import ball_in_hull
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import core_radius
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    dot,
    norm,
    rotate,
    sub,
    vector_in,
)
from drake_geom_ros.geometry._proximity.kinds import CONVEX
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Integers32, Vector, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined


class Ball(NamedTuple):
    """A ball in a difference of cores: centre, the centre's distance from 0, radius [m]."""

    centre: Vector
    away: float
    radius: float


@inlined
def ball_in_core(kind: int, shape: Floats) -> tuple[Vector, float]:
    """Return (centre, radius) [m] of a ball in a core; the radius is -infinity if unknown."""
    if kind == CONVEX:
        centre, radius = ball_in_hull(shape)
        return centre, radius if radius > 0.0 else -math.inf
    return (0.0, 0.0, 0.0), inner_radius(kind, shape) - core_radius(kind, shape)


@compiled
def ball_in_difference(pair: CorePair) -> Ball:
    """Return the ball in the difference of two cores; the radius is -infinity if unknown."""
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p = pair
    a, r_A = ball_in_core(kind_A, shape_A)
    b, r_B = ball_in_core(kind_B, shape_B)
    c = sub(rotate(R_WA, a), add(p, rotate(R_WB, b)))
    return Ball(c, norm(c), r_A + r_B)


@inlined
def is_cap_of_ball(
    x: Vector, y: Vector, z: Vector, n: Vector, offset: float, ball: Ball, rival: float
) -> bool:
    """Return whether the ball proves h >= ``rival`` in all directions where a face is nearer.

    The face has the corners x, y, z and a plane. A point p of it is covered if ``c . p >=
    (rival - R) |p|``. The whole face is covered if its corners are, or by its offset: the face is
    nearer only within an angle y of its normal, ``cos y = offset / rival``, and the cap reaches to
    the angle z from c, ``cos z = (rival - R) / |c|``. Faces with the origin in front of them are
    never covered.
    """
    edge, away = rival - ball.radius, ball.away
    if offset <= 0.0 or edge >= away:
        return False
    c = ball.centre
    least = min(dot(c, x), dot(c, y), dot(c, z))
    if least >= edge * (min(offset, rival) if edge <= 0.0 else rival):
        return True
    near = offset / rival
    if near >= 1.0:
        return True
    if edge > near * away or edge <= -away:
        return False
    sines = math.sqrt((away - edge) * (away + edge) * (1.0 - near) * (1.0 + near))
    return dot(c, n) >= edge * near + sines


@inlined
def is_in_ball_cap(
    points: Floats, faces: Integers32, planes: Floats, f: int, ball: Ball, rival: float
) -> bool:
    """Return whether face f of a ``polytope`` is in the cap of a ball."""
    f = unsigned(f)
    return is_cap_of_ball(
        vector_in(points, faces[f, 0]),
        vector_in(points, faces[f, 1]),
        vector_in(points, faces[f, 2]),
        vector_in(planes, f),
        planes[f, OFFSET],
        ball,
        rival,
    )
