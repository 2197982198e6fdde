"""Uniqueness of the gradients of distances from solids, by a tree walk over the triangles."""

import numpy as np

from drake_geom_ros.geometry._proximity.derivatives.surfaces import Scene, is_of_surfaces
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    UNIQUE,
    OrientedShape,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import is_map
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import bounding_radius, core_radius
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    SolidPair,
    body_of,
    noise_of,
    solid_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.uniqueness import (
    is_nearest_alone,
    is_separating_move_unique,
)
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
from drake_geom_ros.geometry._proximity.pairs.answer_rows import P_ACA, P_BCB
from drake_geom_ros.geometry._proximity.runtime.arrays import Booleans, Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating
from drake_geom_ros.geometry._proximity.runtime.views import part, row


@allocating
def _is_alone(
    numbers: Floats,
    shaped_A: OrientedShape,
    p_ACa: Vector,
    solid_B: OrientedShape,
    p_BCb: Vector,
    nhat_BA_W: Vector,
) -> bool:
    """Return whether the witness points of a body A of any kind and a solid B are unique.

    ``nhat_BA_W`` points out of B into A.
    """
    kind_A, shape_A, R_WA = shaped_A
    _, shape_B, R_WB = solid_B
    R = np.empty((3, 3))
    for j in range(3):
        R[0, j], R[1, j], R[2, j] = unrotate(R_WB, (R_WA[0, j], R_WA[1, j], R_WA[2, j]))
    m, distance, error = unrotate(R_WB, nhat_BA_W), numbers[DISTANCE], numbers[ERROR_BOUND]
    q = add_scaled(p_BCb, distance, m)
    p = sub(q, rotate(R, p_ACa))
    size = bounding_radius(kind_A, shape_A) + bounding_radius(SOLID, shape_B) + norm(p)
    A, B, radius = body_of(kind_A, shape_A, R), solid_of(shape_B), core_radius(kind_A, shape_A)
    pair = SolidPair(A, B, p, size, 0.0, radius)
    if distance < 0.0:
        return is_separating_move_unique(pair, q, m, -distance, error)
    limit = distance + radius + error + noise_of(pair)
    return is_nearest_alone(pair, scale(-1.0, m), limit)[0]


@allocating
def find_unique_of_solids(rows: Floats, places: Indices, scene: Scene, unique: Booleans) -> None:
    """Fill ``unique`` (k,) for pairs of surfaces, which ``pair_gradients`` leaves open.

    Bodies that touch count as not unique, since nothing can be certified of them.
    """
    types, starts, pool, R_WGs = scene
    for k in range(places.shape[0]):
        a, b = places[k, 0], places[k, 1]
        if not is_of_surfaces(types[a], types[b]):
            continue
        if is_map(max(types[a], types[b])):
            unique[k] = False  # the cells of a map are not examined
            continue
        numbers = row(rows, k)
        far, sure = abs(numbers[DISTANCE]) > numbers[ERROR_BOUND], numbers[METHOD] != BOUND_ONLY
        # Uniqueness of an overlap's normal follows from its separating translation, below.
        unique[k] = far and sure and (numbers[UNIQUE] != 0.0 or numbers[DISTANCE] < 0.0)
        if not unique[k]:
            continue
        n, p, q = vector_at(numbers, NORMAL), vector_at(numbers, P_ACA), vector_at(numbers, P_BCB)
        A = OrientedShape(types[a], part(pool, starts[a], starts[a + 1]), row(R_WGs, a))
        B = OrientedShape(types[b], part(pool, starts[b], starts[b + 1]), row(R_WGs, b))
        # Either solid can be the one whose surface decides.
        unique[k] = types[b] == SOLID and _is_alone(numbers, A, p, B, q, n)
        if not unique[k] and types[a] == SOLID:
            unique[k] = _is_alone(numbers, B, q, A, p, scale(-1.0, n))
