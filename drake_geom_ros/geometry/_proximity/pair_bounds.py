"""A pair's answer from bounds alone: an interval that holds the signed distance, and no kernel."""

from __future__ import annotations

from drake_geom_ros.geometry._proximity.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.bounds import PosedShape, bounding_interval
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    NORMAL,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.calling.views import part, row
from drake_geom_ros.geometry._proximity.kinds import SPHERE
from drake_geom_ros.geometry._proximity.pair_gaps import least_possible
from drake_geom_ros.geometry._proximity.tolerances import EPS


@inlined
def bound_pair(a, b, types, starts, pool, R_WGs, p_WGs, inner, p_AB_W, out):  # type: ignore[no-untyped-def]
    """Write a pair's answer from the widths along the line of the centres."""
    for c in range(3):
        p_AB_W[c] = p_WGs[b, c] - p_WGs[a, c]
    shape_a, shape_b = part(pool, starts[a], starts[a + 1]), part(pool, starts[b], starts[b + 1])
    A = PosedShape(types[a], shape_a, row(R_WGs, a), inner[a])
    B = PosedShape(types[b], shape_b, row(R_WGs, b), inner[b])
    bounding_interval(A, B, p_AB_W, out)


@compiled
def raise_lower_end(a, b, types, R_WGs, p_WGs, roundings, half_extents, outer, out):  # type: ignore[no-untyped-def]
    """Raise the lower end of a pair's interval to what boxes and balls around the bodies certify.

    So none of these knows more of a pair than its answer. The witness point on B moves with it.
    """
    if types[a] == SPHERE and types[b] == SPHERE:
        return  # whose interval is as wide as rounding
    least = least_possible(a, b, types, R_WGs, p_WGs, roundings, half_extents, outer)
    lower, upper = out[DISTANCE] - out[ERROR_BOUND], out[DISTANCE] + out[ERROR_BOUND]
    if not least > lower:
        return
    upper = max(least, upper)
    out[DISTANCE] = least + 0.5 * (upper - least)
    # Each of these sums, and of those that make the ends again, is rounded by EPS of it at most.
    out[ERROR_BOUND] = 0.5 * (upper - least) + 4.0 * EPS * (abs(least) + abs(upper))
    for c in range(3):
        out[WITNESS_B + c] = out[WITNESS_A + c] - out[DISTANCE] * out[NORMAL + c]
