"""Slots of the last answers of pairs, and the records that a query passes to compiled code.

The arrays of a world are passed as one handle (``runtime.handles``), from which compiled code
makes the record in its first lines: ``world = world_of(world)``. The small records below are
passed as plain tuples, whose types Numba recognises faster than those of named tuples, and become
records again in the same way: ``Query(*query)``. Neither costs anything there. Passing a record on
inside a loop over pairs does cost time, see ``narrow_phase``.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import SEEN, SLACK, SLOT_WIDTH
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class Query(NamedTuple):
    """Parameters of a query of pairs."""

    level_gap: float  # [m] of the level; infinite: bounds alone suffice
    cutoff: float  # [m]
    penetrating: bool  # only pairs that overlap by more than touching are hits


class Search(NamedTuple):
    """A search for all hits, or for one pair that is near enough."""

    first: int  # the pair to begin with; -1: all hits
    enough: float  # [m] a pair within it will do; ALL: none


ALL = -math.inf
# The search for all hits.
EVERY_HIT = Search(-1, ALL)[:]


class Queue(NamedTuple):
    """Pairs that wait for a kernel: their numbers, and lower bounds of their distances [m]."""

    waiting: Indices
    distances: Floats


# An empty queue, with which kernels run at once.
NO_QUEUE = Queue(np.zeros(0, dtype=np.int64), np.zeros(0))[:]


@allocating
def no_queue() -> tuple[Indices, Floats]:
    """Return an empty queue for compiled code, which sees arrays of a module as read-only."""
    return np.zeros(0, dtype=np.int64), np.zeros(0)


class Shapes(NamedTuple):
    """Type numbers, and the start of each shape's parameters in the pool."""

    types: Indices
    starts: Indices
    pool: Floats


def empty_memory(pairs: int) -> Floats:
    """Return an empty memory (m, SLOT_WIDTH) of the last answers of m pairs.

    The slot of a pair, a row, has its last answer, with the first body of the pair as A; its SLACK
    [m], a certified distance plus the travels at the same time; the revision in which it was SEEN,
    -1 for never; and the LEVEL_GAP [m] of the answer. A slot is contiguous, because with 30 000
    balls the slots exceed the caches.
    """
    memory = np.zeros((pairs, SLOT_WIDTH))
    memory[:, SLACK], memory[:, SEEN] = -np.inf, -1.0
    return memory
