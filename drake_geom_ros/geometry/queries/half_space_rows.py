"""Rows of pairs of half spaces, in the columns and the order of those of other pairs."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kinds import CLOSED_FORM
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
)
from drake_geom_ros.geometry._proximity.world.world import World
from drake_geom_ros.geometry.queries.half_space_pairs import HalfSpaceGaps
from drake_geom_ros.geometry.queries.padding import Paddings, lower_ends
from drake_geom_ros.math.array_types import Floats, Indices


def rows_of_gaps(gaps: HalfSpaceGaps, world: World, paddings: Paddings | None) -> PairBatch:
    """Return the answers about pairs of half spaces in a world whose ids are places.

    Opposed ones have a normal, and a witness point on each plane. Those that cross are minus
    infinity apart; their normals and witness points are 0. No normal is unique, since the
    slightest rotation makes planes cross.
    """
    rows = np.zeros((len(gaps.ids), BATCH_WIDTH))
    rows[:, DISTANCE], rows[:, ERROR_BOUND] = gaps.distance, gaps.error_bound
    rows[:, DEPTH], rows[:, OVERLAPS] = -gaps.distance, ~(gaps.lower > 0.0)
    rows[:, METHOD], rows[:, PROMISED] = CLOSED_FORM, np.inf
    opposed = np.isfinite(gaps.distance)
    some, distance = gaps.ids[opposed], gaps.distance[opposed, None]
    a, b = some.T
    nhat_BA_W = world.R_WGs[b, :, 2]
    padding = 0.0 if paddings is None else paddings.radii[a, None]
    p_WCa = world.p_WGs[a] - padding * nhat_BA_W
    p_WCb = p_WCa - distance * nhat_BA_W
    of_three = (NORMAL, nhat_BA_W), (WITNESS_A, p_WCa), (WITNESS_B, p_WCb)
    for column, vectors in of_three + _of_bodies(world, (a, b), (p_WCa, p_WCb)):
        rows[np.flatnonzero(opposed)[:, None], column + np.arange(3)] = vectors
    return PairBatch(gaps.ids, rows if paddings is None else np.hstack((rows, rows)))


def _of_bodies(
    world: World, bodies: tuple[Indices, Indices], witnesses: tuple[Floats, Floats]
) -> tuple[tuple[int, Floats], ...]:
    """Return columns of witness points (k, 3) in geometries, and from the origins of frames."""
    columns = []
    for g, p_WC, in_body, in_frame in zip(
        bodies, witnesses, (P_ACA, P_BCB), (P_FACA, P_FBCB), strict=True
    ):
        p_GC = np.einsum('kji,kj->ki', world.R_WGs[g], p_WC - world.p_WGs[g])
        columns += [(in_body, p_GC), (in_frame, p_WC - world.p_WFs[world.geometries.frames[g]])]
    return tuple(columns)


def nearest_of(batch: PairBatch, others: PairBatch, max_distance: float, most: int) -> PairBatch:
    """Return the ``most`` pairs of both batches with the smallest lower bounds, ascending.

    Pairs with a lower bound above ``max_distance`` [m] are left out.
    """
    ids, rows = np.vstack((batch.ids, others.ids)), np.vstack((batch.rows, others.rows))
    lower = lower_ends(rows)
    order = np.argsort(lower, kind='stable')
    order = order[lower[order] <= max_distance][:most]
    return PairBatch(ids[order], rows[order])
