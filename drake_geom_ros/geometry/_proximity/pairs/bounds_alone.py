"""Distance of a pair from bounding volumes alone: the level `bound`."""

from __future__ import annotations

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    NORMAL,
    WITNESS_A,
    WITNESS_B,
    write,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.bounds import (
    PosedShape,
    has_hull,
    point_inside,
    support_value,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import hull_defect, hull_radius
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import is_map
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    column,
    dot,
    norm,
    scale,
    sub,
    unit,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, HALF_SPACE, SPHERE
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import BoundedBodies, least_possible
from drake_geom_ros.geometry._proximity.pairs.slots import Shapes
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part, row
from drake_geom_ros.geometry._proximity.tolerances import EPS


@inlined
def bound_pair(
    a: int,
    b: int,
    shapes: Shapes,
    R_WGs: Floats,
    p_WGs: Floats,
    inner: Floats,
    p_AB_W: Floats,
    out: Floats,
) -> None:
    """Write a pair's answer from the support values along the line of the centres."""
    types, starts, pool = shapes
    for c in range(3):
        p_AB_W[c] = p_WGs[b, c] - p_WGs[a, c]
    shape_a, shape_b = part(pool, starts[a], starts[a + 1]), part(pool, starts[b], starts[b + 1])
    A = PosedShape(types[a], shape_a, row(R_WGs, a), inner[a])
    B = PosedShape(types[b], shape_b, row(R_WGs, b), inner[b])
    bounding_interval(A, B, p_AB_W, out)


@compiled
def raise_lower_end(a: int, b: int, bodies: BoundedBodies, out: Floats) -> None:
    """Raise the lower end of a pair's interval to the bound from boxes and balls, if higher.

    So no bounding volume is sharper than the answer. The witness point on B moves with it.
    """
    if bodies.types[a] == SPHERE and bodies.types[b] == SPHERE:
        return  # their interval is only as wide as rounding
    least = least_possible(a, b, bodies)
    lower, upper = out[DISTANCE] - out[ERROR_BOUND], out[DISTANCE] + out[ERROR_BOUND]
    if not least > lower:
        return
    upper = max(least, upper)
    out[DISTANCE] = least + 0.5 * (upper - least)
    # Each of these sums, and of those that make the ends again, is rounded by EPS of it at most.
    out[ERROR_BOUND] = 0.5 * (upper - least) + 4.0 * EPS * (abs(least) + abs(upper))
    for c in range(3):
        out[WITNESS_B + c] = out[WITNESS_A + c] - out[DISTANCE] * out[NORMAL + c]


@inlined
def _reach(kind: int, shape: Floats, h: float) -> float:
    """Return the size [m] of the terms that a support value h is the sum of.

    The vertices of a hull can be near Go along n and yet far from it sideways.
    """
    return hull_radius(shape) if has_hull(kind) else h


@compiled
def bounding_interval(A: PosedShape, B: PosedShape, p_AB_W: Floats, out: Floats) -> None:
    """Write the middle and the half width of a certified interval of phi from bounds alone.

    Lower end: for every unit n, ``phi >= -h_A(n) - h_B(-n)``. Here n is along the line of the
    centres, or along the normal of a half space, where the bound is the exact value. A map is the
    exception: its support value is that of the box around it. Upper end: phi is at most the
    distance of the inner balls; that of a hull is its vertex towards the other body. Over a half
    space it is the height of the inner ball. The witness points lie on the two supporting planes,
    above Ao.
    """
    p = vector_at(p_AB_W, 0)
    flat = A.kind == HALF_SPACE or B.kind == HALF_SPACE
    if A.kind == HALF_SPACE:
        n_AB_W = column(A.R_WG, 2)
    elif B.kind == HALF_SPACE:
        n_AB_W = scale(-1.0, column(B.R_WG, 2))
    else:
        n_AB_W = unit(p)
        if dot(n_AB_W, n_AB_W) == 0.0:
            n_AB_W = column(A.R_WG, 0)
    h_A, h_B = 0.0, 0.0
    if A.kind != HALF_SPACE:
        h_A = support_value(A.kind, A.shape, unrotate(A.R_WG, n_AB_W))
    if B.kind != HALF_SPACE:
        h_B = support_value(B.kind, B.shape, scale(-1.0, unrotate(B.R_WG, n_AB_W)))
    lower = dot(n_AB_W, p) - h_A - h_B
    upper = lower
    if not flat or is_map(A.kind) or is_map(B.kind):
        a = point_inside(A.kind, A.shape, A.R_WG, n_AB_W)
        b = point_inside(B.kind, B.shape, B.R_WG, scale(-1.0, n_AB_W))
        p_ab_W = sub(add(p, b), a)
        apart = dot(n_AB_W, p_ab_W) if flat else norm(p_ab_W)
        upper = max(lower, apart - A.inner_radius - B.inner_radius)
    distance = lower + 0.5 * (upper - lower)
    p_ACa_W = scale(h_A, n_AB_W)
    p_ACb_W = add_scaled(p_ACa_W, distance, n_AB_W)
    reaches = _reach(A.kind, A.shape, h_A) + _reach(B.kind, B.shape, h_B)
    rounding = 8.0 * EPS * (norm(p) + reaches)
    for kind, shape in ((A.kind, A.shape), (B.kind, B.shape)):
        if has_hull(kind):  # its support value is rounded up by that much
            rounding += hull_defect(shape)
    bound = 0.5 * (upper - lower) + rounding
    write(out, distance, scale(-1.0, n_AB_W), p_ACa_W, p_ACb_W, bound, False, BOUND_ONLY)
