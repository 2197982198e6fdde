"""Asking for the surfaces of pairs, and what comes out: one array, shown as many."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    COUNTS,
    FACE,
    RECORD,
    SUMS,
    Bodies,
    Counts,
    Floats,
    Geometries,
    Hands,
    Indices,
    Scratch,
    Surfaces,
)
from drake_geom_ros.geometry._contact_surfaces.blocks import BLOCK, Blocks, put_in_order
from drake_geom_ros.geometry._contact_surfaces.clipping import COLUMNS, ROWS
from drake_geom_ros.geometry._contact_surfaces.layout import Layout, layout_of
from drake_geom_ros.geometry._contact_surfaces.limits import UNLIMITED, Limit
from drake_geom_ros.geometry._contact_surfaces.pairs import surfaces_of_pairs
from drake_geom_ros.geometry._contact_surfaces.posed import OTHER
from drake_geom_ros.geometry._contact_surfaces.triangles import MOST_TOGETHER
from drake_geom_ros.geometry._contact_surfaces.walks import DEEPEST
from drake_geom_ros.geometry._proximity.runtime.handles import handle_of

FIRST_POLYGONS = 512  # there is room for, and for CORNERS_EACH corners of each
_CORNERS_EACH = 5


class Posed:
    """Bodies, and the geometries that they are, to be asked about many times."""

    __slots__ = ('_kept', 'hands')

    def __init__(self, bodies: Bodies, geometries: Geometries) -> None:
        """Have bodies and geometries, whose poses may be written to between questions."""
        hands = Hands(handle_of(bodies), handle_of(geometries))
        self._kept, self.hands = (bodies, geometries, hands), handle_of(hands)


class Answer(NamedTuple):
    """The surfaces of pairs; what there is room for comes before what there is of it."""

    store: Floats  # all of it, for to make one array takes as long as many polygons
    layout: Layout
    counts: Counts

    @property
    def left(self) -> int:
        """Number of pairs that have no surface, and overlap or may overlap."""
        return self.counts.left

    @property
    def states(self) -> Indices:
        """State of each pair (k,)."""
        return self.store[self.layout.states : self.layout.faces].view(np.int64)

    def surfaces(self) -> Surfaces:
        """Return the arrays, not to be written to."""
        at, counts = self.layout, self.counts
        faces, corners, found = counts.polygons, counts.corners, counts.surfaces
        return Surfaces(
            points=self._part(at.points, 3 * corners).reshape(corners, 3),
            pressures=self._part(at.pressures, corners),
            ends=self._part(at.ends, faces).view(np.int64),
            faces=self._part(at.faces, FACE * faces).reshape(faces, FACE),
            sums=self._part(0, SUMS * found).reshape(found, SUMS),
            found=self._part(at.found, RECORD * found).view(np.int64).reshape(found, RECORD),
            states=self.states,
            counts=np.array(counts),
        )

    def _part(self, first: int, count: int) -> Floats:
        return self.store[first : first + count]


class _Room:
    """Room to compute in, for whoever asks next: to make it anew takes as long as a small surface.

    And how large the next answer may be: that of a scene is often as large as its last one.
    """

    def __init__(self) -> None:
        self.scratch = Scratch(
            np.empty((ROWS, COLUMNS)),
            np.empty(2 * DEEPEST, dtype=np.int64),
            np.empty((3, 3)),
            np.empty((OTHER, 4)),
            np.empty(2 * MOST_TOGETHER, dtype=np.int64),
            np.empty(SUMS),
            np.empty(COUNTS, dtype=np.int64),
        )
        self.handle = handle_of(self.scratch)
        self.faces, self.corners = FIRST_POLYGONS, _CORNERS_EACH * FIRST_POLYGONS

    def expect(self, faces: int, corners: int) -> None:
        """Have room for as many and half as many more, from now on."""
        least = FIRST_POLYGONS
        self.faces = max(least, faces + faces // 2)
        self.corners = max(_CORNERS_EACH * least, corners + corners // 2)


ROOMS: list[_Room] = []


def surfaces_of(posed: Posed, pairs: Indices, limit: Limit = UNLIMITED) -> Answer:
    """Return the surfaces of pairs (k, 2) of places of geometries; the lower one is M.

    Pairs that the ``limit`` leaves no time for are LATE: see ``blocks``.
    """
    try:
        room = ROOMS.pop()  # each thread takes another one
    except IndexError:
        room = _Room()
    most = room.faces, room.corners
    layout = layout_of(len(pairs), *most)
    store = np.empty(layout.size)
    counts = surfaces_of_pairs(posed.hands, room.handle, pairs, store, *most, 1, BLOCK)
    if counts.done < len(pairs):
        blocks = Blocks(posed.hands, room.handle, room.scratch.counts, limit)
        store, layout, counts, places = blocks.go_on(pairs, store, most, counts)
        if places is not None:
            put_in_order(Answer(store, layout, counts).surfaces(), places)
    if len(store) > layout_of(len(pairs), *most).size or (
        4 * counts.polygons < most[0] > FIRST_POLYGONS
    ):
        room.expect(counts.polygons, counts.corners)
    ROOMS.append(room)
    store.setflags(write=False)
    return Answer(store, layout, counts)
