"""Parameters of SOLID: a hull, then the triangles under a tree of boxes.

The tree is a heap: node k has the children 2 k + 1 and 2 k + 2, and there are a power of two of
leaves, so links need no room. Leaf i of L holds triangles ``i n // L`` up to ``(i + 1) n // L``,
one to four of them. It is made level by level, every box cut at the median of the triangles'
middles along its longest side, all boxes of a level in one sort.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.solids.coins import COIN_WIDTH, put_coins
from drake_geom_ros.geometry._proximity.kernels.solids.inner_boxes import inner_boxes
from drake_geom_ros.geometry._proximity.kernels.solids.lane_tree import lane_count, put_lanes
from drake_geom_ros.geometry._proximity.kernels.solids.pieces import slices_of
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    AREA,
    AREA_VECTOR,
    CENTRE,
    CORNERS,
    HEADER,
    MOMENT,
    MOST_IN_LEAF,
    RADIUS,
    tree_of,
)
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import LOWER, NODE_WIDTH, UPPER
from drake_geom_ros.geometry._proximity.kinds import SOLID

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

SUMS = 16  # numbers that a node is made of

MOST_LINES = 12  # of a kind, between the cells of a solid along an axis
FEW = 0.2  # share of triangles normal to an axis: a solid with fewer is round, or turned
_MOVED = 1 << 16  # numbers that are moved at once
MOST_BOXES, KEPT_BOXES = 512, 32  # boxes that are found, and the thickest, which remain


def solid_parameters(
    hull: Floats, vertices: Floats, triangles: Indices, pieces: Indices, planes: Floats
) -> tuple[Floats, Indices]:
    """Return the kernel parameters of a solid and the numbers (n,) of its triangles in them.

    Parameters are laid out as ``kernels.solids.solid`` says. ``hull`` are the parameters of
    CONVEX; ``triangles`` (n, 3) of ``vertices`` [m], counter-clockwise from outside; ``pieces``
    (c,) a triangle of each connected surface; ``planes`` (f, 4) of the hull's faces: outward unit
    normal and offset [m].
    """
    leaves = 1
    count = len(triangles)
    while leaves * MOST_IN_LEAF < count:
        leaves *= 2
    starts = leaf_bounds(count, leaves)
    order = _order(_middles(vertices, triangles), leaves)
    header = np.array([count, leaves, len(pieces), len(planes), 0], dtype=np.float64)
    numbers = np.empty(count, dtype=np.int64)
    numbers[order] = np.arange(count)
    # Parts are made in their places: all parameters twice would be the peak of memory.
    sizes = (
        *(len(hull), HEADER, NODE_WIDTH * (2 * leaves - 1), CORNERS * count, len(pieces)),
        *(planes.size, lane_count(leaves), COIN_WIDTH * (2 * leaves - 1), 1),
    )
    parameters = np.empty(sum(sizes))
    parts = np.split(parameters, np.cumsum(sizes)[:-1])
    nodes, corners = parts[2].reshape(-1, NODE_WIDTH), parts[3].reshape(-1, 3, 3)
    for some in slices_of(count):
        corners[some] = vertices[triangles[order[some]]]
    parts[0][:], parts[1][:], parts[4][:] = hull, header, numbers[pieces]
    parts[5][:] = planes.ravel()
    # There is room for the sums of nodes where lanes and coins are written later.
    sums = parameters[-SUMS * len(nodes) :].reshape(-1, SUMS)
    put_nodes(nodes, sums, corners, starts)
    parts[8][:] = len(hull)
    put_lanes(parts[6], corners, nodes[:, LOWER : UPPER + 3], starts)
    put_coins(parts[7].reshape(-1, COIN_WIDTH), corners, starts)
    return parameters, numbers


def with_boxes(parameters: Floats) -> Floats:
    """Return the parameters of a solid together with the boxes (k, 6) [m] found within it.

    ``parameters`` own their memory and are not used afterwards.
    """
    tree = tree_of(SOLID, parameters)
    end = tree.corners + CORNERS * tree.triangles
    corners = parameters[tree.corners : end].reshape(-1, 3, 3)
    lines = [_lines(corners[:, :, k], corners) for k in range(3)]
    cells = np.empty((MOST_BOXES, 6), dtype=np.int64)
    cells = cells[: inner_boxes(parameters, lines[0], lines[1], lines[2], cells)]
    boxes = np.column_stack([lines[k % 3][cells[:, k]] for k in range(6)])
    thickness = (boxes[:, 3:] - boxes[:, :3]).min(axis=1)
    boxes = boxes[np.argsort(-thickness, kind='stable')[:KEPT_BOXES]]
    del corners
    header, at, size = int(parameters[-1]), tree.boxes_at, parameters.size
    parameters.resize(size + boxes.size, refcheck=False)  # in its place: ``corners`` is gone
    for end in range(size, at, -_MOVED):
        first = max(at, end - _MOVED)
        parameters[first + boxes.size : end + boxes.size] = parameters[first:end].copy()
    parameters[at : at + boxes.size] = boxes.ravel()
    parameters[header + HEADER - 1] = len(boxes)
    return parameters


def _lines(places: Floats, corners: Floats) -> Floats:
    """Return the places (l,) along an axis that cut a solid into cells, by its ``places`` (n, 3).

    They are those of the largest areas normal to the axis, which suffice for a union of boxes, and
    both ends; where there are few, some between.
    """
    low, high = float(places.min()), float(places.max())
    flat = (places == places[:, :1]).all(axis=1)
    a, b, c = corners[flat].transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    at, of = np.unique(places[flat, 0], return_inverse=True)
    largest = np.argsort(-np.bincount(of.ravel(), areas, len(at)), kind='stable')[:MOST_LINES]
    lines = np.union1d(at[largest], [low, high])
    if flat.mean() < FEW:
        lines = np.union1d(lines, np.linspace(low, high, MOST_LINES))
    return np.ascontiguousarray(lines)


def leaf_bounds(count: int, leaves: int) -> Indices:
    """Return the offset of each leaf's first triangle (L + 1,), the end last."""
    return np.arange(leaves + 1, dtype=np.int64) * count // leaves


def _middles(vertices: Floats, triangles: Indices) -> Floats:
    """Return the means (n, 3) [m] of the corners of triangles (n, 3)."""
    middles = np.empty((len(triangles), 3))
    for some in slices_of(len(triangles)):
        middles[some] = vertices[triangles[some]].mean(axis=1)
    return middles


def _order(middles: Floats, leaves: int) -> Indices:
    """Return the order of triangles in the leaves, by their middles (n, 3)."""
    count = len(middles)
    order = np.arange(count)
    lower, extent = middles.min(axis=0), float(np.ptp(middles, axis=0).max())
    ends = np.array([0, count])
    while len(ends) - 1 < leaves:
        sizes = np.diff(ends)
        points = middles[order]
        spans = np.maximum.reduceat(points, ends[:-1]) - np.minimum.reduceat(points, ends[:-1])
        segment = np.repeat(np.arange(len(sizes)), sizes)
        along = np.argmax(spans, axis=1)[segment]
        # One number is segment and place in it: a sort by two keys takes three times as long.
        places = points[np.arange(count), along] - lower[along]
        keys = segment + 0.5 * places / extent
        order = order[np.argsort(keys, kind='stable')]
        ends = leaf_bounds(count, 2 * len(sizes))
    return order


def put_nodes(nodes: Floats, sums: Floats, corners: Floats, starts: Indices) -> None:
    """Write the nodes (2 L - 1, NODE_WIDTH) over triangles in the order of the leaves.

    ``starts`` (L + 1,) are the offsets of the leaves' first triangles, the end last; ``sums``
    (2 L - 1, SUMS) is scratch.
    """
    leaves = len(starts) - 1
    # Sums over the triangles below: area, area vector (3), area times middle (3), and area vector
    # times middle (3 x 3), from the middle of it all so that no digits are lost.
    origin = 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))
    first = leaves - 1
    for some in slices_of(leaves):
        of_leaves = slice(first + some.start, first + some.stop)
        ends = starts[some.start : some.stop + 1]
        _put_leaves(nodes[of_leaves], sums[of_leaves], corners, ends, origin)
    while first > 0:
        below, first = slice(first, 2 * first + 1), first // 2
        level = slice(first, 2 * first + 1)
        left, right = nodes[below][::2], nodes[below][1::2]
        nodes[level, LOWER : LOWER + 3] = np.minimum(left[:, :3], right[:, :3])
        nodes[level, UPPER : UPPER + 3] = np.maximum(left[:, 3:6], right[:, 3:6])
        sums[level] = sums[below][::2] + sums[below][1::2]
    for some in slices_of(len(nodes)):
        _put_means(nodes[some], sums[some], origin)


def _put_leaves(
    nodes: Floats, sums: Floats, corners: Floats, starts: Indices, origin: Floats
) -> None:
    """Write boxes and sums of some leaves."""
    corners, firsts = corners[starts[0] : starts[-1]], starts[:-1] - starts[0]
    middles = corners.mean(axis=1) - origin
    vectors = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(vectors, axis=1)[:, None]
    moments = (vectors[:, :, None] * middles[:, None, :]).reshape(-1, 9)
    each = np.hstack((areas, vectors, areas * middles, moments))
    sums[:] = np.add.reduceat(each, firsts)
    nodes[:, LOWER : LOWER + 3] = np.minimum.reduceat(corners.min(axis=1), firsts)
    nodes[:, UPPER : UPPER + 3] = np.maximum.reduceat(corners.max(axis=1), firsts)


def _put_means(nodes: Floats, sums: Floats, origin: Floats) -> None:
    """Write what follows from the boxes and sums of some nodes."""
    areas, vectors, total, moments = np.split(sums, (1, 4, 7), axis=1)
    centres = np.divide(total, areas, out=np.zeros_like(total), where=areas > 0.0)
    about = moments - (vectors[:, :, None] * centres[:, None, :]).reshape(-1, 9)
    nodes[:, AREA_VECTOR : AREA_VECTOR + 3], nodes[:, AREA] = vectors, areas[:, 0]
    nodes[:, CENTRE : CENTRE + 3] = centres = centres + origin
    far = np.maximum(centres - nodes[:, :3], nodes[:, 3:6] - centres)
    nodes[:, RADIUS] = np.linalg.norm(far, axis=1)
    nodes[:, MOMENT] = np.linalg.norm(about, axis=1)
