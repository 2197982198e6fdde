"""Start of a search: the pairs that no single bound or plane proves clear for the motion."""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE, OCCUPIED_CELLS
from drake_geom_ros.geometry._proximity.motion.arrays import (
    AT_BEGIN,
    AT_END,
    CLEAR,
    CLOSED,
    CLOSING,
    CONTACT,
    EDGE_BEGIN,
    EDGE_SPAN,
    EVALUATIONS,
    IGNORED,
    IGNORES,
    LEAST,
    LOWER,
    LOWER_BOUND,
    MIN_DISTANCE,
    MOST_APPROACH,
    MOST_APPROACHED,
    MOST_PADDING,
    NO_POSE,
    NO_ROOM,
    OF_PAIR,
    PAIR,
    QUICK,
    SAG,
    SLACK,
    T0,
    T1,
    UNKNOWN,
    UPPER,
    WAY,
    MotionArrays,
    motions_of,
)
from drake_geom_ros.geometry._proximity.motion.interpolants import put_state
from drake_geom_ros.geometry._proximity.motion.planes import first_guess
from drake_geom_ros.geometry._proximity.motion.rates import (
    Rates,
    plane_reach,
    rates_against,
    rounding_of_body,
)
from drake_geom_ros.geometry._proximity.motion.records import (
    answer_pair,
    by_plane,
    by_way,
    count_seen,
    enough_now,
    gap_now,
    is_proved,
    is_spent,
    put_answer,
    put_answer_unless_far,
    put_plane,
)
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import BoundedBodies, least_possible
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.runtime.views import row
from drake_geom_ros.geometry._proximity.states.groups import Groups, put_boxes
from drake_geom_ros.geometry._proximity.tolerances import ROUNDED_UP
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays, world_of


@inlined
def _is_far(motion: MotionArrays, m: int, A: Rates, B: Rates, slack: float) -> bool:
    """Return whether the boxes of two groups prove all their pairs clear for the whole motion.

    They are those in the middle of the motion for a ``QUICK`` check, otherwise at its start.
    """
    a, b = motion.group_pairs[m, 0], motion.group_pairs[m, 1]
    r_a, r_b = motion.group_reaches[a], motion.group_reaches[b]
    way = (A.speed + A.speed_r * r_a + B.speed + B.speed_r * r_b) * ROUNDED_UP
    end = motion.parameters[EDGE_BEGIN] + motion.parameters[EDGE_SPAN]
    closed = motion.parameters[MOST_APPROACHED] + motion.parameters[MOST_APPROACH] * end
    if motion.flags[QUICK]:
        way *= 0.5
    way += closed * ROUNDED_UP
    least = motion.separations[m] - way - slack - motion.parameters[MOST_PADDING]
    if not least > motion.parameters[MIN_DISTANCE]:
        return False
    motion.outcome[LOWER_BOUND] = min(motion.outcome[LOWER_BOUND], least)
    return True


@inlined
def _is_skipped(motion: MotionArrays, m: int) -> bool:
    """Return whether all pairs of two groups are left out."""
    for number in range(motion.starts_of_pairs[m], motion.starts_of_pairs[m + 1]):
        if not motion.skipped[motion.numbers[number]]:
            return False
    return True


@inlined
def _slack_of(motion: MotionArrays, m: int) -> float:
    """Return the interpolation error [m] of the bodies of a pair of groups."""
    r_a = motion.group_reaches[motion.group_pairs[m, 0]]
    r_b = motion.group_reaches[motion.group_pairs[m, 1]]
    slack = rounding_of_body(motion, motion.sides[m, 0], r_a)
    return (slack + rounding_of_body(motion, motion.sides[m, 1], r_b)) * ROUNDED_UP


@inlined
def _put_bounds(
    motion: MotionArrays, world: WorldArrays, k: int, A: Rates, B: Rates, exchanged: bool
) -> None:
    """Write the ``bounds`` of a pair; A and B are those of the two groups, or exchanged."""
    a, b = motion.pairs[k, 0], motion.pairs[k, 1]
    if exchanged:
        a, b = b, a
    bound, r_a, r_b = row(motion.bounds, k), motion.reaches[a], motion.reaches[b]
    bends = True
    if world.types[a] == HALF_SPACE or world.types[b] == HALF_SPACE:
        far = A.speed + A.speed_r * r_a + B.speed + B.speed_r * r_b
        if world.types[a] == HALF_SPACE:
            r_a += plane_reach(motion, world.p_WGs, a, b, far + world.outer[b])
            bends = A.speed_r == 0.0
        else:
            r_b += plane_reach(motion, world.p_WGs, b, a, far + world.outer[a])
            bends = B.speed_r == 0.0
    closing = motion.approaches[k] * motion.parameters[EDGE_SPAN] * ROUNDED_UP
    closed = motion.approached[k] + motion.approaches[k] * motion.parameters[EDGE_BEGIN]
    bound[CLOSING], bound[CLOSED] = closing, closed * ROUNDED_UP
    bound[WAY] = (A.speed + A.speed_r * r_a + B.speed + B.speed_r * r_b) * ROUNDED_UP + closing
    # A plane turns with its half space: no normal stays constant.
    sag = 0.125 * (A.bend + A.bend_r * r_a + B.bend + B.bend_r * r_b) * ROUNDED_UP
    bound[SAG] = sag if bends else math.inf
    slack = rounding_of_body(motion, motion.on[a], r_a)
    bound[SLACK] = (slack + rounding_of_body(motion, motion.on[b], r_b)) * ROUNDED_UP
    bound[LEAST] = motion.parameters[MIN_DISTANCE] + motion.paddings[k] + bound[CLOSED]


@inlined
def _at_start(motion: MotionArrays, k: int, r: int) -> int:
    """Return the verdict about a pair from its record of the start; CLEAR if it is left out."""
    lower, upper, least = (
        motion.records[r, LOWER],
        motion.records[r, UPPER],
        motion.bounds[k, LEAST],
    )
    if lower > least:
        return CLEAR
    if motion.flags[IGNORES]:
        motion.skipped[k] = True
        motion.counts[IGNORED] += 1
        return CLEAR
    motion.counts[PAIR] = k
    if not upper <= least:
        return UNKNOWN
    motion.outcome[T1] = 0.0
    return CONTACT


@inlined
def _is_clear_of_map(handle: Handle, k: int, reach: float) -> bool:
    """Return whether a pair with a map is farther apart than a reach [m] in the current state.

    Around a body in the midst of a map no box or plane proves anything.
    """
    motion = motions_of(handle)
    types, a, b = world_of(motion.world).types, motion.pairs[k, 0], motion.pairs[k, 1]
    if max(types[a], types[b]) < OCCUPIED_CELLS:  # maps have the last numbers
        return False
    motion.counts[EVALUATIONS] += 1
    cutoff = (motion.bounds[k, LEAST] + reach) * ROUNDED_UP
    if answer_pair(handle, k, cutoff, enough_now(motion, k)):
        return False
    return is_proved(motion, k, cutoff - reach)


@inlined
def _examine(handle: Handle, k: int, exchanged: bool, A: Rates, B: Rates, count: int) -> int:
    """Examine a pair by its boxes; return 1 if it is open, 0 if proved, or minus a verdict.

    They are those in the middle of the motion for a ``QUICK`` check, otherwise at its start.
    """
    motion = motions_of(handle)
    world = world_of(motion.world)
    a, b = motion.pairs[k, 0], motion.pairs[k, 1]
    _put_bounds(motion, world, k, A, B, exchanged)
    reach = motion.bounds[k, WAY]
    if motion.flags[QUICK]:
        reach = 0.5 * (reach + motion.bounds[k, CLOSING]) * ROUNDED_UP
    reach += motion.bounds[k, SLACK]
    bodies = BoundedBodies(
        world.types,
        world.R_WGs,
        world.p_WGs,
        world.roundings,
        world.half_extents,
        world.outer,
    )
    if is_proved(motion, k, least_possible(a, b, bodies) - reach):
        return 0
    motion.examined[k] = True
    if count >= motion.entries.shape[0] or 2 * count + 1 >= motion.records.shape[0]:
        return -NO_ROOM
    if not motion.flags[QUICK]:
        return _is_open(handle, k, count)
    if not is_spent(motion) and _is_clear_of_map(handle, k, reach):
        return 0
    motion.entries[count, OF_PAIR] = k
    return 1


@inlined
def _is_open(handle: Handle, k: int, count: int) -> int:
    """Examine a pair at the start; return 1 if it is open, 0 if proved, or minus a verdict.

    An open one gets the entry with the number ``count``.
    """
    motion = motions_of(handle)
    world, way, node = world_of(motion.world), motion.bounds[k, WAY], motion.common_of_pair[k]
    guess = first_guess(world, motion.pairs[k, 0], motion.pairs[k, 1])
    gap = put_plane(motion, world, k, node, guess, 2 * count)
    if is_proved(motion, k, gap - way):
        return 0
    if way == 0.0:
        if is_spent(motion):
            motion.counts[PAIR] = k
            return -UNKNOWN
        put_answer(handle, k, node, 2 * count)
        verdict = _at_start(motion, k, 2 * count)
        if verdict == CLEAR and not motion.skipped[k]:
            count_seen(motion, k, 0.0, 2 * count)
            is_proved(motion, k, motion.records[2 * count, LOWER])
        return 0 if verdict == CLEAR else -verdict
    motion.entries[count, OF_PAIR], motion.entries[count, AT_BEGIN] = k, 2 * count
    return 1


@allocating
def _near(handle: Handle) -> int:
    """List the pairs that the current state does not prove clear; return their number.

    Entries get the pair and its record of the start; of a ``QUICK`` check, in the middle of the
    motion, the pair alone. Return minus a verdict if one is reached.
    """
    motion = motions_of(handle)
    count, unknown = 0, False
    put_boxes(
        Groups(
            motion.firsts,
            motion.members,
            motion.group_pairs,
            motion.starts_of_pairs,
            motion.numbers,
            motion.centres,
            motion.halves,
            motion.separations,
        ),
        world_of(motion.world),
    )
    for m in range(motion.separations.size):
        if _is_skipped(motion, m):
            continue
        first, second, node = motion.sides[m, 0], motion.sides[m, 1], motion.common[m]
        A, B = rates_against(motion, first, node), rates_against(motion, second, node)
        if _is_far(motion, m, A, B, _slack_of(motion, m)):
            continue
        for number in range(motion.starts_of_pairs[m], motion.starts_of_pairs[m + 1]):
            k = motion.numbers[number]
            if motion.skipped[k]:
                continue
            exchanged = motion.on[motion.pairs[k, 0]] != first
            change = _examine(handle, k, exchanged, A, B, count)
            if change == -UNKNOWN:
                unknown = True  # a later pair may still be certified to touch
            elif change < 0:
                return change
            else:
                count += change
    return -UNKNOWN if unknown else count


@allocating
def _left_at_start(handle: Handle, count: int) -> int:
    """Examine the listed pairs at the start of the motion; return as ``_near`` does."""
    motion = motions_of(handle)
    left, unknown = 0, False
    for e in range(count):
        change = _is_open(handle, motion.entries[e, OF_PAIR], left)
        if change == -UNKNOWN:
            unknown = True
        elif change < 0:
            return change
        else:
            left += change
    return -UNKNOWN if unknown else left


@allocating
def _left_at_end(handle: Handle, count: int) -> int:
    """Examine the listed pairs at the end of the motion; return how many remain open.

    They get a record of it by their kernel. Return minus a verdict if one is reached.
    """
    motion = motions_of(handle)
    world, left = world_of(motion.world), 0
    for e in range(count):
        k, start = motion.entries[e, OF_PAIR], motion.entries[e, AT_BEGIN]
        node = motion.common_of_pair[k]
        gap = gap_now(motion, world, k, node, start)
        if is_proved(motion, k, by_plane(motion, k, start, gap, 1.0)):
            continue
        if is_spent(motion):
            motion.counts[PAIR] = k
            return -UNKNOWN
        if not put_answer_unless_far(handle, k, node, start + 1):
            continue
        motion.entries[left, OF_PAIR], motion.entries[left, AT_BEGIN] = k, start
        left += 1
    return left


@allocating
def _left_between(handle: Handle, count: int) -> int:
    """Examine open pairs at the start by kernels; return how many remain, or minus a verdict.

    Entries get the records of the start and of the end.
    """
    motion = motions_of(handle)
    world, left = world_of(motion.world), 0
    for e in range(count):
        k, start = motion.entries[e, OF_PAIR], motion.entries[e, AT_BEGIN]
        node = motion.common_of_pair[k]
        gap = gap_now(motion, world, k, node, start + 1)
        if is_proved(motion, k, by_plane(motion, k, start + 1, gap, 1.0)):
            count_seen(motion, k, 1.0, start + 1)
            continue
        if is_spent(motion):
            motion.counts[PAIR] = k
            return -UNKNOWN
        if not put_answer_unless_far(handle, k, node, start):
            continue
        if _at_start(motion, k, start) == CONTACT:
            return -CONTACT
        if motion.skipped[k]:
            continue
        count_seen(motion, k, 1.0, start + 1)
        count_seen(motion, k, 0.0, start)
        if is_proved(motion, k, by_way(motion, k, start, start + 1, 1.0)):
            continue
        motion.entries[left, OF_PAIR], motion.entries[left, AT_BEGIN] = k, start
        motion.entries[left, AT_END] = start + 1
        left += 1
    return left


@allocating
def begin(handle: Handle) -> int:
    """Return the number of pairs not proved clear from both ends, or minus a verdict."""
    motion = motions_of(handle)
    motion.outcome[T0], motion.outcome[T1] = 0.0, 1.0
    # Within half of the motion bodies go half as far: their middle proves more than their start.
    quick = motion.flags[QUICK] != 0
    if not put_state(handle, 0.5 if quick else 0.0):
        return -NO_POSE
    count = _near(handle)
    if count > 0 and quick:
        if not put_state(handle, 0.0):
            return -NO_POSE
        count = _left_at_start(handle, count)
    if count <= 0:
        return count
    if not put_state(handle, 1.0):
        return -NO_POSE
    count = _left_at_end(handle, count)
    if count <= 0:
        return count
    put_state(handle, 0.0)
    return _left_between(handle, count)
