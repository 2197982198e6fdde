"""Axes of two shapes as candidate normals, where symmetric positions have their least depth.

The axes of A and B and their cross products contain the answer of most aligned pairs. These are
the pairs where an iteration finds several equal minima, or a difference without volume. Any normal
bounds the depth from above (``phi = max over n`` in the conventions), so trying one is always
valid. The set is not complete, so the lower bound stays unchanged.
"""

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import support_points
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kernels.vectors import column, cross, dot, scale, sub, unit
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.tolerances import RIGHT_ANGLE


@compiled
def candidate(R_WA: Floats, R_WB: Floats, k: int) -> Vector:
    """Return the k-th of 15 normals: axes of A, of B, cross products; (0, 0, 0) if parallel."""
    if k < 3:
        return column(R_WA, k)
    if k < 6:
        return column(R_WB, k - 3)
    return unit(cross(column(R_WA, (k - 6) // 3), column(R_WB, (k - 6) % 3)))


@compiled
def least_along_axes(pair: CorePair, best: float) -> tuple[float, Vector, Vector, Vector]:
    """Return (h, n, a, b): the least width of the overlap along an axis, if below ``best``.

    Points a and b are midpoints of the features extreme along n. If no axis is better, h is
    ``best``.
    """
    R_WA, R_WB = pair.R_WA, pair.R_WB
    h, normal = best, (0.0, 0.0, 0.0)
    for k in range(15):
        m = candidate(R_WA, R_WB, k)
        if dot(m, m) < 0.5:
            continue
        for turn in range(2):
            n = scale(1.0 - 2.0 * turn, m)
            a, b = support_points(pair, n, 0.0)
            width = dot(sub(a, b), n)
            if width < h:
                h, normal = width, n
    a, b = support_points(pair, normal, RIGHT_ANGLE)
    return h, normal, a, b
