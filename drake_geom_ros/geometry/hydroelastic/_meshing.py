"""Tetrahedral meshes of shapes around their innermost points, where the extent is 1.

The sizes follow those of pydrake 1.51 (``maybe_get_hydroelastic_mesh``); for equal vertices the
extents are equal. The extent grows linearly from 0 on the surface to 1 on the medial axis, or at
the centre of bodies with a round or many-sided surface.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry.hydroelastic._cells import CutBody, Loop, body_of_cells, oriented
from drake_geom_ros.geometry.hydroelastic._counts import (
    halvings,
    insets,
    vertices_around_capsule,
    vertices_around_cylinder,
)
from drake_geom_ros.math.array_types import Floats, Indices

_OCTAHEDRON = np.vstack((np.eye(3), -np.eye(3)))
_EIGHTHS = [(x, y, z) for x in (0, 3) for y in (1, 4) for z in (2, 5)]


def ellipsoid_body(semi_axes: Floats, resolution_hint: float) -> CutBody:
    """Return a ball or an ellipsoid: pyramids over a subdivided octahedron.

    Triangles are cut in four until, on a ball with the radius of the longest semi-axis, the chords
    of the great circles of the octahedron's edges are no longer than the hint.
    """
    points, triangles = _OCTAHEDRON, np.array(_EIGHTHS, dtype=np.int64)
    for _ in range(halvings(float(semi_axes.max()), resolution_hint)):
        points, triangles = _cut_in_four(points, triangles)
    return pyramids(points * semi_axes, triangles, np.zeros(3))


def _cut_in_four(points: Floats, triangles: Indices) -> tuple[Floats, Indices]:
    """Return triangles of the unit sphere, each cut in four, with new vertices on the sphere."""
    a, b, c = triangles.T
    edges = np.sort(np.concatenate([np.column_stack(pair) for pair in ((a, b), (b, c), (c, a))]))
    edges, at = np.unique(edges, axis=0, return_inverse=True)
    middles = points[edges].sum(axis=1)
    middles /= np.linalg.norm(middles, axis=1)[:, None]
    ab, bc, ca = (len(points) + at.ravel()).reshape(3, -1)
    parts = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return np.vstack((points, middles)), np.concatenate([np.column_stack(p) for p in parts])


def pyramids(points: Floats, triangles: Indices, apex: Floats) -> CutBody:
    """Return the pyramids of surface triangles (m, 3) over a point (3,) inside."""
    rows = np.column_stack((triangles, np.full(len(triangles), len(points))))
    extents = np.concatenate((np.zeros(len(points)), [1.0]))
    return oriented(rows, np.vstack((points, apex)), extents)


def box_body(half: Floats) -> CutBody:
    """Return a box of six cells, each the points nearest to a face, cut about the face's centre.

    The cells meet at the rectangle, the segment or the point of the medial axis that is farthest
    from the surface, by the shortest half size.
    """
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    middles = np.vstack((-np.eye(3), np.eye(3)))
    inner = corners * insets(half)
    inner_points, inner_of = np.unique(inner, axis=0, return_inverse=True)
    points = np.vstack((middles * half, corners * half, inner_points))
    extents = np.concatenate((np.zeros(14), np.ones(len(inner_points))))
    cells = []
    for number, (axis, side) in enumerate((axis, side) for side in (-1, 1) for axis in range(3)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        around = []
        for at_u, at_v in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            corner = np.zeros(3)
            corner[[axis, u, v]] = side, at_u, at_v
            around.append(int(np.flatnonzero((corners == corner).all(axis=1))[0]))
        cells.append(_box_cell(number, around, inner_of.ravel()))
    return body_of_cells(cells, points, extents)


def _box_cell(middle: int, around: list[int], inner_of: Indices) -> list[Loop]:
    """Return the faces of a box's cell; its outer face is a fan about the centre."""
    outer = [6 + corner for corner in around]
    inner = [14 + int(inner_of[corner]) for corner in around]
    faces: list[Loop] = [inner]
    for k in range(4):
        m = (k + 1) % 4
        faces.append([middle, outer[k], outer[m]])
        faces.append([outer[k], outer[m], inner[m], inner[k]])
    return faces


def cylinder_body(radius: float, half_length: float, resolution_hint: float) -> CutBody:
    """Return a cylinder of sectors, each with a part nearest to the side and one for either end.

    The parts meet at the medial axis: a segment for a long cylinder, a disc for a flat one, or a
    point.
    """
    count = vertices_around_cylinder(radius, resolution_hint)
    round_ = _circle(count)
    inset, inset_end = insets(np.array([radius, half_length]))
    rim, inner = radius * round_, inset * round_
    ends, inner_ends = (-half_length, half_length), (-inset_end, inset_end)
    parts = [_at(rim, z) for z in ends] + [_at(inner, z) for z in inner_ends]
    parts += [_at(np.zeros((1, 2)), z) for z in (*ends, *inner_ends)]
    points, same = _unique(np.vstack(parts), min(radius, half_length))
    extents = np.zeros(len(points))
    extents[same[np.r_[2 * count : 4 * count, 4 * count + 2 : 4 * count + 4]]] = 1.0
    cells: list[list[Loop]] = []
    for i in range(count):
        j = (i + 1) % count
        low, high, low_in, high_in = ([int(same[k * count + v]) for v in (i, j)] for k in range(4))
        centres = [int(same[4 * count + k]) for k in range(4)]
        cells.append(_prism((*low, *reversed(high)), (*low_in, *reversed(high_in))))
        cells.append(_prism((centres[0], *low), (centres[2], *low_in)))
        cells.append(_prism((centres[1], *high), (centres[3], *high_in)))
    return body_of_cells(cells, points, extents)


def capsule_body(radius: float, half_length: float, resolution_hint: float) -> CutBody:
    """Return a capsule: its facets joined to the ends of its segment, or to the segment."""
    count = vertices_around_capsule(radius, resolution_hint)
    rings = count // 2
    angles = 0.5 * math.pi * np.arange(rings) / rings
    round_ = _circle(count)
    parts, extents = [_at(np.zeros((1, 2)), s * half_length) for s in (-1, 1)], [1.0, 1.0]
    parts += [_at(np.zeros((1, 2)), s * (half_length + radius)) for s in (-1, 1)]
    for side in (-1, 1):
        for angle in angles:
            height = side * (half_length + radius * math.sin(angle))
            parts.append(_at(radius * math.cos(angle) * round_, height))
    points = np.vstack(parts)
    extents += [0.0] * (len(points) - 2)
    cells: list[list[Loop]] = []
    for i in range(count):
        j = (i + 1) % count
        for side in (0, 1):
            first = 4 + side * rings * count
            for ring in range(rings - 1):
                at = first + ring * count
                quad = (at + i, at + j, at + count + j, at + count + i)
                cells.append(_prism(quad, (side,) * 4))
            at = first + (rings - 1) * count
            cells.append(_prism((at + i, at + j, 2 + side), (side,) * 3))
        low, high = 4, 4 + rings * count
        cells.append(_prism((low + i, low + j, high + j, high + i), (0, 0, 1, 1)))
    return body_of_cells(cells, points, np.array(extents))


def _prism(outer: Loop, inner: Loop) -> list[Loop]:
    """Return the faces of the cell between two faces, corner for corner."""
    count = len(outer)
    sides = [
        (outer[k], outer[(k + 1) % count], inner[(k + 1) % count], inner[k]) for k in range(count)
    ]
    return [outer, inner, *sides]


def _circle(count: int) -> Floats:
    """Return points (count, 2) of the unit circle, from x on."""
    angles = 2.0 * math.pi * np.arange(count) / count
    return np.column_stack((np.cos(angles), np.sin(angles)))


def _at(points: Floats, z: float) -> Floats:
    """Return points (n, 2) at a height."""
    return np.column_stack((points, np.full(len(points), z)))


def _unique(points: Floats, size: float) -> tuple[Floats, Indices]:
    """Return distinct points and the index of each input among them; equal after rounding."""
    rounded = np.round(points / size, 12) + 0.0
    _, first, same = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    return points[first], same.ravel()
