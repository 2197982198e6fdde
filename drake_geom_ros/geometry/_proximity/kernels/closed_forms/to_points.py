"""Point kernels: loops over many points against one geometry.

Their arguments are documented in ``calling.points``. The loop is inside the kernel because a call
per point takes as long as the closed form of a sphere or box, and prevents the divisions of
successive points from overlapping. So does rotating the witness point from G to World and back.
"""

import math
from collections.abc import Callable

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    PAIR_WIDTH,
    UNIQUE,
    WITNESS_B,
    Aim,
    OrientedShape,
    call_kernel,
)
from drake_geom_ros.geometry._proximity.kernels.calling.points import (
    PointAnswers,
    PointedBody,
    Span,
    put_point,
    seen,
    take,
)
from drake_geom_ros.geometry._proximity.kernels.closed_forms.ellipsoid_point import (
    NearestOnSurface,
    first_parameter,
    in_octant,
    last_parameter,
    nearest_at,
    step_all,
)
from drake_geom_ros.geometry._proximity.kernels.closed_forms.points import (
    at_box_edge,
    at_cylinder_rim,
    at_no_edge,
    near_box,
    near_capsule,
    near_cylinder,
    near_half_space,
    near_sphere,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import norm, sub, unrotate, vector_at
from drake_geom_ros.geometry._proximity.kinds import SPHERE
from drake_geom_ros.geometry._proximity.runtime.addresses import Address
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import TIE


@inlined
def _each(
    near_shape: Callable[[Floats, Vector], tuple[float, NearestOnSurface]],
    at_edge: Callable[[Floats, Vector, float, NearestOnSurface], NearestOnSurface],
    body: PointedBody,
    p_WQs: Floats,
    threshold: float,
    span: Span,
    answers: PointAnswers,
) -> None:
    """Answer for all points by ``points.near_<shape>`` and ``at_edge``."""
    shape, tilt = body.shape, body.tilt
    for k in range(span.first, span.last):
        near, q, rounding = seen(body, p_WQs, k, threshold)
        if near:
            size, nearest = near_shape(shape, q)
            nearest = at_edge(shape, q, TIE * size + rounding, nearest)
            rounding += tilt * size  # only of half spaces; a branch made boxes a third slower
            take(answers, k * span.n + span.g, body, threshold, size, rounding, nearest)


@compiled
def to_sphere(
    address: Address,
    kind: int,
    body: PointedBody,
    p_WQs: Floats,
    threshold: float,
    span: Span,
    answers: PointAnswers,
) -> None:
    """Write the signed distances of points to a sphere."""
    _each(near_sphere, at_no_edge, body, p_WQs, threshold, span, answers)


@compiled
def to_box(
    address: Address,
    kind: int,
    body: PointedBody,
    p_WQs: Floats,
    threshold: float,
    span: Span,
    answers: PointAnswers,
) -> None:
    """Write the signed distances of points to a box."""
    _each(near_box, at_box_edge, body, p_WQs, threshold, span, answers)


@compiled
def to_capsule(
    address: Address,
    kind: int,
    body: PointedBody,
    p_WQs: Floats,
    threshold: float,
    span: Span,
    answers: PointAnswers,
) -> None:
    """Write the signed distances of points to a capsule."""
    _each(near_capsule, at_no_edge, body, p_WQs, threshold, span, answers)


@compiled
def to_cylinder(
    address: Address,
    kind: int,
    body: PointedBody,
    p_WQs: Floats,
    threshold: float,
    span: Span,
    answers: PointAnswers,
) -> None:
    """Write the signed distances of points to a cylinder."""
    _each(near_cylinder, at_cylinder_rim, body, p_WQs, threshold, span, answers)


@allocating
def to_ellipsoid(
    address: Address,
    kind: int,
    body: PointedBody,
    p_WQs: Floats,
    threshold: float,
    span: Span,
    answers: PointAnswers,
) -> None:
    """Write the signed distances of points to an ellipsoid.

    Newton's method steps for several points at a time. Point by point, each division waited for
    the previous one, which took half of the time.
    """
    e, count = vector_at(body.shape, 0), span.last - span.first
    work = np.zeros((5, count))
    octant = in_octant(e, e)
    for i in range(count):
        near, q, _ = seen(body, p_WQs, span.first + i, threshold)
        if near:
            octant = in_octant(e, q)
            work[0, i], work[1, i], work[2, i] = octant.w
            work[3, i], work[4, i] = first_parameter(octant), 1.0
    step_all(octant.f, work)
    for i in range(count):
        k = span.first + i
        near, q, rounding = seen(body, p_WQs, k, threshold)
        if near:
            octant, extent = in_octant(e, q), max(e) + norm(q)
            u = last_parameter(octant, work[3, i]) if work[4, i] > 0.0 else work[3, i]
            nearest = nearest_at(e, q, TIE * extent, octant, u)
            take(answers, k * span.n + span.g, body, threshold, extent, rounding, nearest)


@compiled
def to_half_space(
    address: Address,
    kind: int,
    body: PointedBody,
    p_WQs: Floats,
    threshold: float,
    span: Span,
    answers: PointAnswers,
) -> None:
    """Write the signed distances of points to a half space."""
    _each(near_half_space, at_no_edge, body, p_WQs, threshold, span, answers)


@allocating
def by_pair_kernel(
    address: Address,
    kind: int,
    body: PointedBody,
    p_WQs: Floats,
    threshold: float,
    span: Span,
    answers: PointAnswers,
) -> None:
    """Write the signed distances of points as balls of radius 0, for other shapes."""
    point = OrientedShape(SPHERE, np.zeros(1), np.eye(3))
    G, aim = OrientedShape(kind, body.shape, body.R_WG), Aim(0.0, 0.0, math.inf, 0.0)
    p_QG_W, out = np.empty(3), np.zeros(PAIR_WIDTH)
    for k in range(span.first, span.last):
        near, _, rounding = seen(body, p_WQs, k, threshold)
        if not near:
            continue
        for c in range(3):
            p_QG_W[c] = body.p_WG[c] - p_WQs[k, c]
            out[NORMAL + c] = 0.0
        call_kernel(address, point, G, p_QG_W, aim, out)
        bound = out[ERROR_BOUND] + rounding
        if out[DISTANCE] - bound <= threshold:
            # The witness on G is measured from the point.
            p_QN_W = vector_at(out, WITNESS_B)
            p_GN = unrotate(body.R_WG, sub(p_QN_W, vector_at(p_QG_W, 0)))
            grad_W = vector_at(out, NORMAL)
            unique, at = out[UNIQUE] > 0.0, k * span.n + span.g
            put_point(answers.rows, at, out[DISTANCE], grad_W, p_GN, bound, unique, out[METHOD])
            answers.is_within[at] = True
            answers.counts[int(out[METHOD])] += 1
