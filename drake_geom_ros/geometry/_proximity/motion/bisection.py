"""What is left is cut in halves, the first before the second, until it is proved or touches.

So all that is before the span that is looked at is proved of all pairs, and what ends the search
is the first of its kind. In the middle of a span the plane of a pair at its begin is held against
the first half, that at its end against the second; only where these do not do is the pair answered
by its kernel, which gives both halves a better plane at least from one side.
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

# Where a span is given up, moments after it are looked at, each this much sooner than the last.
_LOOKS_AFTER, _SOONER = 4, 0.0625


@inlined
def _deepest(motion: MotionArrays, first: int, last: int, column: int) -> int:
    """Return the pair of some entries that is certified to touch at an end of its span; -1: none.

    Of several the one that is deepest; ``column`` is that of the end's records.
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
    """Return the pair of some entries for which a span is too short to be halved; -1: none.

    Halving helps on as long as a plane parts the bodies at its begin: what a point goes beside its
    chord falls with the square of the span. Else only the way that they come falls, as the span.
    """
    coarse = min(motion.asked[TIME_TOLERANCE], LEAST_SPAN) / 16.0
    for e in range(first, last):
        k, r = motion.entries[e, OF_PAIR], motion.entries[e, AT_BEGIN]
        parted = motion.records[r, GAP] > motion.bounds[k, LEAST]
        if width <= (min(coarse, LEAST_PARTED_SPAN) if parted else coarse):
            return k
    return -1


@allocating
def _touches_soon(handle: Handle, k: int, begin: float, r: int) -> bool:
    """Tell whether pair k is certified to touch within the tolerance after a time; put it down.

    Bodies that come together at a time that is halved to are, there, at 0 within rounding: not
    clear before and not certified to touch. A moment later they are.
    """
    motion = motions_of(handle)
    span = min(motion.asked[TIME_TOLERANCE], 1.0 - begin)
    for _ in range(_LOOKS_AFTER):
        t = begin + span
        span *= _SOONER
        if t <= begin or t - begin > motion.asked[TIME_TOLERANCE]:
            continue
        if is_spent(motion) or not put_state(handle, t):
            return False
        put_answer(handle, k, motion.common_of_pair[k], r)
        count_seen(motion, k, t, r)
        if motion.records[r, UPPER] <= motion.bounds[k, LEAST]:
            motion.told[T1] = t
            return True
    return False


@inlined
def _records_of(motion: MotionArrays, count: int) -> int:
    """Return the number behind those of all records that entries have."""
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
    """Tell whether a lower bound [m] does not keep a pair clear."""
    return not bound > motion.bounds[k, LEAST]


@allocating
def _halve(handle: Handle, mid: float, half: float, first: int, last: int, top: int) -> int:
    """Look at entries in the middle of their span; put down what is left of both halves.

    Entries of the second half from ``last`` on, those of the first as many further on as there may
    be. Returns how many there are, as the first times as many as there may be plus the second; -1
    where no more pairs may be answered.
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
    """Return what is true of a motion of which ``begin`` has left ``count`` pairs.

    ``told`` gets the span that holds the first contact, or from where on nothing is known, and
    ``counts`` the pair.
    """
    motion = motions_of(handle)
    tolerance = motion.asked[TIME_TOLERANCE]
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
        motion.told[T0] = begin
        if touching >= 0 and motion.told[T1] - begin <= tolerance:
            motion.counts[PAIR] = touching
            return CONTACT
        if motion.stop[0] != 0:
            return STOPPED
        full = last + 2 * most > motion.entries.shape[0] or top + most > motion.records.shape[0]
        if full or depth + 2 > motion.spans.shape[0]:
            return NO_ROOM
        motion.counts[PAIR] = _given_up(motion, first, last, end - begin)
        if motion.counts[PAIR] >= 0:
            return CONTACT if _touches_soon(handle, motion.counts[PAIR], begin, top) else UNKNOWN
        half = 0.5 * (end - begin)
        mid = begin + half
        if not put_state(handle, mid):
            return NO_POSE
        found = _halve(handle, mid, half, first, last, top)
        if found < 0:
            return UNKNOWN
        lefts, rights = found // (most + 1), found % (most + 1)
        deepest = _deepest(motion, last + most, last + most + lefts, AT_END)
        if deepest >= 0:
            touching, motion.told[T1] = deepest, mid
            depth, rights = 0, 0  # what comes later is no first contact
        if rights > 0:
            _push(motion, depth, (mid, end), last, rights)
            motion.tops[depth, FREE_RECORD] = top + most
            depth += 1
        if lefts > 0:
            _push(motion, depth, (begin, mid), last + most, lefts)
            motion.tops[depth, FREE_RECORD] = top + most
            depth += 1
    return CLEAR
