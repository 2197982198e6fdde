"""Packing bodies: fields and faces of their elements, under a tree of boxes."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    HALF_SPACE,
    NODE,
    SURFACE,
    VOLUME,
    Bodies,
    Floats,
    Indices,
)

# The corners of the face against each corner of a tetrahedron.
_FACES = np.array([(1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2)])


class PackedBody(NamedTuple):
    """A body as ``Bodies`` has it, alone; ``numbers`` are a row of its."""

    kind: int
    digest: int  # of 64 bits
    numbers: tuple[float, float]
    inner: Floats
    points: Floats
    elements: Indices
    fields: Floats
    planes: Floats
    beyond: Indices
    nodes: Floats
    boxes: Floats


def packed_volume(
    points: Floats, elements: Indices, pressures: Floats, beyond: Indices
) -> PackedBody:
    """Return a body of tetrahedra (m, 4) with pressures (n,) [Pa] at its points (n, 3) [m].

    ``beyond`` (m, 4) is which element is beyond the face against each corner, -1 where none is.
    """
    order, boxes = _tree(points[elements])
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    elements, beyond = elements[order], np.where(beyond < 0, -1, place[beyond])[order]
    corners = points[elements]
    edges = corners[:, 1:] - corners[:, :1]
    rises = pressures[elements[:, 1:]] - pressures[elements[:, :1]]
    gradients = np.linalg.solve(edges, rises[..., None])[..., 0]
    constants = pressures[elements[:, 0]] - (gradients * corners[:, 0]).sum(axis=1)
    fields = np.column_stack((gradients, constants, np.linalg.norm(gradients, axis=1)))
    planes = np.empty((len(elements), 4, 4))
    for k in range(4):
        # From its points in ascending order: the same numbers on either side, but for the sign.
        a, b, c = np.moveaxis(points[np.sort(elements[:, _FACES[k]], axis=1)], 1, 0)
        planes[:, k] = _planes(a, b, c)
        inside = (planes[:, k, :3] * points[elements[:, k]]).sum(axis=1) > planes[:, k, 3]
        planes[inside, k] *= -1.0
    numbers = float(np.linalg.norm(points, axis=1).max()), 0.0
    nodes = np.hstack((boxes, _ranges(corners, fields, (len(boxes) + 1) // 2)))
    inner = points[pressures.argmax()].copy()  # of several no mean: that may be outside of a ring
    return PackedBody(
        VOLUME,
        _digest(points, elements, pressures),
        numbers,
        inner,
        points,
        elements,
        fields,
        planes,
        beyond,
        nodes,
        _boxes(corners),
    )


def packed_surface(points: Floats, triangles: Indices) -> PackedBody:
    """Return a rigid surface of triangles (m, 3), turned outward, but for those without area."""
    planes = np.zeros((len(triangles), 4, 4))
    planes[:, 0] = _planes(*np.moveaxis(points[triangles], 1, 0))
    real = np.abs(planes[:, 0, :3]).max(axis=1, initial=0.0) > 0.0
    triangles, planes = triangles[real], planes[real]
    order, boxes = _tree(points[triangles])
    nodes = np.hstack((boxes, np.zeros((len(boxes), NODE - boxes.shape[1]))))
    count = len(triangles)
    elements = np.column_stack((triangles[order], np.zeros(count, dtype=np.int64)))
    beyond = np.full((count, 4), -1)
    numbers = float(np.linalg.norm(points, axis=1).max(initial=0.0)), 0.0
    return PackedBody(
        SURFACE,
        0,
        numbers,
        points[elements[0, 0]] if count else np.zeros(3),
        points,
        elements,
        np.zeros((count, 5)),
        planes[order],
        beyond,
        nodes,
        _boxes(points[triangles[order]]),
    )


def packed_half_space(pressure_slope: float) -> PackedBody:
    """Return a half space z <= 0 whose pressure grows so with the depth [Pa/m]; 0: rigid."""
    return PackedBody(
        HALF_SPACE,
        0,
        (0.0, pressure_slope),
        np.zeros(3),
        np.zeros((0, 3)),
        np.zeros((0, 4), dtype=np.int64),
        np.zeros((0, 5)),
        np.zeros((0, 4, 4)),
        np.zeros((0, 4), dtype=np.int64),
        np.zeros((0, NODE)),
        np.zeros((6, 0)),
    )


def packed(bodies: Sequence[PackedBody]) -> Bodies:
    """Return bodies one after another."""
    points = np.cumsum([0, *(len(body.points) for body in bodies)])
    elements = np.cumsum([0, *(len(body.elements) for body in bodies)])
    nodes = np.cumsum([0, *(len(body.nodes) for body in bodies)])
    table = [
        (
            body.kind,
            points[k],
            elements[k],
            len(body.elements),
            nodes[k],
            (len(body.nodes) + 1) // 2,
            body.digest,
        )
        for k, body in enumerate(bodies)
    ]
    return Bodies(
        np.array(table, dtype=np.int64).reshape(-1, 7),
        np.array([body.numbers for body in bodies]).reshape(-1, 2),
        inner=np.array([body.inner for body in bodies]).reshape(-1, 3),
        points=np.concatenate([body.points for body in bodies]),
        elements=np.concatenate([body.elements for body in bodies]),
        fields=np.concatenate([body.fields for body in bodies]),
        planes=np.concatenate([body.planes for body in bodies]),
        beyond=np.concatenate(
            [
                np.where(body.beyond < 0, -1, body.beyond + first)
                for body, first in zip(bodies, elements, strict=False)
            ]
        ),
        nodes=np.concatenate([body.nodes for body in bodies]).ravel(),
        boxes=np.concatenate([body.boxes for body in bodies], axis=1),
    )


def _digest(*arrays: Floats | Indices) -> int:
    """Return a number that like arrays have, and no others."""
    digest = hashlib.blake2b(digest_size=8)
    for array in arrays:
        digest.update(array.tobytes())
    return int.from_bytes(digest.digest(), 'little', signed=True)


def _planes(a: Floats, b: Floats, c: Floats) -> Floats:
    """Return unit normals and offsets (m, 4) of triangles, 0 of those without area."""
    normals = np.cross(b - a, c - a)
    lengths = np.sqrt((normals * normals).sum(axis=1))
    normals = normals / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    return np.column_stack((normals, (normals * a).sum(axis=1)))


def _boxes(corners: Floats) -> Floats:
    """Return middles and half sizes (6, m) of the boxes of elements (m, c, 3)."""
    low, high = corners.min(axis=1), corners.max(axis=1)
    return np.ascontiguousarray(np.hstack((0.5 * (low + high), 0.5 * (high - low))).T)


def _ranges(corners: Floats, fields: Floats, leaves: int) -> Floats:
    """Return between which planes the pressures of each node's elements are (2 L - 1, 6).

    The columns from SLOPE on. The slope is the mean of the elements' gradients: the fields of
    elements beside each other are much alike, and what is left is the less, the fewer there are.
    """
    count, levels = len(corners), []
    values = (fields[:, None, :3] * corners).sum(axis=2) + fields[:, 3:4]
    parts = leaves
    while parts > 0:
        starts = np.arange(parts) * count // parts
        counts = np.diff(np.append(starts, count))
        slopes = np.add.reduceat(fields[:, :3], starts) / counts[:, None]
        rest = values - (np.repeat(slopes, counts, axis=0)[:, None] * corners).sum(axis=2)
        low = np.minimum.reduceat(rest.min(axis=1), starts)
        high = np.maximum.reduceat(rest.max(axis=1), starts)
        steepest = np.maximum.reduceat(fields[:, 4], starts)
        levels.append(np.column_stack((slopes, 0.5 * (low + high), 0.5 * (high - low), steepest)))
        parts //= 2
    return np.concatenate(levels[::-1])


def _tree(corners: Floats) -> tuple[Indices, Floats]:
    """Return elements (m, c, 3) in the order of leaves, and the boxes (2 L - 1, 6) of a heap.

    Node k has the children 2 k + 1 and 2 k + 2; leaf i of L holds elements i m // L up to
    (i + 1) m // L, one or two. Every box is cut at the median along its longest side.
    """
    count, leaves = len(corners), 1
    while 2 * leaves <= count:
        leaves *= 2
    order, middles = np.arange(count), corners.mean(axis=1)
    parts = 1
    while parts < leaves:
        starts = np.arange(parts) * count // parts
        block = np.repeat(np.arange(parts), np.diff(np.append(starts, count)))
        sorted_middles = middles[order]
        low = np.minimum.reduceat(sorted_middles, starts)
        axes = (np.maximum.reduceat(sorted_middles, starts) - low).argmax(axis=1)
        along = sorted_middles[np.arange(count), axes[block]]
        order = order[np.lexsort((along, block))]
        parts *= 2
    starts = np.arange(leaves) * count // leaves
    boxes = np.empty((2 * leaves - 1, 6))
    if count:
        boxes[leaves - 1 :, :3] = np.minimum.reduceat(corners.min(axis=1)[order], starts)
        boxes[leaves - 1 :, 3:] = np.maximum.reduceat(corners.max(axis=1)[order], starts)
    else:
        boxes[0] = np.array([1.0] * 3 + [-1.0] * 3)
    below = leaves - 1  # the first node of a level, and how many it and all above have
    while below > 0:
        children, above = boxes[below : 2 * below + 1], below // 2
        boxes[above:below, :3] = np.minimum(children[::2, :3], children[1::2, :3])
        boxes[above:below, 3:] = np.maximum(children[::2, 3:], children[1::2, 3:])
        below = above
    low, high = boxes[:, :3], boxes[:, 3:]
    return order, np.hstack((0.5 * (low + high), 0.5 * (high - low)))
