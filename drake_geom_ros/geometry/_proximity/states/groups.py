"""Broad phase of states: boxes around groups of geometries that move together, as on a link."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import (
    BoundedBodies,
    least_possible,
    separation_of_aabbs,
)
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.tolerances import EPS
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays, world_of
from drake_geom_ros.geometry._proximity.world.world import World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class Groups(NamedTuple):
    """Groups of geometries that move together, and the pairs of geometries by pairs of groups.

    Separated boxes of two groups exclude all their pairs at once.
    """

    firsts: Indices  # (g + 1,) start of the members of each group
    members: Indices  # (n,) rows of the world
    pairs: Indices  # (m, 2) of groups
    starts: Indices  # (m + 1,) start of the pairs of geometries of each pair of groups
    numbers: Indices  # (k,) of pairs of geometries
    centres: Floats  # (g, 3) of the boxes [m]; scratch, like the following fields
    halves: Floats  # (g, 3) half the sizes [m]
    separations: Floats  # (m,) of the boxes [m]


# As passed to compiled code: see ``pairs.slots``.
GroupArrays: TypeAlias = tuple[Indices, Indices, Indices, Indices, Indices, Floats, Floats, Floats]


def groups_of(groups: Indices, pairs: Indices) -> Groups:
    """Return the ``Groups`` of geometries, given the group (n,) of each and all pairs (k, 2)."""
    count = int(groups.max(initial=-1)) + 1
    members = np.argsort(groups, kind='stable')
    codes = np.sort(groups[pairs], axis=1) @ np.array([count, 1], dtype=np.int64)
    numbers = np.argsort(codes, kind='stable')
    codes_present, starts = np.unique(codes[numbers], return_index=True)
    return Groups(
        firsts=np.searchsorted(groups[members], np.arange(count + 1)).astype(np.int64),
        members=members,
        pairs=np.column_stack((codes_present // max(count, 1), codes_present % max(count, 1))),
        starts=np.append(starts, len(pairs)).astype(np.int64),
        numbers=numbers,
        centres=np.zeros((count, 3)),
        halves=np.zeros((count, 3)),
        separations=np.zeros(len(codes_present)),
    )


def moved_together(world: World, rows: Indices) -> Indices:
    """Return the group (n,) of each geometry, given the rows of the frames that move.

    Geometries on one moving frame are a group. All others are usually far apart, so each is alone.
    """
    on, alone = world.geometries.frames, np.arange(len(world.geometries.ids))
    apart = len(world.frames.ids) + alone
    _, groups = np.unique(np.where(np.isin(on, rows), on, apart), return_inverse=True)
    return groups


@inlined
def put_box(groups: Groups, world: WorldArrays, g: int) -> None:
    """Write the box around a group; it is infinite with a half space."""
    types, p_WGs, half_extents = world.types, world.p_WGs, world.half_extents
    for c in range(3):
        lower, upper = math.inf, -math.inf
        for m in range(groups.firsts[g], groups.firsts[g + 1]):
            k = groups.members[m]
            p, half = p_WGs[k, c], half_extents[k, c]
            if types[k] == HALF_SPACE:
                half = math.inf
            lower, upper = min(lower, p - half), max(upper, p + half)
        if upper == math.inf:
            groups.centres[g, c], groups.halves[g, c] = 0.0, math.inf
            continue
        centre = 0.5 * lower + 0.5 * upper
        # Three sums, each rounded by EPS of the farther corner at most.
        rounding = 4.0 * EPS * max(abs(lower), abs(upper))
        groups.centres[g, c] = centre
        groups.halves[g, c] = max(upper - centre, centre - lower) + rounding


@inlined
def put_boxes(groups: Groups, world: WorldArrays) -> None:
    """Write the boxes around all groups, and the separations of all pairs of groups."""
    for g in range(groups.firsts.size - 1):
        put_box(groups, world, g)
    for m in range(groups.separations.size):
        a, b = groups.pairs[m, 0], groups.pairs[m, 1]
        groups.separations[m] = separation_of_aabbs(groups.centres, groups.halves, a, b)


@compiled
def put_boxes_of(groups: tuple[Any, ...], world: Handle) -> None:
    """Call ``put_boxes`` for groups as a plain tuple, in a world given by its handle."""
    put_boxes(Groups(*groups), world_of(world))


@inlined
def plainly_apart(groups: Groups, m: int, cutoff: float) -> bool:
    """Return whether the boxes of two groups are farther apart than a cutoff [m] along an axis.

    They exceed it by more than the rounding that ``separation_of_aabbs`` subtracts, so both agree.
    """
    centres, halves, reach = groups.centres, groups.halves, max(cutoff, 0.0)
    a, b = groups.pairs[m, 0], groups.pairs[m, 1]
    for c in range(3):
        p, q, sizes = centres[a, c], centres[b, c], halves[a, c] + halves[b, c]
        if abs(p - q) - sizes > reach + 8.0 * EPS * (abs(p) + abs(q) + sizes):
            return True
    return False


@inlined
def collect(
    groups: Groups,
    which: tuple[int, int, int],
    cutoff: float,
    pairs: Indices,
    world: WorldArrays,
    order: Indices,
    bounds: Floats,
) -> int:
    """Collect the numbers of pairs that may be within ``cutoff`` [m]; return how many.

    ``which`` are the pairs of groups to search: the first, the end, and one to skip. ``bounds``
    (k,) [m] get the lower bounds of the distances of collected pairs.
    """
    types, R_WGs, p_WGs, outer = world.types, world.R_WGs, world.p_WGs, world.outer
    roundings, half_extents = world.roundings, world.half_extents
    (first, last, skipped), count = which, 0
    for m in range(first, last):
        # Boxes that overlap are 0 apart.
        if m == skipped or groups.separations[m] > max(cutoff, 0.0):
            continue
        for r in range(groups.starts[m], groups.starts[m + 1]):
            k = groups.numbers[r]
            a, b = pairs[k, 0], pairs[k, 1]
            bound = least_possible(
                a, b, BoundedBodies(types, R_WGs, p_WGs, roundings, half_extents, outer)
            )
            if bound <= cutoff:
                order[count], bounds[k] = k, bound
                count += 1
    return count
