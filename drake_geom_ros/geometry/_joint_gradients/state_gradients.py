"""Distances of single states and their derivatives by joint values, each in one compiled call.

As in ``_proximity.states``, no answer of one state affects the next.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._joint_gradients.compiled import compiled, inlined
from drake_geom_ros.geometry._joint_gradients.joint_axes import (
    axes_of,
    put_axes,
    put_joint_gradient,
)
from drake_geom_ros.geometry._proximity.derivatives.gradients import pair_gradients
from drake_geom_ros.geometry._proximity.pairs.answer_rows import gather_rows
from drake_geom_ros.geometry._proximity.pairs.narrow_phase import answer_pairs
from drake_geom_ros.geometry._proximity.pairs.slots import EVERY_HIT
from drake_geom_ros.geometry._proximity.runtime.handles import (
    Flags,
    Handle,
    HandleField,
    IndexPairs,
    Integers,
    Rows,
    taker,
)
from drake_geom_ros.geometry._proximity.runtime.views import part, row, table
from drake_geom_ros.geometry._proximity.states.groups import collect, put_boxes
from drake_geom_ros.geometry._proximity.states.joint_checks import (
    FREE,
    GAP,
    NEAR,
    NO_POSE,
    NO_STATE,
    CheckArrays,
    groups_of_check,
    least_of_state,
    limits_verdict,
    put_links,
)
from drake_geom_ros.geometry._proximity.states.loops import forget, pose_state
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays, world_of

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class GradientArrays(NamedTuple):
    """A check of states of K pairs, the joints, and scratch for the answers about a state."""

    checks: HandleField
    joints: HandleField
    slots: Integers  # (K,) 0, 1, 2, ...
    is_collected: Flags  # (K,) all False between calls
    near: IndexPairs  # (K, 2) the pairs that may be within the cutoff
    hits: Integers  # (K,) places in ``near``
    memory: Rows  # (K, SLOT_WIDTH)
    # The h hits.
    numbers: Integers  # (K,) of the pairs, ascending
    ids: IndexPairs  # (K, 2)
    places: IndexPairs  # (K, 2)
    rows: Rows  # (K, BATCH_WIDTH)
    by_frames: Rows  # (K, 12)
    unique: Flags  # (K,)
    by_joints: Rows  # (K, c)


_arrays_of = taker(GradientArrays)
_checks_of = taker(CheckArrays)


@inlined
def _pose(checks: CheckArrays, q: Floats) -> int:
    """Pose the links and the world by joint values (c,); return NEAR, NO_STATE or NO_POSE."""
    if limits_verdict(q, checks.lower, checks.upper) == NO_STATE:
        return NO_STATE
    put_links(checks, q)
    world: Handle = checks.world
    if not pose_state(row(checks.poses, 0), checks.rows, checks.Xs, world):
        return NO_POSE
    return NEAR


@inlined
def _put_gradients(arrays: GradientArrays, world: WorldArrays, count: int) -> bool:
    """Write the gradients of the first ``count`` rows; return whether surfaces are among them."""
    scene = (world.types, world.starts, world.pool, world.R_WGs)
    places, surfaces = arrays.places, False
    for k in range(count):
        numbers, pair = row(arrays.rows, k), row(places, k)
        surfaces |= pair_gradients(
            table(numbers, 0, 1, numbers.size),
            table(pair, 0, 1, 2),
            scene,
            table(row(arrays.by_frames, k), 0, 1, 12),
            part(arrays.unique, k, k + 1),
        )
    joints: Handle = arrays.joints
    joints = axes_of(joints)
    put_axes(joints, world.R_WFs, world.p_WFs)
    for k in range(count):
        frames = world.frames[places[k, 0]], world.frames[places[k, 1]]
        by_frames, by_joints = row(arrays.by_frames, k), row(arrays.by_joints, k)
        put_joint_gradient(joints, world.p_WFs, frames, by_frames, by_joints)
    return surfaces


@inlined
def _sort(order: Indices, count: int, is_collected: Flags) -> None:
    """Sort the first ``count`` numbers, all different, without memory of its own."""
    for r in range(count):
        is_collected[order[r]] = True
    r = 0
    for k in range(is_collected.size):
        if is_collected[k]:
            is_collected[k] = False
            order[r] = k
            r += 1


@inlined
def _hits(arrays: GradientArrays, checks: CheckArrays, world: WorldArrays, cutoff: float) -> int:
    """Answer for the pairs of a posed world within a cutoff [m]; return the number of hits."""
    groups = groups_of_check(checks)
    put_boxes(groups, world)
    everything = (0, groups.separations.size, -1)
    order = checks.order
    count = collect(
        groups, everything, max(cutoff, 0.0), checks.pairs, world, order, checks.bounds
    )
    _sort(order, count, arrays.is_collected)
    for r in range(count):
        arrays.near[r, 0], arrays.near[r, 1] = checks.pairs[order[r], 0], checks.pairs[order[r], 1]
    forget(arrays.memory, 0, count)
    return answer_pairs(
        checks.kernels,
        arrays.near,
        part(arrays.slots, 0, count),
        arrays.memory,
        checks.world,
        1,
        (checks.parameters[GAP], cutoff, False),
        EVERY_HIT,
        (checks.waiting, checks.distances),  # no pair waits
        arrays.hits,
        checks.counts,
    )


@compiled
def distances_of_state(handle: Handle, states: Floats, cutoff: float) -> tuple[int, int, bool]:
    """Fill the arrays of answers with the pairs of the state (1, c) within a cutoff [m].

    Return a verdict, NEAR or for an invalid state NO_STATE or NO_POSE, the number of pairs, and
    whether surfaces are among them, whose ``unique`` is not decided yet.
    """
    arrays = _arrays_of(handle)
    checks_handle: Handle = arrays.checks
    checks = _checks_of(checks_handle)
    verdict = _pose(checks, states[0])
    if verdict != NEAR:
        return verdict, 0, False
    posed: Handle = checks.world
    world = world_of(posed)
    count = _hits(arrays, checks, world, cutoff)
    gather_rows(
        part(arrays.hits, 0, count),
        arrays.near,
        arrays.slots,
        arrays.memory,
        checks.parameters[GAP],
        checks.world,
        arrays.ids,
        arrays.rows,
    )
    for k in range(count):
        hit = arrays.hits[k]
        arrays.numbers[k] = checks.order[hit]
        arrays.places[k, 0], arrays.places[k, 1] = arrays.near[hit, 0], arrays.near[hit, 1]
    return NEAR, count, _put_gradients(arrays, world, count)


@compiled
def least_of_state_with_gradient(
    handle: Handle, states: Floats
) -> tuple[int, float, float, int, int, bool]:
    """Return ``least_of_state``, and whether surfaces decide; its gradient is in the arrays."""
    arrays = _arrays_of(handle)
    checks_handle: Handle = arrays.checks
    checks = _checks_of(checks_handle)
    verdict, distance, error_bound, a, b = least_of_state(checks_handle, states)
    if verdict != NEAR:
        infinite = math.inf if verdict == FREE else 0.0
        return verdict, infinite, 0.0, 0, 0, False
    for c in range(arrays.rows.shape[1]):
        arrays.rows[0, c] = checks.out[0, 0, c]
    arrays.places[0, 0], arrays.places[0, 1] = a, b
    world_handle: Handle = checks.world
    surfaces = _put_gradients(arrays, world_of(world_handle), 1)
    return verdict, distance, error_bound, a, b, surfaces


@compiled
def gradients_of_states(
    handle: Handle,
    states: Floats,
    offsets: Indices,
    places: Indices,
    by_frames: Floats,
    out: Floats,
) -> int:
    """Write the derivatives (k, c) of distances by the joint values of their states (N, c).

    Rows ``offsets[s]`` to ``offsets[s + 1]`` are of state s. ``places`` (k, 2) are the geometries
    A and B, negative in a row without a pair, and ``by_frames`` (k, 12) the derivatives by the
    velocities of their frames. Return the number of states done, fewer than N if one is invalid.
    """
    arrays = _arrays_of(handle)
    checks_handle: Handle = arrays.checks
    joints_handle: Handle = arrays.joints
    checks, joints = _checks_of(checks_handle), axes_of(joints_handle)
    world_handle: Handle = checks.world
    world = world_of(world_handle)
    count: int = states.shape[0]
    for s in range(count):
        if offsets[s] == offsets[s + 1]:
            continue
        if _pose(checks, row(states, s)) != NEAR:
            return s
        put_axes(joints, world.R_WFs, world.p_WFs)
        for k in range(offsets[s], offsets[s + 1]):
            if places[k, 0] < 0 or places[k, 1] < 0:
                continue
            frames = world.frames[places[k, 0]], world.frames[places[k, 1]]
            put_joint_gradient(joints, world.p_WFs, frames, row(by_frames, k), row(out, k))
    return count
