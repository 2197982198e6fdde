"""Records of a pair at one time, from its kernel or a plane, and the bounds that they prove.

Where bodies may also approach each other by themselves, as people do beside a robot, all bounds
of a record are less by that approach since the begin of the edge. It is linear in time: a gap
deviates no more from its chord, and the way of the pair is longer by it.
"""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    NORMAL,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import SEEN as ANSWERED_AT
from drake_geom_ros.geometry._proximity.kernels.vectors import unit, vector_in
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.motion.arrays import (
    ANSWER,
    CLOSED,
    CLOSING,
    EDGE,
    ELAPSED,
    EVALUATIONS,
    GAP,
    LEAST,
    LEVEL_GAP,
    LOWER,
    LOWER_BOUND,
    MOST,
    PLANE,
    QUICK,
    SAG,
    SEEN,
    SEEN_EDGE,
    SEEN_PAIR,
    SEEN_TIME,
    SLACK,
    UPPER,
    WAY,
    MotionArrays,
    motions_of,
)
from drake_geom_ros.geometry._proximity.motion.planes import (
    first_guess,
    gap_along,
    in_node,
    in_world,
    least_by_way,
    least_gap,
    normal_of_answer,
)
from drake_geom_ros.geometry._proximity.pairs.narrow_phase import answer_pairs
from drake_geom_ros.geometry._proximity.pairs.slots import ALL
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.runtime.views import row
from drake_geom_ros.geometry._proximity.states.loops import forget
from drake_geom_ros.geometry._proximity.tolerances import ROUNDED_UP
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays, world_of


@allocating
def answer_pair(handle: Handle, k: int, cutoff: float, enough: float) -> bool:
    """Answer for pair k at the current poses, independent of earlier answers.

    Return whether it may be within the cutoff [m]; if not, there is no answer, nor where the pair
    is certain to be within ``enough`` [m]: see ``is_unanswered``.
    """
    motion = motions_of(handle)
    motion.one[0, 0], motion.one[0, 1] = motion.pairs[k, 0], motion.pairs[k, 1]
    forget(motion.memory, 0, 1)
    hits = answer_pairs(
        motion.kernels,
        motion.one,
        motion.slot,
        motion.memory,
        motion.world,
        1,
        (motion.parameters[LEVEL_GAP], cutoff, False),
        (0 if enough > ALL else -1, enough),
        (motion.waiting, motion.distances),
        motion.hits,
        motion.effects,
    )
    return bool(hits > 0)


@inlined
def is_unanswered(motion: MotionArrays) -> bool:
    """Return whether the last pair within the cutoff was certain to be within ``enough``."""
    return motion.memory[0, ANSWERED_AT] < 0.0


@inlined
def enough_now(motion: MotionArrays, k: int) -> float:
    """Return the distance [m] within which nothing is proved about pair k at the current poses.

    A ``QUICK`` check needs no more than that of such a pair: how deep bodies are costs most.
    """
    if motion.flags[QUICK] == 0:
        return ALL
    return max(motion.bounds[k, LEAST] + _slack_now(motion, k), 0.0)


@inlined
def _slack_now(motion: MotionArrays, k: int) -> float:
    """Return how much nearer [m] a pair may be than at the current poses.

    That is the rounding of its interpolation, and its approach on the current edge by itself.
    """
    return motion.bounds[k, SLACK] + motion.bounds[k, CLOSING] * motion.parameters[ELAPSED]


@inlined
def put_plane(
    motion: MotionArrays, world: WorldArrays, k: int, node: int, n: Vector, r: int
) -> float:
    """Write a record of a plane with unit normal n in World; return its gap [m]."""
    record, n_N = row(motion.records, r), in_node(motion, world, node, n)
    gap = gap_along(world, motion.pairs[k, 0], motion.pairs[k, 1], n) - _slack_now(motion, k)
    for c in range(3):
        record[PLANE + c] = n_N[c]
    record[GAP], record[LOWER], record[UPPER] = gap, gap, math.inf
    record[ANSWER] = math.inf
    return gap


@inlined
def put_answer(handle: Handle, k: int, node: int, r: int) -> None:
    """Answer for pair k at the current poses, and write its record."""
    motion, enough = motions_of(handle), ALL
    types = world_of(motion.world).types
    # Where bodies may be far apart, coarse hulls would only be looked at in vain.
    if max(types[motion.pairs[k, 0]], types[motion.pairs[k, 1]]) >= SOLID:
        enough = enough_now(motion, k)
    answer_pair(handle, k, math.inf, enough)
    put_record(handle, k, node, r)


@inlined
def put_answer_unless_far(handle: Handle, k: int, node: int, r: int) -> bool:
    """Answer for pair k at an end of the edge, and write its record; return False if it is far.

    Then its distance here proves it clear on the whole edge. Only a ``QUICK`` check asks.
    """
    motion = motions_of(handle)
    cutoff = math.inf
    if motion.flags[QUICK]:
        bound = motion.bounds[k, WAY] + motion.bounds[k, SLACK] + motion.bounds[k, CLOSING]
        cutoff = (motion.bounds[k, LEAST] + bound) * ROUNDED_UP
    if not answer_pair(handle, k, cutoff, enough_now(motion, k)):
        motion.counts[EVALUATIONS] += 1
        is_proved(motion, k, cutoff - bound)
        return False
    put_record(handle, k, node, r)
    return True


@inlined
def put_record(handle: Handle, k: int, node: int, r: int) -> None:
    """Write the record of the answer for pair k at the current poses."""
    motion = motions_of(handle)
    motion.counts[EVALUATIONS] += 1
    if is_unanswered(motion):
        _put_contact(motion, k, node, r)
        return
    out, slack = row(motion.memory, 0), motion.bounds[k, SLACK]
    gap = put_plane(
        motion, world_of(motion.world), k, node, unit(normal_of_answer(out, NORMAL)), r
    )
    closed = motion.bounds[k, CLOSING] * motion.parameters[ELAPSED]
    motion.records[r, LOWER] = max(gap, out[DISTANCE] - out[ERROR_BOUND] - slack - closed)
    motion.records[r, UPPER] = out[DISTANCE] + out[ERROR_BOUND] + slack - closed
    if motion.flags[QUICK]:  # what is not proved here is as bad as contact
        motion.records[r, UPPER] = motion.records[r, LOWER]
    motion.records[r, ANSWER] = out[DISTANCE] - motion.paddings[k]


@inlined
def _put_contact(motion: MotionArrays, k: int, node: int, r: int) -> None:
    """Write the record of pair k where it is certain that nothing is proved about it."""
    world, record = world_of(motion.world), row(motion.records, r)
    guess = first_guess(world, motion.pairs[k, 0], motion.pairs[k, 1])
    gap = put_plane(motion, world, k, node, guess, r)
    record[GAP] = record[LOWER] = record[UPPER] = min(gap, motion.bounds[k, LEAST])


@inlined
def count_seen(motion: MotionArrays, k: int, t: float, r: int) -> None:
    """Include the record of pair k at a time in the least distance that is reported.

    Pairs that are left out are never included.
    """
    seen = motion.records[r, ANSWER]
    if seen < motion.outcome[SEEN]:
        motion.outcome[SEEN], motion.outcome[SEEN_TIME] = seen, t
        motion.counts[SEEN_PAIR], motion.counts[SEEN_EDGE] = k, motion.counts[EDGE]


@inlined
def gap_now(motion: MotionArrays, world: WorldArrays, k: int, node: int, r: int) -> float:
    """Return the gap [m] that the plane of a record leaves at the current poses."""
    n = in_world(motion, world, node, vector_in(motion.records, r, PLANE))
    return gap_along(world, motion.pairs[k, 0], motion.pairs[k, 1], n) - _slack_now(motion, k)


@inlined
def by_plane(motion: MotionArrays, k: int, r: int, gap: float, width: float) -> float:
    """Return a lower bound [m] for the span from a record to when its plane leaves ``gap``."""
    sag = motion.bounds[k, SAG] * width * width
    return least_gap(motion.records[r, GAP], gap, sag)


@inlined
def by_way(motion: MotionArrays, k: int, r: int, s: int, width: float) -> float:
    """Return a lower bound [m] for a span between the times of two records."""
    first, last = motion.records[r, LOWER], motion.records[s, LOWER]
    return least_by_way(first, last, motion.bounds[k, WAY] * width)


@inlined
def is_proved(motion: MotionArrays, k: int, bound: float) -> bool:
    """Return whether a lower bound [m] proves a pair clear; if so, include it in LOWER_BOUND."""
    if not bound > motion.bounds[k, LEAST]:
        return False
    distance = bound - motion.paddings[k] - motion.bounds[k, CLOSED]
    motion.outcome[LOWER_BOUND] = min(motion.outcome[LOWER_BOUND], distance)
    return True


@inlined
def is_spent(motion: MotionArrays) -> bool:
    """Return whether no more pairs may be answered."""
    most = motion.flags[MOST]
    return most > 0 and motion.counts[EVALUATIONS] >= most
