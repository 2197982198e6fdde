"""Point queries: each point as a ball without radius, through the kernels of spheres."""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry._proximity.compiled import compiled, inlined
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
from drake_geom_ros.geometry._proximity.pair_table import SPHERE
from drake_geom_ros.geometry._proximity.tolerances import EPS

# Columns of a row of a point query.
POINT_DISTANCE = 0
POINT_GRADIENT = 1  # 3: grad_W
POINT_NEAREST = 4  # 3: p_GN
POINT_ERROR_BOUND = 7
POINT_UNIQUE = 8
POINT_METHOD = 9
POINT_WIDTH = 10


@compiled
def point_phase(  # type: ignore[no-untyped-def]
    addresses, rows, types, p_WQs, scene, outer, threshold, results, points, geometries
):
    """Call the kernel of a sphere without radius for each point and geometry within reach.

    ``rows`` (n,) holds the table row of SPHERE against each geometry, ``scene`` is starts, pool,
    R_WGs and p_WGs. Returns how many of ``results``, ``points`` and ``geometries`` were filled, in
    the order of points, then ids.
    """
    starts, pool, R_WGs, p_WGs = scene
    nothing, identity = np.zeros(1), np.eye(3)
    p_QG_W, out = np.empty(3), np.zeros(PAIR_WIDTH)
    count = 0
    for q in range(p_WQs.shape[0]):
        for g in range(rows.size):
            squared, reach = 0.0, 0.0
            for c in range(3):
                p_QG_W[c] = p_WGs[g, c] - p_WQs[q, c]
                squared += p_QG_W[c] * p_QG_W[c]
                reach = max(reach, abs(p_WQs[q, c]), abs(p_WGs[g, c]))
            rounding = 8.0 * EPS * reach
            if math.sqrt(squared) - outer[g] > threshold + rounding:
                continue
            out[NORMAL], out[NORMAL + 1], out[NORMAL + 2] = 0.0, 0.0, 0.0
            call_kernel(  # type: ignore[no-untyped-call]
                addresses[rows[g]],
                SPHERE,
                nothing,
                identity,
                types[g],
                pool[starts[g] : starts[g + 1]],
                R_WGs[g],
                p_QG_W,
                0.0,
                math.inf,
                out,
            )
            if out[DISTANCE] > threshold:
                continue
            points[count], geometries[count] = q, g
            _write(results, count, out, R_WGs, g, p_QG_W, rounding)
            count += 1
    return count


@inlined
def _write(results, k, out, R_WGs, g, p_QG_W, rounding):  # type: ignore[no-untyped-def]
    """Fill a row; the kernel's A is the point, so its witnesses are measured from that."""
    results[k, POINT_DISTANCE] = out[DISTANCE]
    results[k, POINT_ERROR_BOUND] = out[ERROR_BOUND] + rounding
    results[k, POINT_UNIQUE] = out[UNIQUE]
    results[k, POINT_METHOD] = out[METHOD]
    x, y, z = (
        out[WITNESS_B] - p_QG_W[0],
        out[WITNESS_B + 1] - p_QG_W[1],
        out[WITNESS_B + 2] - p_QG_W[2],
    )
    for c in range(3):
        results[k, POINT_GRADIENT + c] = out[NORMAL + c]
        turned = R_WGs[g, 0, c] * x + R_WGs[g, 1, c] * y + R_WGs[g, 2, c] * z
        results[k, POINT_NEAREST + c] = turned
