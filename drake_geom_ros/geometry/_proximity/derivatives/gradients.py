"""Gradients of the distances of whole query results, in one compiled call.

To first order, the distance of two bodies changes as that of their witness points (envelope
theorem; J. Danskin, *The Theory of Max-Min*, 1967): by the velocity of A's point minus that of
B's, along the normal. A derivative exists where the witness points and the normal are unique. They
are not unique

- where faces or edges lie parallel, so that all points of a segment are equally near;
- where another direction separates the bodies equally well;
- where bodies touch at corners or are partly concentric, so that turning the normal costs nothing.

The *stiffness* detects the last case: the second derivative of the width along n with respect to
n, which is the distance plus both bodies' radii of curvature (``kernels.features``). Where the
distance is 0 to rounding, only the features determine the normal, so the witness points have to
lie inside the features.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.derivatives.surfaces import Scene, is_of_surfaces
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    METHOD,
    NORMAL,
    UNIQUE,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.feature_borders import is_inside
from drake_geom_ros.geometry._proximity.kernels.shapes.features import (
    FACE,
    POINT,
    Feature,
    along,
    feature_of,
    hold_one_point,
    vertex,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    column,
    cross,
    dot,
    norm,
    perpendicular,
    scale,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, CAPSULE, SPHERE
from drake_geom_ros.geometry._proximity.pairs.answer_rows import (
    BATCH_WIDTH,
    P_ACA,
    P_BCB,
    P_FACA,
    P_FBCB,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part, row
from drake_geom_ros.geometry._proximity.tolerances import DISTINCT_NORMALS, SOFT
from drake_geom_ros.geometry._proximity.world.kept_poses import PosedWorld

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Booleans = NDArray[np.bool_]

FREEDOM, DU, DV, UU, UV, VV = range(6)  # columns: the numbers of a ``Feature``


class Features(NamedTuple):
    """The extreme features of A and B along the normals of k pairs; see ``kernels.features``."""

    axes: Floats  # (k, 2, 3) unit vectors u, v perpendicular to the normal
    numbers: Floats  # (k, 2, 6) those of a ``Feature``
    inside: Booleans  # (k, 2) whether the witness point is inside the edge or face


@inlined
def stiffness(distance: float, A: Feature, B: Feature) -> tuple[float, float, float]:
    """Return the second derivative (uu, uv, vv) [m] of the width along n, from both features."""
    return distance + A.uu + B.uu, A.uv + B.uv, distance + A.vv + B.vv


@inlined
def _is_stiff(distance: float, A: Feature, B: Feature, extent: float) -> bool:
    """Return whether every turn of n that the features leave free increases the width."""
    uu, uv, vv = stiffness(distance, A, B)
    if A.freedom == POINT and B.freedom == POINT:
        least = 0.5 * (uu + vv) - math.hypot(0.5 * (uu - vv), uv)
    else:
        du, dv = (B.du, B.dv) if A.freedom == POINT else (A.du, A.dv)
        least = dv * dv * uu - 2.0 * du * dv * uv + du * du * vv
    return least > SOFT * extent


@inlined
def _is_sure(numbers: Floats) -> bool:
    """Return whether a kernel computed the row and its normal is unique."""
    return numbers[UNIQUE] != 0.0 and numbers[METHOD] != BOUND_ONLY


@inlined
def _is_unique(numbers: Floats, A: Feature, B: Feature, extent: float) -> bool:
    """Return whether a row's normal and its witness points are unique.

    Bodies that touch at the border of a feature are not considered here.
    """
    if not _is_sure(numbers) or not hold_one_point(A, B):
        return False
    return A.freedom + B.freedom == FACE or _is_stiff(numbers[DISTANCE], A, B, extent)


@inlined
def _look_at(g: int, scene: Scene, n: Vector, u: Vector, v: Vector) -> Feature:
    """Return the feature of geometry g along the outward unit normal n; n, u, v in World."""
    types, starts, pool, R_WGs = scene
    if types[g] == SPHERE:  # its orientation does not matter
        return vertex(pool[starts[g]])
    R = row(R_WGs, g)
    if types[g] == CAPSULE:  # inline: a call would cost a noticeable part of so short a query
        axis, radius = column(R, 2), pool[starts[g]]
        if abs(dot(axis, n)) > DISTINCT_NORMALS:
            return vertex(radius)
        return along(axis, u, v, radius, 0.0, radius)
    return feature_of(types[g], part(pool, starts[g], starts[g + 1]), R, n, u, v)


@compiled
def _holds(
    g: int,
    scene: Scene,
    feature: Feature,
    n: Vector,
    u: Vector,
    v: Vector,
    q: Vector,
    slack: float,
) -> bool:
    """Return whether the extreme point q, in G, is inside the feature of geometry g."""
    types, starts, pool, R_WGs = scene
    R = row(R_WGs, g)
    shape = part(pool, starts[g], starts[g + 1])
    axes = unrotate(R, n), unrotate(R, u), unrotate(R, v)
    return is_inside(types[g], shape, feature, *axes, q, slack)


@inlined
def _axes(n: Vector) -> tuple[Vector, Vector]:
    """Return unit vectors u, v such that (u, v, n) is right-handed and orthonormal."""
    v = perpendicular(n)
    return cross(v, n), v


@inlined
def _extent(numbers: Floats) -> float:
    """Return the size of a pair [m], estimated from its witness points."""
    return norm(vector_at(numbers, P_ACA)) + norm(vector_at(numbers, P_BCB))


@compiled
def pair_features(
    rows: Floats,
    places: Indices,
    scene: Scene,
    axes: Floats,
    features: Floats,
    inside: Booleans,
) -> None:
    """Fill ``features`` (k, 2, 6) of A and B and whether the witnesses are ``inside`` (k, 2).

    They are expressed in two axes normal to nhat_BA_W, which are written to ``axes`` (k, 2, 3).
    """
    for k in range(places.shape[0]):
        numbers = row(rows, k)
        n = vector_at(numbers, NORMAL)
        u, v = _axes(n)
        for c in range(3):
            axes[k, 0, c], axes[k, 1, c] = u[c], v[c]
        slack = DISTINCT_NORMALS * _extent(numbers)
        for side in range(2):
            g, out, w = places[k, side], n, u
            if side == 0:
                # Both the normal and one axis are reversed, so the axes stay right-handed.
                out, w = scale(-1.0, n), scale(-1.0, u)
            feature = _look_at(g, scene, out, w, v)
            q = vector_at(numbers, P_ACA if side == 0 else P_BCB)
            inside[k, side] = _holds(g, scene, feature, out, w, v, q, slack)
            sign = -1.0 if side == 0 else 1.0
            features[k, side, FREEDOM] = feature.freedom
            features[k, side, DU], features[k, side, DV] = sign * feature.du, feature.dv
            features[k, side, UU], features[k, side, UV] = feature.uu, sign * feature.uv
            features[k, side, VV] = feature.vv


@compiled
def _find(sorted_ids: Indices, ids: Indices, places: Indices) -> None:
    """Fill ``places`` (k,) with the indices of ids in the ascending ``sorted_ids``.

    All ids are present. Ids are counted upwards, so an index is at most the difference of the id
    and the first one, and usually equal to it: the search starts there.
    """
    for k in range(ids.size):
        low, high = 0, min(ids[k] - sorted_ids[0], sorted_ids.size - 1)
        middle = high
        while sorted_ids[middle] != ids[k]:
            if sorted_ids[middle] < ids[k]:
                low = middle + 1
            else:
                high = middle - 1
            middle = (low + high) // 2
        places[k] = middle


@inlined
def _put_gradient(numbers: Floats, gradients: Floats, k: int) -> None:
    """Fill row k of ``gradients`` (n, 12) with derivatives by the velocities of both frames."""
    n = vector_at(numbers, NORMAL)
    of_A, of_B = cross(vector_at(numbers, P_FACA), n), cross(vector_at(numbers, P_FBCB), n)
    for c in range(3):
        gradients[k, c], gradients[k, 3 + c] = of_A[c], n[c]
        gradients[k, 6 + c], gradients[k, 9 + c] = -of_B[c], -n[c]


@compiled
def _put_gradients(rows: Floats, gradients: Floats) -> None:
    for k in range(rows.shape[0]):
        _put_gradient(row(rows, k), gradients, k)


@compiled
def pair_gradients(
    rows: Floats,
    places: Indices,
    scene: Scene,
    gradients: Floats,
    unique: Booleans,
) -> bool:
    """Fill ``gradients`` (k, 12) of the rows' distances, and whether each is ``unique`` (k,).

    ``places`` (k, 2) are the indices of A and B among the geometries. Return whether surfaces of
    solids are among them; ``find_unique_of_solids`` decides the uniqueness of these.
    """
    types, starts, pool, _ = scene
    surfaces = False
    for k in range(places.shape[0]):
        numbers = row(rows, k)
        _put_gradient(numbers, gradients, k)
        a, b = places[k, 0], places[k, 1]
        if is_of_surfaces(types[a], types[b]):
            surfaces = True
            continue
        if types[a] == SPHERE and types[b] == SPHERE:  # a shortcut in half the time
            extent = pool[starts[a]] + pool[starts[b]]
            unique[k] = _is_sure(numbers) and numbers[DISTANCE] + extent > SOFT * extent
            continue
        n = vector_at(numbers, NORMAL)
        u, v = _axes(n)
        m, w = scale(-1.0, n), scale(-1.0, u)  # out of A; w, v and m are right-handed, too
        A, B = _look_at(a, scene, m, u, v), _look_at(b, scene, n, u, v)
        extent = _extent(numbers)
        slack = DISTINCT_NORMALS * extent
        unique[k] = _is_unique(numbers, A, B, extent)
        if unique[k] and abs(numbers[DISTANCE]) <= SOFT * extent:
            turned = Feature(A.freedom, -A.du, A.dv, A.uu, -A.uv, A.vv)
            unique[k] = _holds(
                a, scene, turned, m, w, v, vector_at(numbers, P_ACA), slack
            ) and _holds(b, scene, B, n, u, v, vector_at(numbers, P_BCB), slack)
    return surfaces


def places_of(scene: PosedWorld, ids: Indices) -> Indices:
    """Return the indices of geometries with the given id values, in an array of equal shape."""
    places = np.empty(ids.shape, dtype=np.int64)
    _find(scene.ids, _read_only(ids.ravel()), places.ravel())
    return places


def _read_only(array: Any) -> Any:
    """Return a read-only view: Numba compiles another version for writable arrays."""
    view = array.view()
    view.setflags(write=False)
    return view


def _find_unique_of_solids(*arguments: Any) -> None:
    # Imported late: scenes without solids need not load the code for solids.
    from drake_geom_ros.geometry._proximity.derivatives.of_solids import find_unique_of_solids

    find_unique_of_solids(*arguments)


def gradients_of_pairs(scene: PosedWorld, ids: Indices, rows: Floats) -> tuple[Floats, Booleans]:
    """Return the gradients (k, 12) of the distances in rows, and which of them are unique.

    Ids (k, 2) and rows (k, BATCH_WIDTH) are those of a ``PairBatch``.
    """
    gradients, unique = np.empty((len(ids), 12)), np.empty(len(ids), dtype=np.bool_)
    shapes = scene.types, scene.starts, scene.pool, scene.R_WGs
    arguments = _read_only(rows), places_of(scene, ids), shapes
    if pair_gradients(*arguments, gradients, unique):
        _find_unique_of_solids(*arguments, unique)
    for array in (gradients, unique):
        array.setflags(write=False)
    return gradients, unique


def gradients_of_rows(rows: Floats) -> Floats:
    """Return the gradients (k, 12) of rows (k, BATCH_WIDTH), without their uniqueness."""
    gradients = np.empty((len(rows), 12))
    _put_gradients(_read_only(rows), gradients)
    return gradients


def features_of_pairs(scene: PosedWorld, ids: Indices, rows: Floats) -> Features:
    """Return the extreme features along the normals of rows (k, BATCH_WIDTH) of pairs (k, 2)."""
    k = len(ids)
    features = Features(np.empty((k, 2, 3)), np.empty((k, 2, 6)), np.empty((k, 2), dtype=np.bool_))
    shapes = scene.types, scene.starts, scene.pool, scene.R_WGs
    pair_features(_read_only(rows), places_of(scene, ids), shapes, *features)
    return features


def compile_derivatives() -> None:
    """Compile all of this file, or load it from the cache."""
    none, no_bodies = np.zeros(0), np.zeros(0, dtype=np.int64)
    Rs, ps = np.zeros((0, 3, 3)), np.zeros((0, 3))
    scene = PosedWorld(no_bodies, no_bodies, no_bodies, none, no_bodies, Rs, no_bodies, ps)
    pairs, rows = np.zeros((0, 2), dtype=np.int64), np.zeros((0, BATCH_WIDTH))
    gradients_of_pairs(scene, pairs, rows)
    gradients_of_rows(rows)
    features_of_pairs(scene, pairs, rows)
    shapes = scene.types, scene.starts, scene.pool, Rs
    _find_unique_of_solids(_read_only(rows), pairs, shapes, np.zeros(0, dtype=np.bool_))
