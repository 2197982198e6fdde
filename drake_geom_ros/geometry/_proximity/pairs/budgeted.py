"""Answers in steps: what is known first, and what kernels compute apart, or as time allows."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.addresses import ADDRESSES
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.pairs.budget import Pace
from drake_geom_ros.geometry._proximity.pairs.narrow_phase import answer_pairs, bound_pairs
from drake_geom_ros.geometry._proximity.pairs.slots import NO_QUEUE
from drake_geom_ros.geometry._proximity.report import (
    BY_METHOD,
    CACHED,
    COMPILED,
    KNOWING,
    POSTPONED,
    ReportArrays,
)
from drake_geom_ros.geometry._proximity.runtime.threads import share
from drake_geom_ros.geometry._proximity.world.world import World

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class BudgetedAnswers:
    """Runs the narrow phase over lists that are up to date, and reports what it did."""

    def __init__(self, report: ReportArrays) -> None:
        self.pace = Pace()
        self.unrefined = 0  # pairs that the last answer left at their bounds
        self._counts, self._moments = report.counts, report.moments

    def answer_list(
        self, world: World, near: NeighbourList, query: tuple[float, float, bool], budget: float
    ) -> Indices:
        """Return the numbers of the pairs that ``query`` is about.

        Kernels run for all that need one where the ``budget`` [s] is 0, and the seconds of what
        was known are told apart; else for the nearest pairs, while it lasts.
        """
        self.unrefined = 0
        if budget <= 0.0:
            return self.answer_apart(world, near, query)
        if not self.pace.fits(near.count, budget):
            return self.answer_within(world, near, query, budget)
        asked = near.pairs, near.slots, near.memory, query
        hits = self.answer(world, *asked, near.arrays.hits)
        computed = int(self._counts[BY_METHOD:].sum())
        self.pace.learn(computed, time.perf_counter() - self._moments[COMPILED])
        return hits

    def answer(
        self,
        world: World,
        pairs: Indices,
        slots: Indices,
        memory: Floats,
        query: tuple[float, float, bool],
        hits: Indices,
        queue: tuple[Indices, Floats] = NO_QUEUE,
    ) -> Indices:
        """Return the numbers of the pairs that ``query`` is about, their slots up to date.

        With a ``queue`` for all pairs, those that need a kernel are put there instead.
        """
        found = answer_pairs(
            ADDRESSES,
            pairs,
            slots,
            memory,
            world.handle,
            world.revision,
            query,
            -1,
            queue,
            hits,
            self._counts,
        )
        return hits[:found]

    def answer_shared(
        self, world: World, near: NeighbourList, query: tuple[float, float, bool]
    ) -> Indices:
        """Return what ``answer`` does of a list, by threads."""
        room = near.arrays.hits

        def answer(first: int, last: int) -> tuple[int, int, Indices]:
            counts = np.zeros_like(self._counts)
            found = answer_pairs(
                ADDRESSES,
                near.pairs[first:last],
                near.slots[first:last],
                near.memory,
                world.handle,
                world.revision,
                query,
                -1,
                NO_QUEUE,
                room[first:last],
                counts,
            )
            return first, found, counts

        parts = share(near.count, answer)
        self._counts[:] = sum(counts for _, _, counts in parts)
        return np.concatenate([room[first : first + found] + first for first, found, _ in parts])

    def answer_apart(
        self, world: World, near: NeighbourList, query: tuple[float, float, bool]
    ) -> Indices:
        """Return what ``_answer`` does: first what is known, then what kernels have to compute."""
        waiting, _ = queue = np.empty(len(near.pairs), dtype=np.int64), np.zeros(0)
        asked, room = (near.pairs, near.slots, near.memory, query), near.arrays.hits
        known = self.answer(world, *asked, room, queue=queue).copy()
        total = self._counts.copy()
        if total[CACHED]:
            self._moments[KNOWING] = time.perf_counter() - self._moments[COMPILED]
        some = waiting[: total[POSTPONED]]
        total[POSTPONED] = 0
        hits = some[self.answer(world, near.pairs[some], near.slots[some], *asked[2:], room)]
        self._counts[:] += total
        return np.sort(np.concatenate((known, hits)))

    def answer_within(
        self, world: World, near: NeighbourList, query: tuple[float, float, bool], seconds: float
    ) -> Indices:
        """Return what ``_answer`` does, kernels for the nearest pairs only as time lasts."""
        most, room = near.count, near.arrays.hits
        waiting, distances = queue = np.empty(most, dtype=np.int64), np.empty(most)
        start = float(self._moments[COMPILED])
        known = self.answer(world, near.pairs, near.slots, near.memory, query, room, queue=queue)
        hits, total = [known.copy()], self._counts.copy()
        count = int(total[POSTPONED])
        total[POSTPONED] = 0

        def compute(block: Indices) -> None:
            some = waiting[block]
            asked = near.pairs[some], near.slots[some], near.memory, query
            hits.append(some[self.answer(world, *asked, room)])
            total[:] += self._counts

        # What is left is bounded once more, as all that wait were just now.
        reserve = (time.perf_counter() - start) / max(1, count)
        left = self.pace.spend(distances[:count], compute, start + seconds, reserve)
        if len(left):
            some = waiting[left]
            found = bound_pairs(
                near.pairs[some],
                near.slots[some],
                near.memory,
                world.handle,
                world.revision,
                query,
                room,
                self._counts,
            )
            hits.append(some[room[:found]])
            total += self._counts
            self.unrefined = found
        self._counts[:] = total
        return np.sort(np.concatenate(hits))
