"""All pairs of bodies, one after another."""

from __future__ import annotations

from typing import Any

import numpy as np

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    COMPLIANT_M,
    COMPLIANT_N,
    CORNERS,
    COUNTS,
    FACE,
    FOUND,
    HALF_SPACE,
    ID_M,
    ID_N,
    KIND,
    LAST,
    LEFT,
    NOTHING,
    POLYGONS,
    PRESSES,
    RECORD,
    SUMS,
    SWALLOWED,
    TURNED,
    UNABLE,
    VOLUME,
    Asked,
    Between,
    Bodies,
    Floats,
    Scratch,
    Surfaces,
)
from drake_geom_ros.geometry._contact_surfaces.clipping import COLUMNS, ROWS
from drake_geom_ros.geometry._contact_surfaces.compiled import compiled, inlined
from drake_geom_ros.geometry._contact_surfaces.emitting import sums_in_world
from drake_geom_ros.geometry._contact_surfaces.posed import OTHER
from drake_geom_ros.geometry._contact_surfaces.swallowed import one_is_swallowed
from drake_geom_ros.geometry._contact_surfaces.tolerances import ROUNDING
from drake_geom_ros.geometry._contact_surfaces.walks import DEEPEST, meet_bodies, meet_plane
from drake_geom_ros.geometry._proximity.kernels.vectors import sub, unrotate, vector_in

FIRST_POLYGONS = 4096  # there is room for, and for CORNERS_EACH corners of each
CORNERS_EACH = 5


# To compute in, for whoever asks next: to make it anew takes as long as a small surface.
_ROOM: list[Scratch] = []


def surfaces_of(bodies: Bodies, asked: Asked) -> Surfaces:
    """Return the surfaces of pairs; the geometry of lower id is M."""
    faces, corners, count = FIRST_POLYGONS, CORNERS_EACH * FIRST_POLYGONS, len(asked.pairs)
    try:
        scratch = _ROOM.pop()  # each thread takes another one
    except IndexError:
        scratch = _scratch()
    out = Surfaces(
        np.empty((corners, 3)),
        np.empty(corners),
        np.empty(faces, dtype=np.int64),
        np.empty((faces, FACE)),
        np.empty((count, SUMS)),
        np.empty((count, RECORD), dtype=np.int64),
        np.empty(count, dtype=np.int64),
        np.zeros(COUNTS, dtype=np.int64),
    )
    done = 0
    while (done := _next_pairs(bodies, asked, scratch, out, done)) < count:
        faces, corners = 2 * len(out.ends), 2 * len(out.points)
        out = Surfaces(
            _more(out.points, corners),
            _more(out.pressures, corners),
            _more(out.ends, faces),
            _more(out.faces, faces),
            out.sums,
            out.found,
            out.states,
            out.counts,
        )
    _ROOM.append(scratch)
    faces, corners, found, _left = out.counts.tolist()
    return Surfaces(
        out.points[:corners],
        out.pressures[:corners],
        out.ends[:faces],
        out.faces[:faces],
        out.sums[:found],
        out.found[:found],
        out.states,
        out.counts,
    )


def _scratch() -> Scratch:
    """Return room to compute in."""
    return Scratch(
        np.empty((ROWS, COLUMNS)),
        np.empty(2 * DEEPEST, dtype=np.int64),
        np.empty((3, 3)),
        np.empty((OTHER, 4)),
    )


def _more(array: Any, count: int) -> Any:
    """Return the rows of an array, and room for so many in all."""
    more = np.empty((count, *array.shape[1:]), array.dtype)
    more[: len(array)] = array
    return more


@compiled
def _next_pairs(bodies: Bodies, asked: Asked, scratch: Scratch, out: Surfaces, done: int) -> int:
    """Put out the surfaces of pairs but those done; return for which one there was no room.

    That pair is as if it had not been looked at. Where all are done it is their number.
    """
    for pair in range(done, len(asked.pairs)):
        faces, corners, row = out.counts[POLYGONS], out.counts[CORNERS], out.counts[FOUND]
        m = min(asked.pairs[pair, 0], asked.pairs[pair, 1])
        n = max(asked.pairs[pair, 0], asked.pairs[pair, 1])
        M, N = asked.body_of[m], asked.body_of[n]
        if not _can_press(bodies, M, N):
            out.states[pair] = UNABLE
            out.counts[LEFT] += 1
            continue
        for column in range(SUMS):
            out.sums[row, column] = 0.0
        between = _between(bodies, asked, (m, n), row, scratch.R)
        _meet(bodies, between, scratch, out)
        if out.counts[POLYGONS] > len(out.ends) or out.counts[CORNERS] > len(out.points):
            out.counts[POLYGONS], out.counts[CORNERS] = faces, corners
            return pair
        if out.counts[POLYGONS] > faces:
            sums_in_world(out.sums, between)
            out.states[pair] = PRESSES
            out.counts[FOUND] += 1
            out.found[row, ID_M], out.found[row, ID_N] = asked.ids[m], asked.ids[n]
            out.found[row, COMPLIANT_M] = 1 if _is_compliant(bodies, M) else 0
            out.found[row, COMPLIANT_N] = 1 if _is_compliant(bodies, N) else 0
            out.found[row, LAST] = out.counts[POLYGONS]
            continue
        out.states[pair] = _without_surface(bodies, between, scratch, out)
        if out.states[pair] != NOTHING:
            out.counts[LEFT] += 1
    return len(asked.pairs)


@compiled
def _meet(bodies: Bodies, between: Between, scratch: Scratch, out: Surfaces) -> None:
    """Put out the polygons of two bodies."""
    if bodies.table[between.b, KIND] == HALF_SPACE:
        meet_plane(bodies, bodies.numbers[between.b, 1], between, scratch, out)
    else:
        meet_bodies(bodies, between, scratch, out)


@compiled
def _without_surface(bodies: Bodies, between: Between, scratch: Scratch, out: Surfaces) -> int:
    """Return whether two bodies without polygons overlap all the same, and how.

    Say there is no face where both pressures are equal, or where a rigid surface is in the other
    body, whatever its normal. Compliant bodies are of one piece, with pressure all over inside. Of
    two of them the difference of pressures has then the same sign all over each piece of what is
    in both. On the surface of each, inside the other, its own pressure is the lower one: so that
    piece is bounded by the surface of one of them alone, which is all of that body, with its
    innermost point. A rigid surface that does not enter the other body has all of it inside or
    outside. So the innermost points tell.
    """
    if one_is_swallowed(bodies, between, scratch):
        return SWALLOWED
    faces, corners, b = out.counts[POLYGONS], out.counts[CORNERS], between
    again = Between(b.row, b.a, b.b, b.R, b.p, b.R_W, b.p_W, b.rounding, b.flip, True)
    _meet(bodies, again, scratch, out)
    turned = out.counts[POLYGONS] > faces
    out.counts[POLYGONS], out.counts[CORNERS] = faces, corners
    return TURNED if turned else NOTHING


@inlined
def _is_compliant(bodies: Bodies, body: int) -> bool:
    """Tell whether there is pressure in a body."""
    kind = bodies.table[body, KIND]
    compliant: bool = kind == VOLUME or (kind == HALF_SPACE and bodies.numbers[body, 1] > 0.0)
    return compliant


@inlined
def _can_press(bodies: Bodies, M: int, N: int) -> bool:
    """Tell whether two bodies, -1 for none, can have a surface."""
    if M < 0 or N < 0 or not (_is_compliant(bodies, M) or _is_compliant(bodies, N)):
        return False
    able: bool = bodies.table[M, KIND] != HALF_SPACE or bodies.table[N, KIND] != HALF_SPACE
    return able


@inlined
def _between(bodies: Bodies, asked: Asked, pair: tuple[int, int], row: int, R: Floats) -> Between:
    """Return two geometries' bodies, a tetrahedral one before a surface before a half space.

    ``R`` is where the orientation of the second in the first is put.
    """
    a, b = pair
    flip = bodies.table[asked.body_of[b], KIND] < bodies.table[asked.body_of[a], KIND]
    if flip:
        a, b = b, a
    first, second = asked.body_of[a], asked.body_of[b]
    for i in range(3):
        for j in range(3):
            R[i, j] = 0.0
            for k in range(3):
                R[i, j] += asked.R_WGs[a, k, i] * asked.R_WGs[b, k, j]
    p_W = vector_in(asked.p_WGs, a)
    p = unrotate(asked.R_WGs[a], sub(vector_in(asked.p_WGs, b), p_W))
    size = bodies.numbers[first, 0] + bodies.numbers[second, 0]
    if bodies.table[second, KIND] == HALF_SPACE:
        size = bodies.numbers[first, 0] + abs(R[0, 2] * p[0] + R[1, 2] * p[1] + R[2, 2] * p[2])
        # A rigid surface in a soft half space is N.
        flip = flip != (bodies.table[first, KIND] != VOLUME)
    return Between(row, first, second, R, p, asked.R_WGs[a], p_W, ROUNDING * size, flip, False)
