"""Calling convention of point kernels: one result layout, one signature, common steps.

Conventions::

    kernel(address, kind, body, p_WQs, threshold, span, answers)

========== ========================================================================
address    of the pair kernel of a sphere and this shape, for ``by_pair_kernel``
kind       shape type number
body       the posed geometry, see ``PointedBody``
p_WQs      points (m, 3) [m]
threshold  [m] points certified to be farther away are omitted
span       the range of points to answer, and their rows, see ``Span``
answers    arrays of the answers, see ``PointAnswers``
========== ========================================================================
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.vectors import norm, rotate, unrotate
from drake_geom_ros.geometry._proximity.kinds import CLOSED_FORM
from drake_geom_ros.geometry._proximity.runtime.addresses import caller
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined
from drake_geom_ros.geometry._proximity.tolerances import CLOSED_FORM_ROUNDING, EPS

Floats = NDArray[np.float64]

# Columns of a row of a point query.
POINT_DISTANCE = 0
POINT_GRADIENT = 1  # 3: grad_W
POINT_NEAREST = 4  # 3: p_GN
POINT_ERROR_BOUND = 7
POINT_UNIQUE = 8
POINT_METHOD = 9
POINT_WIDTH = 10


class PointedBody(NamedTuple):
    """A geometry G with its pose, its outer radius, and the rounding of its pose."""

    shape: Floats  # parameters
    R_WG: Floats
    p_WG: Floats  # [m]
    outer: float  # [m] outer radius about Go
    rounding: float  # [m] of the pose, see ``pose_rounding``
    tilt: float  # [-] rounding of a half space's normal; 0 for all others


class Span(NamedTuple):
    """The points first to last - 1; the answer of point k goes to row k n + g."""

    first: int
    last: int
    g: int
    n: int


class PointAnswers(NamedTuple):
    """Arrays that point kernels fill."""

    rows: Floats  # (m n, POINT_WIDTH)
    is_within: NDArray[np.bool_]  # (m n,) set to True where there is an answer
    counts: NDArray[np.int64]  # numbers of answers by METHOD


_vector, _matrix = types.float64[::1], types.float64[:, ::1]
POINTS_SIGNATURE = types.void(
    types.intp,
    types.int64,
    types.NamedTuple([_vector, _matrix, _vector, *[types.float64] * 3], PointedBody),
    _matrix,
    types.float64,
    types.NamedUniTuple(types.int64, 4, Span),
    types.NamedTuple([_matrix, types.boolean[::1], types.int64[::1]], PointAnswers),
)
call_points_kernel = caller(POINTS_SIGNATURE)


@inlined
def seen(body: PointedBody, p_WQs: Floats, k: int, threshold: float) -> tuple[bool, Vector, float]:
    """Return (near, q, rounding): whether G may be within the threshold, p_GQ, its rounding [m].

    The rounding includes that of the pose and of the difference.
    """
    p_WG = body.p_WG
    p_GQ_W = p_WQs[k, 0] - p_WG[0], p_WQs[k, 1] - p_WG[1], p_WQs[k, 2] - p_WG[2]
    limit = threshold + body.outer
    point = max(abs(p_WQs[k, 0]), abs(p_WQs[k, 1]), abs(p_WQs[k, 2]))
    rounding = body.rounding + 8.0 * EPS * point
    near = limit == math.inf or norm(p_GQ_W) <= limit + rounding
    return near, unrotate(body.R_WG, p_GQ_W), rounding


@inlined
def put_point(
    rows: Floats,
    k: int,
    distance: float,
    grad_W: Vector,
    p_GN: Vector,
    bound: float,
    unique: bool,
    method: float,
) -> None:
    """Write a result row."""
    rows[k, POINT_DISTANCE] = distance
    rows[k, POINT_ERROR_BOUND] = bound
    rows[k, POINT_UNIQUE] = 1.0 if unique else 0.0
    rows[k, POINT_METHOD] = method
    for c in range(3):
        rows[k, POINT_GRADIENT + c] = grad_W[c]
        rows[k, POINT_NEAREST + c] = p_GN[c]


@inlined
def take(
    answers: PointAnswers,
    k: int,
    body: PointedBody,
    threshold: float,
    size: float,
    rounding: float,
    nearest: tuple[float, Vector, Vector, bool],
) -> None:
    """Write row k from a closed form in G, if it may be within the threshold."""
    distance, grad, p_GN, unique = nearest
    bound = CLOSED_FORM_ROUNDING * size + rounding
    if distance - bound <= threshold:
        grad_W = rotate(body.R_WG, grad)
        put_point(answers.rows, k, distance, grad_W, p_GN, bound, unique, CLOSED_FORM)
        answers.is_within[k] = True
        answers.counts[CLOSED_FORM] += 1
