"""Cost of the current pairs at each accuracy level, measured on a sample."""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.kernels.addresses import (
    ADDRESSES,
    compile_rows,
    table_rows,
)
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.pairs.narrow_phase import answer_pairs
from drake_geom_ros.geometry._proximity.pairs.slots import EVERY_HIT, NO_QUEUE, empty_memory
from drake_geom_ros.geometry._proximity.report import COUNTS, POSTPONED
from drake_geom_ros.geometry._proximity.tolerances import GAPS_OF_LEVELS
from drake_geom_ros.geometry._proximity.world.world import World

Indices = NDArray[np.int64]

# The lengths [m] whose costs are told, by their names: the levels, and one centimetre.
COSTED = {'bound': GAPS_OF_LEVELS['bound'], '0.01': 0.01, **GAPS_OF_LEVELS}
LOOKED_AT = 4096  # pairs from which the sample is drawn: a list of all pairs may have millions
LAPS = 2  # repetitions of a sample in one call, since the call costs as much as closed forms
TRIALS = 2  # the fastest counts: other load only adds time


def seconds_a_pair(
    world: World, filters: FilterState, cutoff: float, most: int, seed: int
) -> tuple[dict[str, float], int]:
    """Return the seconds per pair at each level and at 0.01 m, and the number of pairs sampled.

    At most ``most`` of the unfiltered pairs whose boxes are within ``cutoff`` [m] are sampled, by
    ``seed``. The dictionary is empty if there are none. Each pair is computed without a cache.
    """
    world.update()
    near = NeighbourList(world)
    near.bring_up_to_date(world, filters, cutoff)
    rng = np.random.default_rng(seed)
    pairs = _some(rng, near.pairs, LOOKED_AT)
    waiting, distances = np.empty(len(pairs), dtype=np.int64), np.empty(len(pairs))
    _, counts = _answer(world, pairs, math.inf, cutoff, (waiting, distances))
    chosen = _some(rng, pairs[waiting[: counts[POSTPONED]]], most)
    if not len(chosen):
        return {}, 0
    pairs = np.tile(chosen, (LAPS, 1))
    compile_rows(table_rows(*world.geometries.types[pairs].T))
    costs = {}
    for level, level_gap in COSTED.items():
        trials = [_answer(world, pairs, level_gap, cutoff, NO_QUEUE) for _ in range(TRIALS)]
        costs[level] = min(seconds for seconds, _ in trials) / len(pairs)
    return costs, len(chosen)


def _some(rng: np.random.Generator, pairs: Indices, most: int) -> Indices:
    """Return at most ``most`` random pairs of (k, 2), in their order."""
    if len(pairs) <= most:
        return pairs
    return pairs[np.sort(rng.choice(len(pairs), most, replace=False))]


def _answer(
    world: World,
    pairs: Indices,
    level_gap: float,
    cutoff: float,
    queue: tuple[Indices, NDArray[np.float64]],
) -> tuple[float, Indices]:
    """Answer pairs (n, 2) without cached answers; return the seconds and the counts."""
    n = len(pairs)
    slots, hits = np.arange(n), np.empty(n, dtype=np.int64)
    memory = empty_memory(n)
    counts = np.zeros(COUNTS, dtype=np.int64)
    start = time.perf_counter()
    answer_pairs(
        ADDRESSES,
        pairs,
        slots,
        memory,
        world.handle,
        world.revision,
        (level_gap, cutoff, False),
        EVERY_HIT,
        queue,
        hits,
        counts,
    )
    return time.perf_counter() - start, counts
