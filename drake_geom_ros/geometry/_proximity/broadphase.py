"""Broad phase: from bounds to the pairs that can be within a distance of one another."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.tolerances import EPS
from drake_geom_ros.geometry._proximity.world import World

Indices = NDArray[np.int64]


def candidate_pairs(world: World, max_distance: float) -> Indices:
    """Return the pairs (k, 2), i < j in each and in lexical order, that may be within reach.

    A pair is left out when both are anchored, or when the boxes around them are farther apart
    than ``max_distance`` [m]. For a half space its plane takes the place of the box. With an
    infinite ``max_distance`` every pair that is not anchored twice is a candidate.
    """
    n = world.geometry_count
    if not math.isfinite(max_distance):
        i, j = np.triu_indices(n, k=1)
        free = ~(world.anchored[i] & world.anchored[j])
        return np.column_stack((i[free], j[free])).astype(np.int64)
    bounded = np.isfinite(world.half_extents[:, 0])
    rows = np.flatnonzero(bounded)
    planes = np.flatnonzero(~bounded)
    order = rows[_sweep_order(world, rows)]
    capacity = 64 + 4 * n
    while True:
        pairs = np.empty((capacity, 2), dtype=np.int64)
        args = (world.p_WGs, world.half_extents, world.anchored, max_distance, pairs)
        count = _sweep(order, *args)
        if planes.size:
            count = _against_planes(planes, rows, world.R_WGs, *args, count)
        if count <= capacity:
            break
        capacity = count
    found = pairs[:count]
    return found[np.lexsort((found[:, 1], found[:, 0]))]


def _sweep_order(world: World, rows: Indices) -> Indices:
    """Return the order of ``rows`` by the lower ends of their boxes along the x axis."""
    return np.argsort(world.p_WGs[rows, 0] - world.half_extents[rows, 0], kind='stable')


@compiled
def _put(pairs, count, i, j):  # type: ignore[no-untyped-def]
    """Append the pair, smaller first; beyond the capacity only count it."""
    if count < pairs.shape[0]:
        pairs[count, 0] = min(i, j)
        pairs[count, 1] = max(i, j)
    return count + 1


@compiled
def _slack(p, half_extents, i):  # type: ignore[no-untyped-def]
    """Return what rounding may have taken off the box of i: a few spacings at its corners."""
    reach = 0.0
    for k in range(3):
        reach = max(reach, abs(p[i, k]) + half_extents[i, k])
    return 4.0 * EPS * reach


@compiled
def _sweep(order, p, half_extents, anchored, max_distance, pairs):  # type: ignore[no-untyped-def]
    """Sweep along x and keep the pairs whose boxes come within the distance of one another."""
    count = 0
    reach = max_distance * max_distance
    for a in range(order.size):
        i = order[a]
        slack_i = _slack(p, half_extents, i)
        end = p[i, 0] + half_extents[i, 0] + max_distance
        for b in range(a + 1, order.size):
            j = order[b]
            slack = slack_i + _slack(p, half_extents, j)
            if p[j, 0] - half_extents[j, 0] > end + slack:
                break
            if anchored[i] and anchored[j]:
                continue
            squared = 0.0
            for k in range(3):
                gap = abs(p[i, k] - p[j, k]) - half_extents[i, k] - half_extents[j, k] - slack
                if gap > 0.0:
                    squared += gap * gap
            if squared <= reach * (1.0 + 4.0 * EPS):
                count = _put(pairs, count, i, j)
    return count


@compiled
def _against_planes(  # type: ignore[no-untyped-def]
    planes, rows, R, p, half_extents, anchored, max_distance, pairs, count
):
    """Keep the pairs of a half space and a box that reaches its plane within the distance."""
    for a in range(planes.size):
        h = planes[a]
        for b in range(rows.size):
            g = rows[b]
            if anchored[h] and anchored[g]:
                continue
            height, extent, size = 0.0, 0.0, 0.0
            for k in range(3):
                height += R[h, k, 2] * (p[g, k] - p[h, k])
                extent += abs(R[h, k, 2]) * half_extents[g, k]
                size += abs(p[g, k]) + abs(p[h, k]) + half_extents[g, k]
            if height - extent <= max_distance + 4.0 * EPS * size:
                count = _put(pairs, count, h, g)
    return count
