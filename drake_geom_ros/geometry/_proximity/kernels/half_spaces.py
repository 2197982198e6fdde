"""Box, capsule, cylinder and ellipsoid (A) against a half space (B).

The normal is the z axis of B, always; the distance is that of A's lowest point, which the support
function gives. Where A stands on a face or lies on an edge, the witness is the midpoint of that
lowest face or edge.
"""

import math

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.kernels.calling import CLOSED_FORM, write
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    column,
    dot,
    norm,
    rotate,
    unrotate,
)
from drake_geom_ros.geometry._proximity.tolerances import CLOSED_FORM_ROUNDING, RIGHT_ANGLE


@compiled
def _lowest(n, half):
    """Return where on [-half, half] an axis that rises by n a metre is lowest: mid if level."""
    if n > RIGHT_ANGLE:
        return -half
    if n < -RIGHT_ANGLE:
        return half
    return 0.0


@compiled
def _write(out, R_WA, R_WB, p_AB_W, size, depth, p_ACa):
    """Fill the row, A's lowest point Ca (in A) being ``depth`` [m] below Ao."""
    nhat_BA_W = column(R_WB, 2)
    p_AB_W = (p_AB_W[0], p_AB_W[1], p_AB_W[2])
    distance = -dot(p_AB_W, nhat_BA_W) - depth
    p_ACa_W = rotate(R_WA, p_ACa)
    p_ACb_W = add_scaled(p_ACa_W, -distance, nhat_BA_W)
    bound = CLOSED_FORM_ROUNDING * (size + norm(p_AB_W))
    write(out, distance, nhat_BA_W, p_ACa_W, p_ACb_W, bound, True, CLOSED_FORM)


@compiled
def box_half_space(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB_W, tolerance, cutoff, out):
    """Signed distance of a box and a half space."""
    n = unrotate(R_WA, column(R_WB, 2))
    h = (shape_A[0], shape_A[1], shape_A[2])
    depth = h[0] * abs(n[0]) + h[1] * abs(n[1]) + h[2] * abs(n[2])
    p_ACa = (_lowest(n[0], h[0]), _lowest(n[1], h[1]), _lowest(n[2], h[2]))
    _write(out, R_WA, R_WB, p_AB_W, norm(h), depth, p_ACa)


@compiled
def capsule_half_space(
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB_W, tolerance, cutoff, out
):
    """Signed distance of a capsule and a half space."""
    n = unrotate(R_WA, column(R_WB, 2))
    radius, half = shape_A[0], shape_A[1]
    p_ACa = (-radius * n[0], -radius * n[1], _lowest(n[2], half) - radius * n[2])
    depth = half * abs(n[2]) + radius
    _write(out, R_WA, R_WB, p_AB_W, radius + half, depth, p_ACa)


@compiled
def cylinder_half_space(
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB_W, tolerance, cutoff, out
):
    """Signed distance of a cylinder and a half space."""
    n = unrotate(R_WA, column(R_WB, 2))
    radius, half = shape_A[0], shape_A[1]
    across = math.sqrt(n[0] * n[0] + n[1] * n[1])
    reach = radius / across if across > RIGHT_ANGLE else 0.0
    p_ACa = (-reach * n[0], -reach * n[1], _lowest(n[2], half))
    depth = half * abs(n[2]) + radius * across
    _write(out, R_WA, R_WB, p_AB_W, radius + half, depth, p_ACa)


@compiled
def ellipsoid_half_space(
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB_W, tolerance, cutoff, out
):
    """Signed distance of an ellipsoid and a half space."""
    n = unrotate(R_WA, column(R_WB, 2))
    e = (shape_A[0], shape_A[1], shape_A[2])
    v = (e[0] * n[0], e[1] * n[1], e[2] * n[2])
    depth = norm(v)
    p_ACa = (-e[0] * (v[0] / depth), -e[1] * (v[1] / depth), -e[2] * (v[2] / depth))
    _write(out, R_WA, R_WB, p_AB_W, max(e), depth, p_ACa)
