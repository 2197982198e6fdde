"""What compiled code is handed a query, by name.

The arrays of a world go over as one handle (``runtime.handles``), of which compiled code makes the
record in its first lines: ``world = world_of(world)``. The small records below go over as plain
tuples, which Numba recognises sooner than named ones, and are named again likewise:
``Memory(*memory)``. Neither costs anything there; to hand a record on inside a loop over pairs
does, see ``narrow_phase``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import SEEN, SLACK, SLOT_WIDTH
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class Query(NamedTuple):
    """What is asked of pairs."""

    level_gap: float  # [m] of the level; infinite: bounds alone will do
    cutoff: float  # [m]
    penetrating: bool  # only pairs count that overlap by more than touching


class Queue(NamedTuple):
    """Pairs that wait for a kernel: their numbers, and their certified least distances [m]."""

    waiting: Indices
    distances: Floats


# A queue in which no pair waits, so that kernels run at once.
NO_QUEUE = Queue(np.zeros(0, dtype=np.int64), np.zeros(0))[:]


@allocating
def no_queue() -> tuple[Indices, Floats]:
    """Return the same for compiled code, to which arrays of a module are read-only."""
    return np.zeros(0, dtype=np.int64), np.zeros(0)


class Shapes(NamedTuple):
    """Type numbers, and where in the pool the parameters are."""

    types: Indices
    starts: Indices
    pool: Floats


def empty_memory(pairs: int) -> Floats:
    """Return a memory (m, SLOT_WIDTH) of pairs of which nothing is known.

    The slot of a pair, a row, has its last answer, of which A is the first of the pair; its SLACK
    [m], a certified distance plus travels, both of the same time; in which revision it was SEEN,
    -1 for never; and for which GAP [m] the answer was computed. All in one place: of 30 000 balls,
    slots come from memory again and again.
    """
    memory = np.zeros((pairs, SLOT_WIDTH))
    memory[:, SLACK], memory[:, SEEN] = -np.inf, -1.0
    return memory
