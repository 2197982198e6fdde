"""Rows of answers that queries return: arrays of their own, unaffected by later changes."""

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
    PAIR_WIDTH,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    sub,
    unrotate,
    vector_at,
    vector_in,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, MESH, OPEN
from drake_geom_ros.geometry._proximity.pairs.error_bounds import (
    promised_error_bound,
    size_of_pair,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.runtime.views import row, wide_integers
from drake_geom_ros.geometry._proximity.tolerances import EPS, TOUCHING_DEPTH
from drake_geom_ros.geometry._proximity.world.arrays import world_of
from drake_geom_ros.geometry._proximity.world.world import World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Columns of a pair's row beyond those of ``calling.pairs``; the witness points are in World now.
P_ACA = PAIR_WIDTH  # 3: in A [m]
P_BCB = P_ACA + 3  # 3: in B [m]
P_FACA = P_BCB + 3  # 3: from the origin of A's frame, in World axes [m]
P_FBCB = P_FACA + 3  # 3: from the origin of B's frame, in World axes [m]
OVERLAPS = P_FBCB + 3  # 1 where the pair overlaps, or by its bounds may, by more than touching
PROMISED = OVERLAPS + 1  # the largest error bound that keeps the level's promise [m]
DEPTH = PROMISED + 1  # minus the distance [m]: negating it later costs as much as three columns
BATCH_WIDTH = DEPTH + 1
# An answer as a query returns it is one array, whose rows end with the ids of A and B: 64-bit
# numbers that are viewed as integers.
IDS = BATCH_WIDTH  # 2
ANSWER_WIDTH = IDS + 2

_INT64 = np.dtype(np.int64)


class PairBatch(NamedTuple):
    """The answers of a pair query: ids (k, 2), ascending in each, and rows (k, BATCH_WIDTH)."""

    ids: Indices
    rows: Floats

    def penetrating(self) -> PairBatch:
        """Return the answers whose pairs overlap by more than touching, that is than rounding.

        Answers from bounds alone are included if the pair may overlap. A depth is positive, but
        the middle of an interval that reaches beyond 0 need not be. Such an answer becomes half of
        the largest depth, with an error bound that covers the whole interval.
        """
        keep = self.rows[:, OVERLAPS] > 0.0
        ids, rows = self.ids[keep], self.rows[keep]
        most = rows[:, DISTANCE] + rows[:, ERROR_BOUND]
        unsure = (rows[:, METHOD] == BOUND_ONLY) & (most > 0.0)
        if unsure.any():
            some = rows[unsure]
            some[:, DISTANCE] = 0.5 * (some[:, DISTANCE] - some[:, ERROR_BOUND])
            # The distance to the other end. Four sums, each rounded by EPS of it at most.
            some[:, ERROR_BOUND] = (most[unsure] - some[:, DISTANCE]) * (1.0 + 4.0 * EPS)
            spans = some[:, DISTANCE : DISTANCE + 1] * some[:, NORMAL : NORMAL + 3]
            some[:, WITNESS_B : WITNESS_B + 3] = some[:, WITNESS_A : WITNESS_A + 3] - spans
            some[:, DEPTH] = -some[:, DISTANCE]
            rows[unsure] = some
        return PairBatch(ids, rows)

    def broken(self) -> NDArray[np.bool_]:
        """Return which answers (k,) are not finite or have wider bounds than promised."""
        finite = np.isfinite(self.rows[:, :PROMISED]).all(axis=1)
        fulfilled: NDArray[np.bool_] = finite & (
            self.rows[:, ERROR_BOUND] <= self.rows[:, PROMISED]
        )
        return ~fulfilled


class PointBatch(NamedTuple):
    """The answers of a point query: k rows, each of a point and a geometry."""

    ids: Indices  # (k,) of the geometries
    points: NDArray[np.uint32]  # (k,) indices of the points
    rows: Floats  # (k, POINT_WIDTH), columns of ``kernels.calling.points``


def gathered(
    world: World, hits: Indices, pairs: Indices, slots: Indices, memory: Floats, level_gap: float
) -> Floats:
    """Return the answers (k, ANSWER_WIDTH) of hits (k,) among pairs (n, 2) with slots (n,).

    ``level_gap`` [m] is that of the requested level. The array is read-only, because it is shared
    between identical queries.
    """
    answers = np.empty((len(hits), ANSWER_WIDTH))
    gather_answers(hits, pairs, slots, memory, level_gap, world.handle, answers)
    answers.flags.writeable = False
    return answers


def batch_of(answers: Floats) -> PairBatch:
    """Return read-only answers (k, ANSWER_WIDTH) as a batch."""
    return PairBatch(answers.view(_INT64)[:, IDS:], answers)


@inlined
def _put(row: Floats, column: int, vector: Vector) -> None:
    """Write a vector to a row from a column on; a negative zero is written as 0."""
    for c in range(3):
        row[column + c] = 0.0 + vector[c]


@compiled
def gather_rows(
    hits: Indices,
    pairs: Indices,
    slots: Indices,
    memory: Floats,
    level_gap: float,
    world: Handle,
    ids: Indices,
    rows: Floats,
) -> None:
    """Fill ids (k, 2) and rows (k, BATCH_WIDTH) of pairs of a world, given by its handle."""
    _gather(hits, pairs, slots, memory, level_gap, world, rows)
    world_ids = world_of(world).ids
    for k in range(hits.size):
        hit = unsigned(hits[k])
        ids[k, 0], ids[k, 1] = world_ids[pairs[hit, 0]], world_ids[pairs[hit, 1]]


@compiled
def gather_answers(
    hits: Indices,
    pairs: Indices,
    slots: Indices,
    memory: Floats,
    level_gap: float,
    world: Handle,
    answers: Floats,
) -> None:
    """Fill answers (k, ANSWER_WIDTH) of pairs of a world, given by its handle."""
    _gather(hits, pairs, slots, memory, level_gap, world, answers)
    ids = world_of(world).ids
    for k in range(hits.size):
        hit = unsigned(hits[k])
        pair_ids = wide_integers(row(answers, k), IDS)
        pair_ids[0], pair_ids[1] = ids[pairs[hit, 0]], ids[pairs[hit, 1]]


@inlined
def _gather(
    hits: Indices,
    pairs: Indices,
    slots: Indices,
    memory: Floats,
    level_gap: float,
    world: Handle,
    rows: Floats,
) -> None:
    """Fill the first BATCH_WIDTH columns of rows.

    Kernels measure witness points from Ao, in World axes.
    """
    world = world_of(world)
    types, frames, outer = world.types, world.frames, world.outer
    R_WGs, p_WGs, roundings, p_WFs = world.R_WGs, world.p_WGs, world.roundings, world.p_WFs
    for k in range(hits.size):
        hit = unsigned(hits[k])
        a, b = pairs[hit, 0], pairs[hit, 1]
        out, answer = row(memory, slots[hit]), row(rows, k)
        for c in range(PAIR_WIDTH):
            answer[c] = out[c]
        least = out[DISTANCE]
        answer[DEPTH] = -least
        promised = promised_error_bound(level_gap, a, b, types, outer, p_WGs, roundings)
        if out[METHOD] == BOUND_ONLY:
            least, promised = least - out[ERROR_BOUND], math.inf
        elif (out[METHOD] == MESH or out[METHOD] == OPEN) and least < 0.0:
            promised = math.inf  # overlapping solids and maps: see ``kernels.solids.overlap``
        touching = -TOUCHING_DEPTH * size_of_pair(a, b, types, outer)
        answer[OVERLAPS] = 1.0 if least < touching else 0.0
        answer[PROMISED] = promised
        p_WA, p_WB = vector_in(p_WGs, a), vector_in(p_WGs, b)
        p_WFa, p_WFb = vector_in(p_WFs, frames[a]), vector_in(p_WFs, frames[b])
        # Far from the origin, only points measured from a body keep their digits.
        p_ACa, p_ACb = vector_at(out, WITNESS_A), vector_at(out, WITNESS_B)
        p_BCb = sub(p_ACb, sub(p_WB, p_WA))
        _put(answer, WITNESS_A, add(p_WA, p_ACa))
        _put(answer, WITNESS_B, add(p_WA, p_ACb))
        _put(answer, P_FACA, add(sub(p_WA, p_WFa), p_ACa))
        _put(answer, P_FBCB, add(sub(p_WB, p_WFb), p_BCb))
        _put(answer, P_ACA, unrotate(row(R_WGs, a), p_ACa))
        _put(answer, P_BCB, unrotate(row(R_WGs, b), p_BCb))
