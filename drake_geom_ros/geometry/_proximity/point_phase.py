"""Point queries: each point as a ball without radius, through the kernels of spheres."""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.kernels.calling import (
    DISTANCE,
    ERROR_BOUND,
    call_kernel,
)
from drake_geom_ros.geometry._proximity.pair_table import SPHERE
from drake_geom_ros.geometry._proximity.tolerances import EPS


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
    p_QG_W = np.empty(3)
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
            out = results[count]
            out[:] = 0.0
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
            if out[DISTANCE] <= threshold:
                out[ERROR_BOUND] += rounding
                points[count], geometries[count] = q, g
                count += 1
    return count
