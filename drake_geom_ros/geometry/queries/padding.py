"""Padded geometries: answers about bodies that are enlarged on all sides by a length.

The property ``('proximity', 'padding')`` [m] replaces a body by its Minkowski sum with a ball of
radius r. A distance d from the body becomes d - r, for overlapping convex bodies, too: their
Minkowski difference D becomes D + ball, and the depth of a point in a convex D grows by the
radius. So a query about the bodies themselves, with a larger cutoff, answers for the padded ones
after a shift along the normal.

If a body is not convex this is a bound from one side only. Say padded bodies overlap, and a
translation t separates them. On the straight line to t there is a last position where the bodies
themselves touch, at least as far as their depth. From there to t their distance grows by no more
than the length of the line. So the depth grows by the radius or by more. The translation that
separates the bounding balls of both bodies limits how much more.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.calling.points import (
    POINT_DISTANCE,
    POINT_ERROR_BOUND,
    POINT_GRADIENT,
    POINT_NEAREST,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, HALF_SPACE, SOLID
from drake_geom_ros.geometry._proximity.pairs.answer_rows import (
    BATCH_WIDTH,
    DEPTH,
    OVERLAPS,
    P_ACA,
    P_BCB,
    P_FACA,
    P_FBCB,
    PROMISED,
    PairBatch,
    PointBatch,
)
from drake_geom_ros.geometry._proximity.tolerances import EPS, TOUCHING_DEPTH
from drake_geom_ros.geometry._proximity.world.row_change import RowChange
from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model._records import is_map, padding_of
from drake_geom_ros.geometry.shapes.from_meshes import Mesh
from drake_geom_ros.math.array_types import Floats, Indices

PADDED_ROUNDING = 8.0 * EPS  # sums and products, each rounded by EPS of what is added


class Paddings(NamedTuple):
    """The paddings of geometries with the proximity role, by their place."""

    radii: Floats  # (n,) [m]
    meshes: NDArray[np.bool_]  # (n,) True if points measure to a surface that is not convex

    @property
    def of_pair(self) -> float:
        """The largest sum of two paddings [m]."""
        return 2.0 * float(self.radii.max(initial=0.0))


def paddings_of(model: Model, ids: Indices) -> Paddings | None:
    """Return the paddings of geometries by their id values (n,), None if all are 0."""
    return _unless_all_zero(_read_paddings(model, ids))


def changed_paddings(
    before: Paddings | None, model: Model, ids: Indices, change: RowChange
) -> Paddings | None:
    """Return ``paddings_of`` from those before a change of the geometries."""
    new = _read_paddings(model, ids[change.new])
    if before is None:
        return paddings_of(model, ids) if new.radii.any() else None
    return _unless_all_zero(Paddings(*map(change.merged, before, new)))


def _read_paddings(model: Model, ids: Indices) -> Paddings:
    """Return the paddings of geometries, read from their properties."""
    records = [model.geometries[GeometryId(value)] for value in ids.tolist()]
    return Paddings(
        np.array([padding_of(record) for record in records], dtype=np.float64),
        np.array([isinstance(r.shape, Mesh) or is_map(r) for r in records], dtype=bool),
    )


def _unless_all_zero(paddings: Paddings) -> Paddings | None:
    return paddings if paddings.radii.any() else None


def padded_pairs(
    batch: tuple[Indices, Floats], paddings: Paddings, world: World, cutoff: float
) -> PairBatch:
    """Return answers about padded bodies within ``cutoff`` [m], from those about the bodies.

    Each row has that of the bodies themselves after its own columns.
    """
    ids, rows = batch[0], batch[1][:, :BATCH_WIDTH]
    places = world.geometry_rows(ids)
    padded = padded_rows(rows, places, paddings, world)
    R_WAs, R_WBs = (world.R_WGs[places[:, side]] for side in range(2))
    nhat = rows[:, NORMAL : NORMAL + 3]
    by = paddings.radii[places]
    padded[:, P_ACA : P_ACA + 3] -= by[:, :1] * np.einsum('kij,ki->kj', R_WAs, nhat)
    padded[:, P_BCB : P_BCB + 3] += by[:, 1:] * np.einsum('kij,ki->kj', R_WBs, nhat)
    keep = lower_ends(padded) <= cutoff
    return PairBatch(ids[keep], np.hstack((padded, rows[:, :BATCH_WIDTH]))[keep])


def padded_rows(rows: Floats, places: Indices, paddings: Paddings, world: World) -> Floats:
    """Return rows (k, BATCH_WIDTH) of pairs at ``places`` (k, 2), changed to the padded bodies.

    The witness points in A and in B are left unchanged.
    """
    radii = paddings.radii[places]
    total = radii.sum(axis=1)
    padded, nhat = rows[:, :BATCH_WIDTH].copy(), rows[:, NORMAL : NORMAL + 3]
    for column, step in (
        *((WITNESS_A, -radii[:, :1]), (P_FACA, -radii[:, :1])),
        *((WITNESS_B, radii[:, 1:]), (P_FBCB, radii[:, 1:])),
    ):
        padded[:, column : column + 3] += step * nhat
    distance = padded[:, DISTANCE]
    slack = PADDED_ROUNDING * (np.abs(distance) + total)
    distance -= total
    padded[:, ERROR_BOUND] += slack
    padded[:, PROMISED] += slack
    types, outer = world.geometries.types[places], world.outer_radii[places]
    # The Minkowski sum of a half space and any body is a half space, which is convex.
    unknown = (types >= SOLID).any(axis=1) & ~(types == HALF_SPACE).any(axis=1)
    unknown &= (total > 0.0) & (distance - padded[:, ERROR_BOUND] < 0.0)
    if unknown.any():
        # The translation that separates the bounding balls limits the depth.
        parting = outer.sum(axis=1) + total
        bound = np.maximum(padded[:, ERROR_BOUND], distance + parting + slack)
        padded[unknown, ERROR_BOUND] = bound[unknown]
        padded[unknown, PROMISED] = math.inf
    padded[:, DEPTH] = -distance
    sizes = np.where(types == HALF_SPACE, 0.0, outer + radii).sum(axis=1)
    padded[:, OVERLAPS] = _least_of(padded) < -TOUCHING_DEPTH * sizes
    return padded


def lower_ends(rows: Floats) -> Floats:
    """Return the certified lower bounds [m] of distances, by which pairs are listed."""
    lower: Floats = rows[:, DISTANCE] - rows[:, ERROR_BOUND]
    return lower


def _least_of(rows: Floats) -> Floats:
    """Return the distance, or the lower bound for BOUND_ONLY: it decides whether pairs overlap."""
    by_bounds = rows[:, METHOD] == BOUND_ONLY
    least: Floats = rows[:, DISTANCE] - np.where(by_bounds, rows[:, ERROR_BOUND], 0.0)
    return least


def padded_points(
    batch: PointBatch, paddings: Paddings, world: World, p_WQs: Floats, threshold: float
) -> PointBatch:
    """Return distances to padded bodies up to ``threshold`` [m], from those to the bodies."""
    places = world.geometry_rows(batch.ids)
    rows, radii = padded_point_rows(batch.rows, places, paddings)
    grads = rows[:, POINT_GRADIENT : POINT_GRADIENT + 3]
    steps = np.einsum('kij,ki->kj', world.R_WGs[places], grads)
    rows[:, POINT_NEAREST : POINT_NEAREST + 3] += radii[:, None] * steps
    inside = (rows[:, POINT_DISTANCE] < 0.0) & paddings.meshes[places] & (radii > 0.0)
    if inside.any():
        # The exit from a non-convex body may be longer, up to that from its bounding ball.
        away = np.linalg.norm(p_WQs[batch.points] - world.p_WGs[places], axis=1)
        out = world.outer_radii[places] + radii + away + rows[:, POINT_DISTANCE]
        rows[inside, POINT_ERROR_BOUND] = np.maximum(rows[:, POINT_ERROR_BOUND], out)[inside]
    keep = rows[:, POINT_DISTANCE] - rows[:, POINT_ERROR_BOUND] <= threshold
    return PointBatch(batch.ids[keep], batch.points[keep], rows[keep])


def padded_point_rows(rows: Floats, places: Indices, paddings: Paddings) -> tuple[Floats, Floats]:
    """Return rows of points with the distances to padded bodies, and the paddings (k,)."""
    rows, radii = rows.copy(), paddings.radii[places]
    slack = PADDED_ROUNDING * (np.abs(rows[:, POINT_DISTANCE]) + radii)
    rows[:, POINT_DISTANCE] -= radii
    rows[:, POINT_ERROR_BOUND] += slack
    return rows, radii
