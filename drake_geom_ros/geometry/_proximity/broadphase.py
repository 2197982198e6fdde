"""Broad phase: from bounds to the pairs that can be within a distance of one another.

One algorithm for all scenes, a sweep along the axis on which the bodies lie farthest apart. It is
asked seldom, because ``near_list`` keeps its answer while nobody has moved far, and then only for
the bodies that move: those that rest were sorted once.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.pose_rounding import RADIUS, TILT
from drake_geom_ros.geometry._proximity.tolerances import EPS, LARGE_SQUARE

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]

WIDE = 4.0  # times the mean width: such bodies would make every sweep begin far back


class Boxes(NamedTuple):
    """Boxes around some bodies, sorted by their lower ends along an axis."""

    axis: int
    bodies: Indices  # (m,) rows of the world
    lowers: Floats  # (m, 3) [m]
    uppers: Floats  # (m, 3) [m]
    widest: float  # along the axis [m]


def widest_axis(p_WGs: Floats) -> int:
    """Return the axis along which points (n, 3) are spread most."""
    return int(np.argmax(np.ptp(p_WGs, axis=0))) if len(p_WGs) else 0


def sorted_boxes(
    axis: int, bodies: Indices, p_WGs: Floats, half_extents: Floats, paddings: Floats
) -> Boxes:
    """Return the boxes of ``bodies``, each wider by its padding on every side."""
    p, half = p_WGs[bodies], half_extents[bodies] + paddings[bodies, None]
    # What rounding may have taken off: a few spacings at the corners.
    half += 4.0 * EPS * (np.abs(p) + half)
    order = np.argsort(p[:, axis] - half[:, axis], kind='stable')
    p, half = p[order], half[order]
    widest = 2.0 * float(half[:, axis].max(initial=0.0))
    return Boxes(axis, bodies[order], p - half, p + half, widest)


def split_wide(bodies: Indices, half_extents: Floats, axis: int) -> tuple[Indices, Indices]:
    """Return the ordinary bodies and those that are several times wider than the mean."""
    widths = half_extents[bodies, axis]
    wide = widths > WIDE * (widths.mean() if len(widths) else 0.0)
    return bodies[~wide], bodies[wide]


def pairs_within(boxes: Boxes) -> Indices:
    """Return the pairs (k, 2) of bodies whose boxes overlap."""
    return _grown(lambda pairs: _sweep_within(*boxes[:4], pairs), 64 + 8 * len(boxes.bodies))


def pairs_between(some: Boxes, others: Boxes, skipped: Flags) -> Indices:
    """Return the pairs (k, 2) of one of ``some`` and one of ``others`` whose boxes overlap.

    Those of ``others`` for which ``skipped`` (n,) holds are left out.
    """
    return _grown(
        lambda pairs: _sweep_between(*some, *others[1:], skipped, pairs),
        64 + 8 * len(some.bodies),
    )


def _grown(sweep, room: int) -> Indices:  # type: ignore[no-untyped-def]
    """Run a sweep that counts on where its room ends, again if it was too little."""
    pairs = np.empty((room, 2), dtype=np.int64)
    count = sweep(pairs)
    if count > room:
        pairs = np.empty((count, 2), dtype=np.int64)
        sweep(pairs)
    return pairs[:count]


@inlined
def _overlap(lowers_a, uppers_a, a, lowers_b, uppers_b, b):  # type: ignore[no-untyped-def]
    """Tell whether two boxes share a point."""
    return (
        lowers_a[a, 0] <= uppers_b[b, 0]
        and lowers_b[b, 0] <= uppers_a[a, 0]
        and lowers_a[a, 1] <= uppers_b[b, 1]
        and lowers_b[b, 1] <= uppers_a[a, 1]
        and lowers_a[a, 2] <= uppers_b[b, 2]
        and lowers_b[b, 2] <= uppers_a[a, 2]
    )


@inlined
def _put(pairs, count, i, j):  # type: ignore[no-untyped-def]
    """Append the pair, smaller first; beyond the capacity only count it."""
    if count < pairs.shape[0]:
        pairs[count, 0] = min(i, j)
        pairs[count, 1] = max(i, j)
    return count + 1


@compiled
def _sweep_within(axis, bodies, lowers, uppers, pairs):  # type: ignore[no-untyped-def]
    """Sweep one set of boxes; return how many pairs there are."""
    count = 0
    for a in range(bodies.size):
        end = uppers[a, axis]
        for b in range(a + 1, bodies.size):
            if lowers[b, axis] > end:
                break
            if _overlap(lowers, uppers, a, lowers, uppers, b):
                count = _put(pairs, count, bodies[a], bodies[b])
    return count


@compiled
def _sweep_between(  # type: ignore[no-untyped-def]
    axis, some, lowers, uppers, _, others, other_lowers, other_uppers, widest, skipped, pairs
):
    """Sweep two sets of boxes against each other; return how many pairs there are."""
    count, first = 0, 0
    for a in range(some.size):
        # Boxes are sorted by their lower ends, so nobody needs to look back behind the first one
        # that the widest box could still reach.
        start, end = lowers[a, axis] - widest, uppers[a, axis]
        while first < others.size and other_lowers[first, axis] < start:
            first += 1
        for b in range(first, others.size):
            if other_lowers[b, axis] > end:
                break
            if not skipped[others[b]] and _overlap(
                lowers, uppers, a, other_lowers, other_uppers, b
            ):
                count = _put(pairs, count, some[a], others[b])
    return count


@inlined
def box_gap(p_WGs, half_extents, i, j):  # type: ignore[no-untyped-def]
    """Return a lower bound of the distance [m] of the boxes around i and j, 0 where they meet."""
    squared, reach, widest = 0.0, 0.0, 0.0
    for k in range(3):
        p, q = p_WGs[i, k], p_WGs[j, k]
        sizes = half_extents[i, k] + half_extents[j, k]
        reach = max(reach, abs(p) + abs(q) + sizes)
        gap = abs(p - q) - sizes
        if gap > 0.0:
            squared += gap * gap
            widest = max(widest, gap)
    if squared < LARGE_SQUARE:
        widest = math.sqrt(squared)
    # Rounding of the corners: a few spacings where they are.
    return max(0.0, widest - 4.0 * EPS * reach)


@inlined
def plane_gap(R_WGs, p_WGs, roundings, half_extents, h, g):  # type: ignore[no-untyped-def]
    """Return a lower bound of the distance [m] of the box around g above the half space h.

    Boxes have room for the rounding of their poses; that of h is taken off, see ``pose_rounding``.
    """
    height, extent, size = 0.0, 0.0, 0.0
    for k in range(3):
        height += R_WGs[h, k, 2] * (p_WGs[g, k] - p_WGs[h, k])
        extent += abs(R_WGs[h, k, 2]) * half_extents[g, k]
        size += abs(p_WGs[g, k]) + abs(p_WGs[h, k]) + half_extents[g, k]
    return height - extent - roundings[h, RADIUS] - (roundings[h, TILT] + 4.0 * EPS) * size
