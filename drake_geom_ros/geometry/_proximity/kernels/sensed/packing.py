"""Packing of a map's parameters from its centres, in one compiled call.

Centres are sorted along Morton's curve (G. M. Morton, *A computer oriented geodetic data base*,
IBM 1966) by a radix sort, which for a million takes as long as one comparison sort for a single
level of a tree. Equal counts of neighbours on the curve are the leaves, and boxes are made from
them upwards.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.shapes.hull_packing import unlisted_parameters
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import COARSE_HULL
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import (
    CENTRE,
    COUNT,
    HEADER,
    LEAVES,
    MOST_IN_LEAF,
    NODE,
    SIZE,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector, signed, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import EPS, SMALL_SIZE

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Sorted numbers have the position on the curve, 13 bits per coordinate, above the number of the
# cell, 23 bits. 62 bits leave the sign positive.
KEY_BITS, NUMBER_BITS = 13, 23
DIGIT_BITS, PASSES = 13, 3  # of the sort: 8192 counts stay in a near cache
HULL = 1 + 3 * 8 + COARSE_HULL  # parameters of the box around all: 8 corners, no lists
# Corners of a box by the signs of their coordinates, and its surface from outside.
_SIGNS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
_SURFACE = np.array(
    [
        *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
        *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
    ]
)


def map_parameters(centres: Floats, size: float) -> Floats:
    """Return the kernel parameters of a map, in the layout of ``kernels.shapes.maps``.

    ``centres`` (n, 3) [m] are contiguous; ``size`` [m] is half the edge of a cell, or its radius.
    """
    leaves = 1
    while leaves * MOST_IN_LEAF < len(centres):
        leaves *= 2
    nodes = HULL + HEADER
    at = nodes + NODE * (2 * leaves - 1)
    parameters = np.empty(at + CENTRE * len(centres) + 1)
    boxes = parameters[nodes:at].reshape(-1, NODE)
    make_tree(centres, parameters[at:-1].reshape(-1, CENTRE), boxes)
    parameters[:HULL] = _hull_around(boxes[0, :3], boxes[0, 3:], size)
    parameters[HULL + SIZE], parameters[HULL + COUNT] = size, len(centres)
    parameters[HULL + LEAVES], parameters[-1] = leaves, HULL
    return parameters


def _hull_around(low: Floats, high: Floats, size: float) -> Floats:
    """Return the parameters of the box around cells with centres between two corners (3,) [m]."""
    # Sums of coordinates and sizes round by EPS of them.
    half = 0.5 * (high - low) + size + 2.0 * EPS * (np.maximum(np.abs(low), np.abs(high)) + size)
    return unlisted_parameters(0.5 * (low + high) + half * _SIGNS, _SURFACE)


@compiled
def _least_and_largest(centres: Floats) -> tuple[Vector, float]:
    """Return the least coordinates and the longest side [m] of centres (n, 3)."""
    x0, y0, z0 = centres[0, 0], centres[0, 1], centres[0, 2]
    x1, y1, z1 = x0, y0, z0
    for i in range(centres.shape[0]):
        x, y, z = centres[i, 0], centres[i, 1], centres[i, 2]
        x0, y0, z0 = min(x0, x), min(y0, y), min(z0, z)
        x1, y1, z1 = max(x1, x), max(y1, y), max(z1, z)
    return (x0, y0, z0), max(x1 - x0, y1 - y0, z1 - z0)


@inlined
def _spread(bits: int) -> int:
    """Return the 13 bits of a coordinate with two zero bits between neighbours."""
    bits = (bits | (bits << 16)) & 0x0000FF0000FF
    bits = (bits | (bits << 8)) & 0x00F00F00F00F
    bits = (bits | (bits << 4)) & 0x0C30C30C30C3
    return (bits | (bits << 2)) & 0x249249249249


@compiled
def _put_keys(centres: Floats, low: Vector, scale: float, keys: Indices, counts: Indices) -> None:
    """Write each centre's position on the curve and its number, and count the positions' digits.

    ``scale`` [1/m] maps the longest side to all bits.
    """
    last, mask = float((1 << KEY_BITS) - 1), (1 << DIGIT_BITS) - 1
    x0, y0, z0 = low[0], low[1], low[2]
    counts[:] = 0
    for i in range(keys.size):
        x = signed(min((centres[i, 0] - x0) * scale, last))
        y = signed(min((centres[i, 1] - y0) * scale, last))
        z = signed(min((centres[i, 2] - z0) * scale, last))
        place = _spread(x) | (_spread(y) << 1) | (_spread(z) << 2)
        keys[i] = (place << NUMBER_BITS) | i
        for turn in range(PASSES):
            counts[turn, (place >> (turn * DIGIT_BITS)) & mask] += 1


@compiled
def _sort_by_digit(shift: int, keys: Indices, to: Indices, counts: Indices) -> None:
    """Write the keys sorted by one digit, stable for equal digits."""
    mask, total = (1 << DIGIT_BITS) - 1, 0
    for k in range(counts.size):
        count = counts[k]
        counts[k], total = total, total + count
    for i in range(keys.size):
        k = unsigned((keys[i] >> shift) & mask)
        to[counts[k]] = keys[i]
        counts[k] += 1


@inlined
def _comes_before(points: Floats, i: int, j: int) -> bool:
    """Return whether point i precedes point j by coordinates."""
    for k in range(3):
        if points[i, k] != points[j, k]:
            return bool(points[i, k] < points[j, k])
    return False


@compiled
def _sift_down(points: Floats, keys: Indices, first: int, at: int, count: int) -> None:
    """Sift down key ``at`` of a heap of ``count`` keys from ``first`` on."""
    mask = (1 << NUMBER_BITS) - 1
    while 2 * at + 1 < count:
        child = first + 2 * at + 1
        if child + 1 < first + count and _comes_before(
            points, keys[child] & mask, keys[child + 1] & mask
        ):
            child += 1
        if not _comes_before(points, keys[first + at] & mask, keys[child] & mask):
            return
        keys[first + at], keys[child] = keys[child], keys[first + at]
        at = child - first


@compiled
def _sort_ties(points: Floats, keys: Indices) -> None:
    """Sort centres at the same position of the curve by coordinates (heap sort).

    So a map does not depend on the order of its cells.
    """
    first = 0
    while first < keys.size:
        last = first + 1
        while last < keys.size and keys[last] >> NUMBER_BITS == keys[first] >> NUMBER_BITS:
            last += 1
        count = last - first
        for at in range(count // 2 - 1, -1, -1):
            _sift_down(points, keys, first, at, count)
        for end in range(count - 1, 0, -1):
            keys[first], keys[first + end] = keys[first + end], keys[first]
            _sift_down(points, keys, first, 0, end)
        first = last


@compiled
def _put_boxes(centres: Floats, nodes: Floats) -> None:
    """Write the boxes of the leaves, around their centres, and of all nodes above."""
    leaves = (nodes.shape[0] + 1) // 2
    for i in range(leaves):
        at = leaves - 1 + i
        nodes[at, :3], nodes[at, 3:] = math.inf, -math.inf
        for j in range(i * centres.shape[0] // leaves, (i + 1) * centres.shape[0] // leaves):
            for k in range(3):
                nodes[at, k] = min(nodes[at, k], centres[j, k])
                nodes[at, 3 + k] = max(nodes[at, 3 + k], centres[j, k])
    for at in range(leaves - 2, -1, -1):
        for k in range(3):
            nodes[at, k] = min(nodes[2 * at + 1, k], nodes[2 * at + 2, k])
            nodes[at, 3 + k] = max(nodes[2 * at + 1, 3 + k], nodes[2 * at + 2, 3 + k])


@allocating
def make_tree(points: Floats, centres: Floats, nodes: Floats) -> None:
    """Fill ``centres`` (n, 3) with the points in leaf order, and the nodes (2 L - 1, 6)."""
    n = points.shape[0]
    keys, to = np.empty(n, np.int64), np.empty(n, np.int64)
    counts = np.empty((PASSES, 1 << DIGIT_BITS), np.int64)
    low, extent = _least_and_largest(points)
    _put_keys(points, low, float(1 << KEY_BITS) / max(extent, SMALL_SIZE), keys, counts)
    for turn in range(PASSES):
        _sort_by_digit(NUMBER_BITS + turn * DIGIT_BITS, keys, to, counts[turn])
        keys, to = to, keys
    _sort_ties(points, keys)
    mask = (1 << NUMBER_BITS) - 1
    for i in range(n):
        at = keys[i] & mask
        for k in range(3):
            centres[i, k] = points[at, k]
    _put_boxes(centres, nodes)
