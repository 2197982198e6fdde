"""Checks of single states by their joint values, each in one compiled call.

As in ``loops``, no answer of one state affects the next. Some work is reused without changing a
bit: frames that stand still are not posed again, boxes around resting groups stay, and the next
state begins with the pair of groups that was near.

All arrays are passed as one handle, see ``handles``: passing thirty arrays takes longer than
posing two arms.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import DISTANCE, ERROR_BOUND, SEEN
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import separation_of_aabbs
from drake_geom_ros.geometry._proximity.pairs.narrow_phase import answer_pairs
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import (
    Handle,
    HandleField,
    IndexPairs,
    Integers,
    Reals,
    Rows,
    Vectors,
    taker,
)
from drake_geom_ros.geometry._proximity.runtime.views import row, table
from drake_geom_ros.geometry._proximity.states.certified import (
    lower_end,
    may_be_within,
    most_below,
    nearest_pairs,
)
from drake_geom_ros.geometry._proximity.states.groups import (
    Groups,
    collect,
    plainly_apart,
    put_box,
)
from drake_geom_ros.geometry._proximity.states.loops import forget, pose_state
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays, world_of
from drake_geom_ros.geometry._proximity.world.joint_poses import pose_links

# Verdicts about a state.
FREE = 0  # every pair is certified to be farther apart than the margin
NEAR = 1
OUTSIDE = 2  # a joint is beyond its limits
NO_STATE = 3  # a value is not finite
NO_POSE = 4  # a link would have no valid pose

# Places of ``parameters``.
GAP, MARGIN = 0, 1
OVERLAPS = 2  # 1: a pair is near if it overlaps, whatever the margin
WIDEST = 3  # [m] the largest padding of a pair
ROUNDED = 4  # [-] rounding of a padded distance, by its size and the padding's; 0 without padding
PARAMETERS = 5

Floats: TypeAlias = NDArray[np.float64]
Indices: TypeAlias = NDArray[np.int64]
States: TypeAlias = Annotated[NDArray[np.float64], np.float64, (None, None)]
StateIds: TypeAlias = Annotated[NDArray[np.int64], np.int64, (None, 2)]


class CheckArrays(NamedTuple):
    """All arrays that a check of a state works on, for a handle."""

    # Joints (m,), parents first, and the limits of the columns of a state; see ``pose_links``.
    lower: Reals
    upper: Reals
    leaders: Integers
    multipliers: Reals
    offsets: Reals
    kinds: Integers
    axes: Vectors
    X_PJs: Rows
    parents: Integers
    children: Integers
    X_WLs: Rows  # (links, 7), those of roots posed
    links: Integers  # (n,) that are frames
    # The scene.
    poses: States  # (1, n, 7) scratch
    rows: Integers  # (n,) of the frames
    Xs: Rows  # (n, POSE_WIDTH) scratch
    world: HandleField
    pairs: IndexPairs  # (k, 2)
    paddings: Reals  # [m] of geometries
    movers: Integers  # the groups that move
    # Groups.
    firsts: Integers
    members: Integers
    group_pairs: IndexPairs
    starts: Integers
    numbers: Integers
    centres: Vectors
    halves: Vectors
    separations: Reals
    # The parameters of the check, and scratch.
    kernels: HandleField
    parameters: Reals  # (PARAMETERS,)
    bounds: Reals  # (k,)
    order: Integers  # (k,)
    last: Integers  # (1,) the pair of groups that was near, -1: none
    one: IndexPairs  # (1, 2)
    slot: Integers  # (1,)
    hits: Integers  # (1,)
    memory: Rows  # (1, SLOT_WIDTH)
    counts: Integers
    waiting: Integers  # (0,)
    distances: Reals  # (0,)
    never: Integers  # (1,) a stop flag that is never set
    found_counts: Integers  # (1,)
    ids: StateIds  # (1, 1, 2)
    out: States  # (1, 1, BATCH_WIDTH)


_checks_of = taker(CheckArrays)


@inlined
def put_links(checks: CheckArrays, q: Floats) -> None:
    """Write the poses of those links that are frames, by joint values (c,), to ``poses``."""
    chain = (
        checks.leaders,
        checks.multipliers,
        checks.offsets,
        checks.kinds,
        checks.axes,
        checks.X_PJs,
        checks.parents,
        checks.children,
        checks.X_WLs,
        checks.links,
    )
    pose_links(table(q, 0, 1, q.size), chain, 0, checks.poses)


@inlined
def groups_of_check(checks: CheckArrays) -> Groups:
    """Return the groups of the pairs of a check."""
    return Groups(
        checks.firsts,
        checks.members,
        checks.group_pairs,
        checks.starts,
        checks.numbers,
        checks.centres,
        checks.halves,
        checks.separations,
    )


@compiled
def limits_verdict(q: Floats, lower: Floats, upper: Floats) -> int:
    """Return FREE for joint values (c,) within their limits, else OUTSIDE or NO_STATE."""
    outside = False
    for c in range(q.size):
        if not math.isfinite(q[c]):
            return NO_STATE
        outside |= q[c] < lower[c] or q[c] > upper[c]
    return OUTSIDE if outside else FREE


@inlined
def _padding_of(checks: CheckArrays, k: int) -> float:
    """Return the sum of both paddings of pair k [m]."""
    return checks.paddings[checks.pairs[k, 0]] + checks.paddings[checks.pairs[k, 1]]


@inlined
def _is_near(checks: CheckArrays, hit_count: int, k: int, overlaps: bool) -> bool:
    """Return whether a pair, just answered, overlaps, or may be within the margin [m].

    A padded distance is smaller by both paddings; see ``padded_rows``.
    """
    if overlaps:
        return hit_count > 0
    out, parameters = checks.memory[0], checks.parameters
    padding = _padding_of(checks, k)
    if padding == 0.0 and parameters[ROUNDED] == 0.0:
        return may_be_within(hit_count, out, parameters[MARGIN])
    if hit_count > 0 and out[SEEN] < 0.0:
        return True
    if math.isinf(lower_end(out)):
        return False
    error_bound = out[ERROR_BOUND] + parameters[ROUNDED] * (abs(out[DISTANCE]) + padding)
    return (out[DISTANCE] - padding) - error_bound <= parameters[MARGIN]


@inlined
def _any_near_of(
    checks: CheckArrays,
    groups: Groups,
    world: WorldArrays,
    m: int,
    query: tuple[float, float, bool],
) -> bool:
    """Return whether any pair between two groups is near."""
    _, most, overlaps = query
    pairs, order, memory = checks.pairs, checks.order, checks.memory
    groups.separations[m] = separation_of_aabbs(
        groups.centres, groups.halves, groups.pairs[m, 0], groups.pairs[m, 1]
    )
    count = collect(groups, (m, m + 1, -1), most, pairs, world, order, checks.bounds)
    for r in range(count):
        k = order[r]
        checks.one[0, 0], checks.one[0, 1] = pairs[k, 0], pairs[k, 1]
        forget(memory, 0, 1)
        enough = 0.0 if overlaps else checks.parameters[MARGIN] + _padding_of(checks, k)
        hit_count = answer_pairs(
            checks.kernels,
            checks.one,
            checks.slot,
            memory,
            checks.world,
            1,
            query,
            (0, enough),
            (checks.waiting, checks.distances),  # no pair waits
            checks.hits,
            checks.counts,
        )
        if _is_near(checks, hit_count, k, overlaps):
            return True
    return False


@inlined
def _verdict(checks: CheckArrays, q: Floats) -> int:
    """Return the verdict about joint values (c,): FREE, or the first other one."""
    verdict = limits_verdict(q, checks.lower, checks.upper)
    if verdict != FREE:
        return verdict
    put_links(checks, q)
    posed: Handle = checks.world
    if not pose_state(row(checks.poses, 0), checks.rows, checks.Xs, posed):
        return NO_POSE
    world, groups = world_of(checks.world), groups_of_check(checks)
    gap, overlaps = checks.parameters[GAP], checks.parameters[OVERLAPS] > 0.0
    for m in range(checks.movers.size):
        put_box(groups, world, checks.movers[m])
    most, widest = 0.0, checks.parameters[WIDEST]
    if not overlaps:
        most = checks.parameters[MARGIN] + most_below(gap, world)
        if widest > 0.0:
            most += widest + 4.0 * checks.parameters[ROUNDED] * (most + widest)
    query, last = (gap, most, overlaps), checks.last[0]
    # Groups that were near usually still are.
    if last >= 0 and _any_near_of(checks, groups, world, last, query):
        return NEAR
    for m in range(groups.separations.size):
        if m == last or plainly_apart(groups, m, most):
            continue
        if _any_near_of(checks, groups, world, m, query):
            checks.last[0] = m
            return NEAR
    return FREE


@allocating
def check_states(handle: Handle, states: Floats, verdicts: Indices) -> int:
    """Write the verdict about each state (N, c) to ``verdicts`` (N,), and return the last.

    NEAR unless every pair is certified to be farther apart than the margin, as in ``any_near``;
    for OVERLAPS, if a pair overlaps, as in ``any_overlap``.
    """
    checks, verdict = _checks_of(handle), FREE
    for s in range(states.shape[0]):
        verdict = _verdict(checks, states[s])
        verdicts[s] = verdict
    return verdict


@allocating
def least_of_state(handle: Handle, states: Floats) -> tuple[int, float, float, int, int]:
    """Return the pair of the least lower bound in the state (1, c), ignoring joint limits.

    The result is a verdict, NEAR if there is a pair and FREE if there is none, its distance [m]
    and error bound [m], and its two ids, as of ``nearest_pairs``.
    """
    checks, q = _checks_of(handle), states[0]
    if limits_verdict(q, checks.lower, checks.upper) == NO_STATE:
        return NO_STATE, 0.0, 0.0, 0, 0
    put_links(checks, q)
    groups = (
        checks.firsts,
        checks.members,
        checks.group_pairs,
        checks.starts,
        checks.numbers,
        checks.centres,
        checks.halves,
        checks.separations,
    )
    scene = (checks.kernels, checks.rows, checks.world, checks.pairs, groups)
    query, answers = (
        (checks.parameters[GAP], math.inf, False),
        (checks.found_counts, checks.ids, checks.out),
    )
    done = nearest_pairs(scene, checks.poses, query, checks.never, answers)
    if done == 0:
        return NO_POSE, 0.0, 0.0, 0, 0
    if checks.found_counts[0] == 0:
        return FREE, math.inf, 0.0, 0, 0
    least, ids = checks.out[0, 0], checks.ids[0, 0]
    return NEAR, least[DISTANCE], least[ERROR_BOUND], ids[0], ids[1]
