"""Surfaces that take long, block by block: so that there is a limit, and signals are heard."""

from __future__ import annotations

import math
import time

import numpy as np

from drake_geom_ros.geometry._contact_surfaces.arrays import (
    CORNERS,
    CORNERS_BEFORE,
    DONE,
    FACES_BEFORE,
    LAST,
    LATE,
    LEFT,
    POLYGONS,
    PRESSES,
    STAGE,
    Counts,
    Floats,
    Indices,
    Surfaces,
)
from drake_geom_ros.geometry._contact_surfaces.layout import Layout, layout_of
from drake_geom_ros.geometry._contact_surfaces.limits import Limit
from drake_geom_ros.geometry._contact_surfaces.pairs import surfaces_of_pairs
from drake_geom_ros.geometry._proximity.runtime.handles import Handle

BLOCK = 1 << 16  # steps of one call: 1 to 10 ms, in which no signal is heard, and no limit


class Blocks:
    """Goes on with the surfaces of pairs after the first block.

    Under a limit a pair that takes longer than a block waits until all others are done, so that it
    takes no time from them; those that no time is left for are LATE.
    """

    def __init__(self, hands: Handle, room: Handle, counts: Indices, limit: Limit) -> None:
        """Work in a room whose ``counts`` are these, which the kernels write to."""
        self._hands, self._room, self._counts, self._limit = hands, room, counts, limit
        self._is_limited = min(limit.steps, limit.seconds) < math.inf
        self._end = time.perf_counter() + limit.seconds
        self._steps = limit.steps - BLOCK
        self._waiting = 0  # pairs, the last ones

    def go_on(
        self, pairs: Indices, store: Floats, most: tuple[int, int], counts: Counts
    ) -> tuple[Floats, Layout, Counts, Indices | None]:
        """Return the whole answer, and the places of its pairs where some had to wait.

        ``store`` has room for ``most`` polygons and corners, and what there is by now.
        """
        count, places = len(pairs), np.arange(len(pairs))
        while counts.done < count:
            if counts.is_full:
                store, most = _larger(store, count, most)
            elif self._is_over():
                self._leave_the_rest(store, count, most)
            elif self._must_wait(count):
                self._drop_pair()
                ends = counts.done, count - 1
                pairs, places = _moved(pairs, *ends), _moved(places, *ends)
            counts = surfaces_of_pairs(self._hands, self._room, pairs, store, *most, 0, BLOCK)
            self._steps -= BLOCK
        return store, layout_of(count, *most), counts, places if self._waiting else None

    def _is_over(self) -> bool:
        """Return whether the limit is reached."""
        limit = self._limit
        return self._steps <= 0 or time.perf_counter() >= self._end or limit.must_stop()

    def _must_wait(self, count: int) -> bool:
        """Return whether the pair that a block has ended in waits for others, and count it."""
        others = count - self._waiting - int(self._counts[DONE]) > 1
        waits = self._is_limited and others
        self._waiting += waits
        return waits

    def _drop_pair(self) -> None:
        """Forget what there is of the pair that is not done."""
        counts = self._counts
        if counts[STAGE]:
            counts[POLYGONS], counts[CORNERS] = counts[FACES_BEFORE], counts[CORNERS_BEFORE]
            counts[STAGE] = 0

    def _leave_the_rest(self, store: Floats, count: int, most: tuple[int, int]) -> None:
        """Say of all pairs that are not done that they are LATE."""
        self._drop_pair()
        counts, at = self._counts, layout_of(count, *most)
        done = int(counts[DONE])
        store[at.states : at.faces].view(np.int64)[done:] = LATE
        counts[LEFT] += count - done
        counts[DONE] = count


def _larger(store: Floats, pairs: int, most: tuple[int, int]) -> tuple[Floats, tuple[int, int]]:
    """Return room for twice as many polygons and corners, with what there is of them."""
    twice = 2 * most[0], 2 * most[1]
    before, after = layout_of(pairs, *most), layout_of(pairs, *twice)
    larger = np.empty(after.size)
    # Before the polygons nothing grows; then each part begins elsewhere.
    ends, starts = before[2:], ((0, *before[2:-1]), (0, *after[2:-1]))
    for start, to, end in zip(*starts, ends, strict=True):
        larger[to : to + end - start] = store[start:end]
    return larger, twice


def _moved(rows: Indices, first: int, to: int) -> Indices:
    """Return rows of which one is moved behind another one."""
    return np.concatenate(
        (rows[:first], rows[first + 1 : to + 1], rows[first : first + 1], rows[to + 1 :])
    )


def put_in_order(surfaces: Surfaces, places: Indices) -> None:
    """Put surfaces and states of pairs, which are at these places in truth, in their order."""
    states, found, ends = surfaces.states, surfaces.found, surfaces.ends
    order = np.argsort(places[states == PRESSES])
    states[places] = states.copy()
    firsts = np.concatenate(([0], found[:-1, LAST]))
    sizes = (found[:, LAST] - firsts)[order]
    polygons = _rows(firsts[order], sizes)
    starts = np.concatenate(([0], ends[:-1]))
    corner_counts = (ends - starts)[polygons]
    corners = _rows(starts[polygons], corner_counts)
    surfaces.points[:], surfaces.pressures[:] = (
        surfaces.points[corners],
        surfaces.pressures[corners],
    )
    surfaces.faces[:], ends[:] = surfaces.faces[polygons], np.cumsum(corner_counts)
    surfaces.sums[:], found[:] = surfaces.sums[order], found[order]
    found[:, LAST] = np.cumsum(sizes)


def _rows(firsts: Indices, counts: Indices) -> Indices:
    """Return so many rows from each first one on, one after another."""
    before = np.cumsum(counts) - counts
    return np.repeat(firsts - before, counts) + np.arange(counts.sum())
