"""How kernels of many points are called: one result layout, one signature, common first lines.

Conventions::

    kernel(address, kind, shape, R_WG, p_WG, p_WQs, threshold, ball, span, rows, found, counts)

========== ========================================================================
address    of the pair kernel of a sphere and this shape, for ``by_pair_kernel``
kind       shape type number, shape: its parameters, R_WG, p_WG: its pose
p_WQs      points (m, 3) [m]
threshold  [m] what is farther away is left out
ball       how far G reaches, see ``Ball``
span       which points to answer, and where, see ``Span``
rows       (m n, POINT_WIDTH) answers, found: (m n,) becomes True where there is one
counts     by METHOD, how many answers there were
========== ========================================================================
"""

import math
from typing import NamedTuple

from numba import types

from drake_geom_ros.geometry._proximity.compiled import inlined
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import caller
from drake_geom_ros.geometry._proximity.kernels.vectors import norm, rotate, unrotate
from drake_geom_ros.geometry._proximity.kinds import CLOSED_FORM
from drake_geom_ros.geometry._proximity.tolerances import CLOSED_FORM_ROUNDING, EPS

# Columns of a row of a point query.
POINT_DISTANCE = 0
POINT_GRADIENT = 1  # 3: grad_W
POINT_NEAREST = 4  # 3: p_GN
POINT_ERROR_BOUND = 7
POINT_UNIQUE = 8
POINT_METHOD = 9
POINT_WIDTH = 10


class Ball(NamedTuple):
    """How far a geometry reaches about Go [m], and how far off its pose is (``pose_rounding``)."""

    outer: float
    radius: float  # [m]
    tilt: float  # [-] of a half space


class Span(NamedTuple):
    """The points first to last - 1; the answer of point k belongs into row k n + g."""

    first: int
    last: int
    g: int
    n: int


_vector, _matrix = types.float64[::1], types.float64[:, ::1]
POINTS_SIGNATURE = types.void(
    types.intp,
    types.int64,
    _vector,
    _matrix,
    _vector,
    _matrix,
    types.float64,
    types.NamedUniTuple(types.float64, 3, Ball),
    types.NamedUniTuple(types.int64, 4, Span),
    _matrix,
    types.boolean[::1],
    types.int64[::1],
)
call_points_kernel = caller(POINTS_SIGNATURE)


@inlined
def seen(R_WG, p_WG, p_WQs, k, threshold, ball):
    """Return (near, q, rounding): whether G may be within it, p_GQ, and its rounding [m].

    The rounding is that of the pose and of the difference.
    """
    p_GQ_W = p_WQs[k, 0] - p_WG[0], p_WQs[k, 1] - p_WG[1], p_WQs[k, 2] - p_WG[2]
    reach = threshold + ball.outer
    point = max(abs(p_WQs[k, 0]), abs(p_WQs[k, 1]), abs(p_WQs[k, 2]))
    rounding = ball.radius + 8.0 * EPS * point
    near = reach == math.inf or norm(p_GQ_W) <= reach + rounding
    return near, unrotate(R_WG, p_GQ_W), rounding


@inlined
def put_point(rows, k, distance, grad_W, p_GN, bound, unique, method):
    """Fill a row."""
    rows[k, POINT_DISTANCE] = distance
    rows[k, POINT_ERROR_BOUND] = bound
    rows[k, POINT_UNIQUE] = 1.0 if unique else 0.0
    rows[k, POINT_METHOD] = method
    for c in range(3):
        rows[k, POINT_GRADIENT + c] = grad_W[c]
        rows[k, POINT_NEAREST + c] = p_GN[c]


@inlined
def take(rows, found, counts, k, R_WG, threshold, size, rounding, nearest):
    """Fill a row from a closed form in G, where it is within the threshold."""
    distance, grad, p_GN, unique = nearest
    if distance <= threshold:
        bound = CLOSED_FORM_ROUNDING * size + rounding
        put_point(rows, k, distance, rotate(R_WG, grad), p_GN, bound, unique, CLOSED_FORM)
        found[k] = True
        counts[CLOSED_FORM] += 1
