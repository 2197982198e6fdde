"""Narrow phase in steps: cached answers first, then kernels, possibly within a time budget."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.addresses import ADDRESSES
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.pairs.budget import Pace
from drake_geom_ros.geometry._proximity.pairs.narrow_phase import answer_pairs, bound_pairs
from drake_geom_ros.geometry._proximity.pairs.slots import EVERY_HIT, NO_QUEUE
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
    """Runs the narrow phase over up-to-date neighbour lists, and reports its work."""

    def __init__(self, report: ReportArrays) -> None:
        self.pace = Pace()
        self.unrefined = 0  # pairs that the last answer left at their bounds
        self._counts, self._moments = report.counts, report.moments

    def answer_list(
        self, world: World, near: NeighbourList, query: tuple[float, float, bool], budget: float
    ) -> Indices:
        """Return the numbers of the listed pairs that are hits of ``query``.

        With a ``budget`` of 0 [s], kernels run for all pairs that need one, and the cache lookup
        is timed separately. Otherwise they run for the nearest pairs until the budget is spent.
        """
        self.unrefined = 0
        if budget <= 0.0:
            return self.answer_apart(world, near, query)
        if not self.pace.fits(near.count, budget):
            return self.answer_within(world, near, query, budget)
        arguments = near.pairs, near.slots, near.memory, query
        hits = self.answer(world, *arguments, near.arrays.hits)
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
        """Return the numbers of the pairs that are hits of ``query``, and update their slots.

        With a ``queue`` that fits all pairs, pairs that need a kernel go there instead.
        """
        hit_count = answer_pairs(
            ADDRESSES,
            pairs,
            slots,
            memory,
            world.handle,
            world.revision,
            query,
            EVERY_HIT,
            queue,
            hits,
            self._counts,
        )
        return hits[:hit_count]

    def answer_shared(
        self, world: World, near: NeighbourList, query: tuple[float, float, bool]
    ) -> Indices:
        """Return the hits of ``answer`` for a neighbour list, computed by threads."""
        hits = near.arrays.hits

        def answer(first: int, last: int) -> tuple[int, int, Indices]:
            counts = np.zeros_like(self._counts)
            hit_count = answer_pairs(
                ADDRESSES,
                near.pairs[first:last],
                near.slots[first:last],
                near.memory,
                world.handle,
                world.revision,
                query,
                EVERY_HIT,
                NO_QUEUE,
                hits[first:last],
                counts,
            )
            return first, hit_count, counts

        parts = share(near.count, answer)
        self._counts[:] = sum(counts for _, _, counts in parts)
        return np.concatenate(
            [hits[first : first + hit_count] + first for first, hit_count, _ in parts]
        )

    def answer_apart(
        self, world: World, near: NeighbourList, query: tuple[float, float, bool]
    ) -> Indices:
        """Return the hits of ``answer``, with cached pairs and kernels timed separately."""
        waiting, _ = queue = np.empty(len(near.pairs), dtype=np.int64), np.zeros(0)
        arguments, hit_buffer = (near.pairs, near.slots, near.memory, query), near.arrays.hits
        cached_hits = self.answer(world, *arguments, hit_buffer, queue=queue).copy()
        total = self._counts.copy()
        if total[CACHED]:
            self._moments[KNOWING] = time.perf_counter() - self._moments[COMPILED]
        queued = waiting[: total[POSTPONED]]
        total[POSTPONED] = 0
        hits = queued[
            self.answer(world, near.pairs[queued], near.slots[queued], *arguments[2:], hit_buffer)
        ]
        self._counts[:] += total
        return np.sort(np.concatenate((cached_hits, hits)))

    def answer_within(
        self, world: World, near: NeighbourList, query: tuple[float, float, bool], seconds: float
    ) -> Indices:
        """Return the hits of ``answer``, with kernels for the nearest pairs in ``seconds`` [s]."""
        most, hit_buffer = near.count, near.arrays.hits
        waiting, distances = queue = np.empty(most, dtype=np.int64), np.empty(most)
        start = float(self._moments[COMPILED])
        cached_hits = self.answer(
            world, near.pairs, near.slots, near.memory, query, hit_buffer, queue=queue
        )
        hits, total = [cached_hits.copy()], self._counts.copy()
        count = int(total[POSTPONED])
        total[POSTPONED] = 0

        def compute(block: Indices) -> None:
            queued = waiting[block]
            arguments = near.pairs[queued], near.slots[queued], near.memory, query
            hits.append(queued[self.answer(world, *arguments, hit_buffer)])
            total[:] += self._counts

        # Bounding the rest again costs about as much as bounding all queued pairs just did.
        reserve = (time.perf_counter() - start) / max(1, count)
        left = self.pace.spend(distances[:count], compute, start + seconds, reserve)
        if len(left):
            queued = waiting[left]
            hit_count = bound_pairs(
                near.pairs[queued],
                near.slots[queued],
                near.memory,
                world.handle,
                world.revision,
                query,
                hit_buffer,
                self._counts,
            )
            hits.append(queued[hit_buffer[:hit_count]])
            total += self._counts
            self.unrefined = hit_count
        self._counts[:] = total
        return np.sort(np.concatenate(hits))
