"""Bisection of the time spans that are not proved clear, first halves first.

All pairs are proved clear before the current span, so the search ends at the first contact or the
first unknown span. In the middle of a span, the separating plane of a pair at the begin is tested
over the first half, and the plane at the end over the second. Only where these fail does the
pair's kernel answer, which gives both halves a better plane on one side.
"""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.motion.arrays import (
    AT_BEGIN,
    AT_END,
    BEGIN,
    BEHIND,
    CLEAR,
    CONTACT,
    END,
    FIRST,
    FREE_RECORD,
    GAP,
    LEAST,
    NO_POSE,
    NO_ROOM,
    OF_PAIR,
    PAIR,
    QUICK,
    STOPPED,
    T0,
    T1,
    TIME_TOLERANCE,
    UNKNOWN,
    UPPER,
    MotionArrays,
    motions_of,
)
from drake_geom_ros.geometry._proximity.motion.interpolants import put_state
from drake_geom_ros.geometry._proximity.motion.records import (
    by_plane,
    by_way,
    count_seen,
    gap_now,
    is_proved,
    is_spent,
    put_answer,
)
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.tolerances import LEAST_PARTED_SPAN, LEAST_SPAN
from drake_geom_ros.geometry._proximity.world.arrays import world_of

# Where a span is given up, times after its begin are examined, each sooner by this factor.
_LOOKS_AFTER, _SOONER = 4, 0.0625


@inlined
def _deepest(motion: MotionArrays, first: int, last: int, column: int) -> int:
    """Return the deepest pair of some entries certified to touch at an end of its span; -1: none.

    ``column`` is the entries' column with the records of that end.
    """
    pair, deepest = -1, math.inf
    for e in range(first, last):
        k, r = motion.entries[e, OF_PAIR], motion.entries[e, column]
        depth = motion.records[r, UPPER] - motion.bounds[k, LEAST]
        if depth <= 0.0 and depth < deepest:
            pair, deepest = k, depth
    return pair


@inlined
def _given_up(motion: MotionArrays, first: int, last: int, width: float) -> int:
    """Return a pair of some entries whose span is too short to be halved; -1: none.

    While a plane separates the bodies at the begin, halving helps quadratically: the deviation of
    a point from its chord falls with the square of the span. Otherwise only the way falls, which
    is linear in the span.
    """
    coarse = min(motion.parameters[TIME_TOLERANCE], LEAST_SPAN) / 16.0
    if motion.flags[QUICK]:
        return motion.entries[first, OF_PAIR] if width <= motion.parameters[TIME_TOLERANCE] else -1
    for e in range(first, last):
        k, r = motion.entries[e, OF_PAIR], motion.entries[e, AT_BEGIN]
        parted = motion.records[r, GAP] > motion.bounds[k, LEAST]
        if width <= (min(coarse, LEAST_PARTED_SPAN) if parted else coarse):
            return k
    return -1


@allocating
def _touches_soon(handle: Handle, k: int, begin: float, r: int) -> bool:
    """Return whether pair k is certified to touch soon after a time; write the time to T1.

    Soon means within the time tolerance. Bodies that meet exactly at a bisection time are at 0
    within rounding there: not clear before, and not certified to touch. A moment later they are.
    """
    motion = motions_of(handle)
    span = min(motion.parameters[TIME_TOLERANCE], 1.0 - begin)
    for _ in range(_LOOKS_AFTER):
        t = begin + span
        span *= _SOONER
        if t <= begin or t - begin > motion.parameters[TIME_TOLERANCE]:
            continue
        if is_spent(motion) or not put_state(handle, t):
            return False
        put_answer(handle, k, motion.common_of_pair[k], r)
        count_seen(motion, k, t, r)
        if motion.records[r, UPPER] <= motion.bounds[k, LEAST]:
            motion.outcome[T1] = t
            return True
    return False


@inlined
def _records_of(motion: MotionArrays, count: int) -> int:
    """Return the first free record behind those of the first ``count`` entries."""
    top = 0
    for e in range(count):
        top = max(top, motion.entries[e, AT_BEGIN] + 1, motion.entries[e, AT_END] + 1)
    return top


@inlined
def _push(motion: MotionArrays, depth: int, span: tuple[float, float], first: int, n: int) -> None:
    motion.spans[depth, BEGIN], motion.spans[depth, END] = span
    motion.tops[depth, FIRST], motion.tops[depth, BEHIND] = first, first + n


@inlined
def _put_entry(motion: MotionArrays, e: int, k: int, start: int, end: int) -> None:
    motion.entries[e, OF_PAIR] = k
    motion.entries[e, AT_BEGIN], motion.entries[e, AT_END] = start, end


@inlined
def _is_open(motion: MotionArrays, k: int, bound: float) -> bool:
    """Return whether a lower bound [m] does not prove a pair clear."""
    return not bound > motion.bounds[k, LEAST]


@allocating
def _halve(handle: Handle, mid: float, half: float, first: int, last: int, top: int) -> int:
    """Examine entries in the middle of their span; write the entries open in each half.

    With ``most = last - first``, entries of the second half are written from ``last`` on, those of
    the first half from ``last + most`` on. Return both numbers as ``lefts * (most + 1) + rights``,
    or -1 where no more pairs may be answered.
    """
    motion = motions_of(handle)
    world, most = world_of(motion.world), last - first
    lefts, rights = 0, 0
    for e in range(first, last):
        k = motion.entries[e, OF_PAIR]
        start, end = motion.entries[e, AT_BEGIN], motion.entries[e, AT_END]
        node = motion.common_of_pair[k]
        before = by_plane(motion, k, start, gap_now(motion, world, k, node, start), half)
        after = by_plane(motion, k, end, gap_now(motion, world, k, node, end), half)
        left, right = _is_open(motion, k, before), _is_open(motion, k, after)
        if left or right:
            if is_spent(motion):
                motion.counts[PAIR] = k
                return -1
            put_answer(handle, k, node, top)
            count_seen(motion, k, mid, top)
            before = max(before, by_way(motion, k, start, top, half))
            after = max(after, by_way(motion, k, top, end, half))
        if not is_proved(motion, k, before):
            _put_entry(motion, last + most + lefts, k, start, top)
            lefts += 1
        if not is_proved(motion, k, after):
            _put_entry(motion, last + rights, k, top, end)
            rights += 1
        top += 1 if left or right else 0
    return lefts * (most + 1) + rights


@allocating
def bisect(handle: Handle, count: int) -> int:
    """Return the verdict about a motion for which ``begin`` left ``count`` open pairs.

    ``outcome`` gets the span of the first contact, or the time from which on nothing is proved;
    ``counts`` get the pair.
    """
    motion = motions_of(handle)
    tolerance = motion.parameters[TIME_TOLERANCE]
    touching = _deepest(motion, 0, count, AT_END)
    _push(motion, 0, (0.0, 1.0), 0, count)
    motion.tops[0, FREE_RECORD] = _records_of(motion, count)
    depth = 1
    while depth > 0:
        depth -= 1
        begin, end = motion.spans[depth, BEGIN], motion.spans[depth, END]
        first, last = motion.tops[depth, FIRST], motion.tops[depth, BEHIND]
        top = motion.tops[depth, FREE_RECORD]
        most = last - first
        motion.outcome[T0] = begin
        if touching >= 0 and motion.outcome[T1] - begin <= tolerance:
            motion.counts[PAIR] = touching
            return CONTACT
        if motion.stop[0] != 0:
            return STOPPED
        full = last + 2 * most > motion.entries.shape[0] or top + most > motion.records.shape[0]
        if full or depth + 2 > motion.spans.shape[0]:
            return NO_ROOM
        motion.counts[PAIR] = _given_up(motion, first, last, end - begin)
        if motion.counts[PAIR] >= 0 and motion.flags[QUICK]:
            return UNKNOWN
        if motion.counts[PAIR] >= 0:
            return CONTACT if _touches_soon(handle, motion.counts[PAIR], begin, top) else UNKNOWN
        half = 0.5 * (end - begin)
        mid = begin + half
        if not put_state(handle, mid):
            return NO_POSE
        open_counts = _halve(handle, mid, half, first, last, top)
        if open_counts < 0:
            return UNKNOWN
        lefts, rights = open_counts // (most + 1), open_counts % (most + 1)
        deepest = _deepest(motion, last + most, last + most + lefts, AT_END)
        if deepest >= 0:
            touching, motion.outcome[T1] = deepest, mid
            depth, rights = 0, 0  # later spans cannot hold the first contact
        if rights > 0:
            _push(motion, depth, (mid, end), last, rights)
            motion.tops[depth, FREE_RECORD] = top + most
            depth += 1
        if lefts > 0:
            _push(motion, depth, (begin, mid), last + most, lefts)
            motion.tops[depth, FREE_RECORD] = top + most
            depth += 1
    return CLEAR
