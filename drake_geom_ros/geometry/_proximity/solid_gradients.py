"""Which gradients of distances from solids are the only ones: a walk over their triangles each."""

import numpy as np

from drake_geom_ros.geometry._proximity.batches import P_ACA, P_BCB
from drake_geom_ros.geometry._proximity.compiled import allocating
from drake_geom_ros.geometry._proximity.derivatives import is_of_surfaces
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    UNIQUE,
)
from drake_geom_ros.geometry._proximity.kernels.calling.views import part, row
from drake_geom_ros.geometry._proximity.kernels.cores.supports import bounding_radius, core_radius
from drake_geom_ros.geometry._proximity.kernels.solids.tree import body_of, solid_of
from drake_geom_ros.geometry._proximity.kernels.solids.uniqueness import is_nearest_alone
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    norm,
    rotate,
    scale,
    sub,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, SOLID
from drake_geom_ros.geometry._proximity.tolerances import EPS, ROUNDING


@allocating
def _is_alone(numbers, kind_A, shape_A, R_WA, p_ACa, shape_B, R_WB, p_BCb, nhat_BA_W):  # type: ignore[no-untyped-def]
    """Tell whether the witness points of any body A and a solid B are the only ones.

    ``nhat_BA_W`` points out of B into A.
    """
    R = np.empty((3, 3))
    for j in range(3):
        R[0, j], R[1, j], R[2, j] = unrotate(R_WB, (R_WA[0, j], R_WA[1, j], R_WA[2, j]))
    n = scale(-1.0, unrotate(R_WB, nhat_BA_W))
    p = sub(add_scaled(p_BCb, -numbers[DISTANCE], n), rotate(R, p_ACa))
    size = bounding_radius(kind_A, shape_A) + bounding_radius(SOLID, shape_B) + norm(p)
    limit = numbers[DISTANCE] + core_radius(kind_A, shape_A) + numbers[ERROR_BOUND]
    A, B = body_of(kind_A, shape_A, R), solid_of(shape_B)
    return is_nearest_alone(A, B, p, n, size, limit + ROUNDING * EPS * size)


@allocating
def find_unique_of_solids(rows, places, scene, unique):  # type: ignore[no-untyped-def]
    """Fill ``unique`` (k,) where a pair is of surfaces, as ``pair_gradients`` does elsewhere.

    Only what is apart can be unique: of the ways out of an overlap nobody knows that there is no
    other one as short.
    """
    types, starts, pool, R_WGs = scene
    for k in range(places.shape[0]):
        a, b = places[k, 0], places[k, 1]
        if not is_of_surfaces(types[a], types[b]):
            continue
        numbers = row(rows, k)
        sure = numbers[UNIQUE] != 0.0 and numbers[METHOD] != BOUND_ONLY
        unique[k] = sure and numbers[DISTANCE] > numbers[ERROR_BOUND]
        if not unique[k]:
            continue
        n, p, q = vector_at(numbers, NORMAL), vector_at(numbers, P_ACA), vector_at(numbers, P_BCB)
        if types[b] != SOLID:  # the other way around
            a, b, n, p, q = b, a, scale(-1.0, n), q, p
        A, B = part(pool, starts[a], starts[a + 1]), part(pool, starts[b], starts[b + 1])
        unique[k] = _is_alone(numbers, types[a], A, row(R_WGs, a), p, B, row(R_WGs, b), q, n)
