"""All pairs of bodies, one after another."""

from __future__ import annotations

from typing import Any

import numpy as np

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    FACE,
    HALF_SPACE,
    KIND,
    SUMS,
    VOLUME,
    Between,
    Bodies,
    Floats,
    Indices,
    Scratch,
    Surfaces,
)
from drake_geom_ros.geometry._contact_surfaces.clipping import COLUMNS, ROWS
from drake_geom_ros.geometry._contact_surfaces.compiled import compiled
from drake_geom_ros.geometry._contact_surfaces.emitting import sums_in_world
from drake_geom_ros.geometry._contact_surfaces.swallowed import one_is_swallowed
from drake_geom_ros.geometry._contact_surfaces.tolerances import ROUNDING
from drake_geom_ros.geometry._contact_surfaces.walks import DEEPEST, meet_bodies, meet_plane
from drake_geom_ros.geometry._proximity.kernels.vectors import sub, unrotate, vector_in

FIRST_POLYGONS = 4096  # there is room for, and for CORNERS_EACH corners of each
CORNERS_EACH = 5


def surfaces_of(bodies: Bodies, pairs: Indices, R_WBs: Floats, p_WBs: Floats) -> Surfaces:
    """Return the surfaces of pairs (k, 2) of bodies.

    ``R_WBs`` (b, 3, 3) and ``p_WBs`` (b, 3) pose the bodies in World. The first of a pair is M.
    Of each pair one at least is compliant, and not both are half spaces.
    """
    faces, corners = FIRST_POLYGONS, CORNERS_EACH * FIRST_POLYGONS
    stack = np.zeros((DEEPEST, 2), dtype=np.int64)
    scratch = Scratch(np.zeros((ROWS, COLUMNS)), stack, np.zeros((3, 3)))
    out = Surfaces(
        np.empty((corners, 3)),
        np.empty(corners),
        np.empty(faces, dtype=np.int64),
        np.empty((faces, FACE)),
        np.zeros((len(pairs), SUMS)),
        np.zeros(len(pairs), dtype=np.int64),
        np.zeros(len(pairs), dtype=np.bool_),
        np.zeros(2, dtype=np.int64),
    )
    done = 0
    while (done := _next_pairs(bodies, pairs, R_WBs, p_WBs, scratch, out, done)) < len(pairs):
        out = _resized(out, 2 * len(out.ends), 2 * len(out.points))
    return _resized(out, *out.counts.tolist())


def _resized(out: Surfaces, faces: int, corners: int) -> Surfaces:
    """Return surfaces with room for so many polygons and corners; what is there stays."""
    return out._replace(
        points=_rows(out.points, corners),
        pressures=_rows(out.pressures, corners),
        ends=_rows(out.ends, faces),
        faces=_rows(out.faces, faces),
    )


def _rows(array: Any, count: int) -> Any:
    """Return the first rows of an array, and room where it has fewer."""
    more = np.empty((max(0, count - len(array)), *array.shape[1:]), array.dtype)
    return np.concatenate((array, more)) if len(more) else array[:count]


@compiled
def _next_pairs(
    bodies: Bodies,
    pairs: Indices,
    R_WBs: Floats,
    p_WBs: Floats,
    scratch: Scratch,
    out: Surfaces,
    done: int,
) -> int:
    """Put out the surfaces of pairs but those done; return for which one there was no room.

    That pair is as if it had not been looked at. Where all are done it is their number.
    """
    R = scratch.R
    for pair in range(done, len(pairs)):
        faces, points = out.counts[0], out.counts[1]
        a, b = pairs[pair, 0], pairs[pair, 1]
        # First comes a tetrahedral body, before a surface, before a half space.
        flip = bodies.table[b, KIND] < bodies.table[a, KIND]
        half_space = bodies.table[a, KIND] == HALF_SPACE or bodies.table[b, KIND] == HALF_SPACE
        if flip:
            a, b = b, a
        for i in range(3):
            for j in range(3):
                R[i, j] = 0.0
                for k in range(3):
                    R[i, j] += R_WBs[a, k, i] * R_WBs[b, k, j]
        p_W = vector_in(p_WBs, a)
        p = unrotate(R_WBs[a], sub(vector_in(p_WBs, b), p_W))
        size = bodies.numbers[a, 0] + bodies.numbers[b, 0]
        if half_space:
            size = bodies.numbers[a, 0] + abs(R[0, 2] * p[0] + R[1, 2] * p[1] + R[2, 2] * p[2])
            # A rigid surface in a soft half space is N.
            flip = flip != (bodies.table[a, KIND] != VOLUME)
        between = Between(pair, a, b, R, p, R_WBs[a], p_W, ROUNDING * size, flip)
        if half_space:
            meet_plane(bodies, bodies.numbers[b, 1], between, scratch, out)
        else:
            meet_bodies(bodies, between, scratch, out)
        if out.counts[0] > len(out.ends) or out.counts[1] > len(out.points):
            out.counts[0], out.counts[1] = faces, points
            out.sums[pair] = 0.0
            return pair
        sums_in_world(out.sums, between)
        out.pair_ends[pair] = out.counts[0]
        if out.counts[0] == faces:
            out.swallowed[pair] = one_is_swallowed(bodies, between, scratch)
    return len(pairs)
