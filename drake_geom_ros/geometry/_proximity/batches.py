"""What a query hands out: arrays of its own, which no later change of the world reaches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.kernels.calling import (
    DISTANCE,
    PAIR_WIDTH,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.pair_table import HALF_SPACE
from drake_geom_ros.geometry._proximity.tolerances import TOUCHING_DEPTH
from drake_geom_ros.geometry._proximity.world import World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Columns of a pair's row beyond those of ``calling``, where the witness points are in World now.
P_ACA = PAIR_WIDTH  # 3: in A [m]
P_BCB = P_ACA + 3  # 3: in B [m]
P_FACA = P_BCB + 3  # 3: from the origin of A's frame, in World axes [m]
P_FBCB = P_FACA + 3  # 3: from the origin of B's frame, in World axes [m]
OVERLAPS = P_FBCB + 3  # 1 where the pair overlaps by more than touching
BATCH_WIDTH = OVERLAPS + 1


class PairBatch(NamedTuple):
    """The answers of a pair query: ids (k, 2), ascending in each, and rows (k, BATCH_WIDTH)."""

    ids: Indices
    rows: Floats

    def penetrating(self) -> PairBatch:
        """Return those that overlap by more than touching, that is by more than rounding."""
        keep = self.rows[:, OVERLAPS] > 0.0
        return PairBatch(self.ids[keep], self.rows[keep])


class PointBatch(NamedTuple):
    """The answers of a point query: k rows, each of a point and a geometry."""

    ids: Indices  # (k,) of the geometries
    points: Indices  # (k,) which point
    rows: Floats  # (k, POINT_WIDTH), columns of ``point_phase``


def gathered(
    world: World, hits: Indices, pairs: Indices, slots: Indices, answers: Floats
) -> PairBatch:
    """Return the answers of the ``hits`` (k,) among pairs (n, 2) with slots (n,) of answers."""
    ids = np.empty((len(hits), 2), dtype=np.int64)
    rows = np.empty((len(hits), BATCH_WIDTH))
    _gather(hits, pairs, slots, answers, *world.posed, ids, rows)
    # Whoever asks again gets the same arrays, if nothing has changed.
    ids.setflags(write=False)
    rows.setflags(write=False)
    return PairBatch(ids, rows)


@compiled
def _gather(  # type: ignore[no-untyped-def]
    hits, pairs, slots, answers, geometry_ids, types, frames, R_WGs, p_WGs, p_WFs, outer, ids, rows
):
    """Fill ids and rows; witness points come measured from Ao, in World axes."""
    for k in range(hits.size):
        a, b, s = pairs[hits[k], 0], pairs[hits[k], 1], slots[hits[k]]
        ids[k, 0], ids[k, 1] = geometry_ids[a], geometry_ids[b]
        for c in range(PAIR_WIDTH):
            rows[k, c] = answers[s, c]
        # A half space has no size of its own: the pair's size is the other body's.
        size = 0.0 if types[a] == HALF_SPACE else outer[a]
        size += 0.0 if types[b] == HALF_SPACE else outer[b]
        rows[k, OVERLAPS] = 1.0 if answers[s, DISTANCE] < -TOUCHING_DEPTH * size else 0.0
        for c in range(3):
            rows[k, P_ACA + c] = 0.0
            rows[k, P_BCB + c] = 0.0
        for c in range(3):
            # Far from the origin only what is measured from a body keeps its digits.
            p_ACa, p_ACb = answers[s, WITNESS_A + c], answers[s, WITNESS_B + c]
            p_BCb = p_ACb - (p_WGs[b, c] - p_WGs[a, c])
            rows[k, WITNESS_A + c] = p_WGs[a, c] + p_ACa
            rows[k, WITNESS_B + c] = p_WGs[a, c] + p_ACb
            rows[k, P_FACA + c] = (p_WGs[a, c] - p_WFs[frames[a], c]) + p_ACa
            rows[k, P_FBCB + c] = (p_WGs[b, c] - p_WFs[frames[b], c]) + p_BCb
            for d in range(3):
                rows[k, P_ACA + d] += R_WGs[a, c, d] * p_ACa
                rows[k, P_BCB + d] += R_WGs[b, c, d] * p_BCb
