"""Check of the edges of a path one after the other; a motion by poses is one edge."""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.motion.arrays import (
    ACCELERATION,
    CLEAR,
    CURVE_WIDTH,
    CURVED,
    EDGE,
    EDGE_BEGIN,
    EDGE_SPAN,
    EVALUATIONS,
    FIRST_VALUE,
    IGNORED,
    IGNORES,
    LAST_VALUE,
    LEVEL_GAP,
    LOWER_BOUND,
    PAIR,
    POWERS,
    ROUNDING,
    SEEN,
    SEEN_EDGE,
    SEEN_PAIR,
    SEEN_TIME,
    SIZE,
    SPEED,
    STOPPED,
    MotionArrays,
    motions_of,
)
from drake_geom_ros.geometry._proximity.motion.beginning import begin
from drake_geom_ros.geometry._proximity.motion.bisection import bisect
from drake_geom_ros.geometry._proximity.motion.interpolants import put_state
from drake_geom_ros.geometry._proximity.motion.rates import prepare
from drake_geom_ros.geometry._proximity.motion.records import answer_pair
from drake_geom_ros.geometry._proximity.pairs.answer_rows import gather_rows
from drake_geom_ros.geometry._proximity.pairs.slots import ALL
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle


@inlined
def _put_edge(motion: MotionArrays, path: Floats, curves: Floats, edge: int) -> None:
    """Write the ``values`` of an edge of a path: straight where there are no curves."""
    values, curved = motion.values, curves.shape[0] > 0
    motion.flags[CURVED] = 1 if curved else 0
    for c in range(path.shape[1]):
        start, end = path[edge, c], path[edge + 1, c]
        values[FIRST_VALUE, c], values[LAST_VALUE, c] = start, end
        if curved:
            for k in range(CURVE_WIDTH):
                values[POWERS + k, c] = curves[edge, k, c]
        else:
            values[SPEED, c], values[ACCELERATION, c] = abs(end - start), 0.0
            values[SIZE, c], values[ROUNDING, c] = abs(start) + abs(end), 0.0


@allocating
def check_edges(
    handle: Handle, path: Floats, curves: Floats, times: Floats, first: int, last: int
) -> int:
    """Return the verdict about the edges of a path (k, c), from row ``first`` to row ``last``.

    The check ends with the first edge that is not CLEAR; ``outcome`` and ``counts`` have the
    details. ``curves`` and ``times`` are those of a ``JointPath``. A path without joint
    values (k, 0) is the motion of the frames that was set. Only at row 0 may pairs be left out
    because they are not clear at the start.
    """
    motion = motions_of(handle)
    motion.outcome[LOWER_BOUND], motion.outcome[SEEN] = math.inf, math.inf
    motion.outcome[SEEN_TIME] = 0.0
    motion.counts[PAIR], motion.counts[SEEN_PAIR], motion.counts[SEEN_EDGE] = -1, -1, 0
    motion.counts[EVALUATIONS], motion.counts[IGNORED] = 0, 0
    ignores, verdict = motion.flags[IGNORES], CLEAR
    for edge in range(first, last):
        if motion.stop[0] != 0:
            return STOPPED
        motion.counts[EDGE] = edge
        motion.flags[IGNORES] = ignores if edge == 0 else 0
        _put_edge(motion, path, curves, edge)
        motion.parameters[EDGE_BEGIN] = times[edge]
        motion.parameters[EDGE_SPAN] = times[edge + 1] - times[edge]
        prepare(handle)
        count = begin(handle)
        verdict = -count if count < 0 else CLEAR
        if count > 0:
            verdict = bisect(handle, count)
        if verdict != CLEAR:
            break
    motion.flags[IGNORES] = ignores
    return verdict


@allocating
def row_of_pair(
    handle: Handle,
    path: Floats,
    curves: Floats,
    edge: int,
    t: float,
    k: int,
    ids: Indices,
    rows: Floats,
) -> None:
    """Write the answer (1, BATCH_WIDTH) of pair k at a time of an edge, and its ids (1, 2)."""
    motion = motions_of(handle)
    _put_edge(motion, path, curves, edge)
    put_state(handle, t)
    answer_pair(handle, k, math.inf, ALL)
    gather_rows(
        motion.slot,
        motion.one,
        motion.slot,
        motion.memory,
        motion.parameters[LEVEL_GAP],
        motion.world,
        ids,
        rows,
    )
