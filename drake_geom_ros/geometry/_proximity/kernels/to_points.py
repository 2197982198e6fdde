"""A geometry against many points: kernels that hold the loop over the points.

Their arguments stand in ``calling_points``. A call a point takes as long as the closed form of a
sphere or box, and hides one point's divisions from the next's; so does turning the witness from G
into World and back.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.kernels.calling import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    PAIR_WIDTH,
    UNIQUE,
    WITNESS_B,
    call_kernel,
)
from drake_geom_ros.geometry._proximity.kernels.calling_points import put_point, seen, take
from drake_geom_ros.geometry._proximity.kernels.ellipsoid_point import ellipsoid_point
from drake_geom_ros.geometry._proximity.kernels.points import (
    box_point,
    capsule_point,
    cylinder_point,
    half_space_point,
    sphere_point,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import norm, sub, unrotate
from drake_geom_ros.geometry._proximity.kinds import SPHERE
from drake_geom_ros.geometry._proximity.tolerances import TIE


@compiled
def to_sphere(address, kind, shape, R_WG, p_WG, p_WQs, threshold, ball, span, rows, found, counts):
    """Signed distance of points to a sphere."""
    first, last, g, n = span
    radius = shape[0]
    for k in range(first, last):
        near, q, rounding = seen(R_WG, p_WG, p_WQs, k, threshold, ball)
        if near:
            extent = radius + norm(q)
            result = sphere_point(radius, q, TIE * extent)
            take(rows, found, counts, k * n + g, R_WG, threshold, extent, rounding, result)


@compiled
def to_box(address, kind, shape, R_WG, p_WG, p_WQs, threshold, ball, span, rows, found, counts):
    """Signed distance of points to a box."""
    first, last, g, n = span
    h = shape[0], shape[1], shape[2]
    for k in range(first, last):
        near, q, rounding = seen(R_WG, p_WG, p_WQs, k, threshold, ball)
        if near:
            extent = norm(h) + norm(q)
            result = box_point(h, q, TIE * extent)
            take(rows, found, counts, k * n + g, R_WG, threshold, extent, rounding, result)


@compiled
def to_capsule(
    address, kind, shape, R_WG, p_WG, p_WQs, threshold, ball, span, rows, found, counts
):
    """Signed distance of points to a capsule."""
    first, last, g, n = span
    radius, half_length = shape[0], shape[1]
    for k in range(first, last):
        near, q, rounding = seen(R_WG, p_WG, p_WQs, k, threshold, ball)
        if near:
            extent = radius + half_length + norm(q)
            result = capsule_point(radius, half_length, q, TIE * extent)
            take(rows, found, counts, k * n + g, R_WG, threshold, extent, rounding, result)


@compiled
def to_cylinder(
    address, kind, shape, R_WG, p_WG, p_WQs, threshold, ball, span, rows, found, counts
):
    """Signed distance of points to a cylinder."""
    first, last, g, n = span
    radius, half_length = shape[0], shape[1]
    for k in range(first, last):
        near, q, rounding = seen(R_WG, p_WG, p_WQs, k, threshold, ball)
        if near:
            extent = radius + half_length + norm(q)
            result = cylinder_point(radius, half_length, q, TIE * extent)
            take(rows, found, counts, k * n + g, R_WG, threshold, extent, rounding, result)


@compiled
def to_ellipsoid(
    address, kind, shape, R_WG, p_WG, p_WQs, threshold, ball, span, rows, found, counts
):
    """Signed distance of points to an ellipsoid."""
    first, last, g, n = span
    e = shape[0], shape[1], shape[2]
    for k in range(first, last):
        near, q, rounding = seen(R_WG, p_WG, p_WQs, k, threshold, ball)
        if near:
            extent = max(e) + norm(q)
            result = ellipsoid_point(e, q, TIE * extent)
            take(rows, found, counts, k * n + g, R_WG, threshold, extent, rounding, result)


@compiled
def to_half_space(
    address, kind, shape, R_WG, p_WG, p_WQs, threshold, ball, span, rows, found, counts
):
    """Signed distance of points to a half space."""
    first, last, g, n = span
    for k in range(first, last):
        near, q, rounding = seen(R_WG, p_WG, p_WQs, k, threshold, ball)
        if near:
            extent = norm(q)
            rounding += ball[2] * extent
            result = half_space_point(q)
            take(rows, found, counts, k * n + g, R_WG, threshold, extent, rounding, result)


@compiled
def by_pair_kernel(
    address, kind, shape, R_WG, p_WG, p_WQs, threshold, ball, span, rows, found, counts
):
    """Signed distance of points to a shape without a closed form: spheres without radius."""
    first, last, g, n = span
    nothing, identity = np.zeros(1), np.eye(3)
    p_QG_W, out = np.empty(3), np.zeros(PAIR_WIDTH)
    for k in range(first, last):
        near, _, rounding = seen(R_WG, p_WG, p_WQs, k, threshold, ball)
        if not near:
            continue
        for c in range(3):
            p_QG_W[c] = p_WG[c] - p_WQs[k, c]
            out[NORMAL + c] = 0.0
        call_kernel(
            address,
            SPHERE,
            nothing,
            identity,
            kind,
            shape,
            R_WG,
            p_QG_W,
            0.0,
            math.inf,
            out,
        )
        if out[DISTANCE] <= threshold:
            # The witness on G is measured from the point.
            p_QN_W = out[WITNESS_B], out[WITNESS_B + 1], out[WITNESS_B + 2]
            p_GN = unrotate(R_WG, sub(p_QN_W, (p_QG_W[0], p_QG_W[1], p_QG_W[2])))
            grad_W = out[NORMAL], out[NORMAL + 1], out[NORMAL + 2]
            bound, unique = out[ERROR_BOUND] + rounding, out[UNIQUE] > 0.0
            put_point(rows, k * n + g, out[DISTANCE], grad_W, p_GN, bound, unique, out[METHOD])
            found[k * n + g] = True
            counts[int(out[METHOD])] += 1
