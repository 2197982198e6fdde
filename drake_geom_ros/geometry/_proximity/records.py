"""What compiled code is handed a query, by name.

Python hands it over as plain tuples, which are made of these records once: to recognise a named
tuple of eleven arrays takes Numba 0.68 two microseconds more than a plain one (measured). Compiled
code names it again in its first lines, ``scene = Scene(*scene)``, which costs nothing. To hand
a record on inside a loop over pairs does cost, see ``narrow_phase``.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Plain: TypeAlias = tuple[Any, ...]  # a record as it is handed over


class Scene(NamedTuple):
    """Shapes (n,), where they are, how large, and how they moved: arrays of ``World``."""

    types: Indices
    starts: Indices
    pool: Floats
    R_WGs: Floats
    p_WGs: Floats
    roundings: Floats
    half_extents: Floats
    outer: Floats
    inner: Floats
    travels: Floats
    stamps: Indices


class Memory(NamedTuple):
    """The slots (m,) of ``NearList``: what is known of a pair."""

    answers: Floats  # (m, PAIR_WIDTH) the last answer; A is the first of the pair
    slacks: Floats  # [m] certified distance plus travels, both of the same time
    seen: Indices  # revision of the answer; -1: none yet
    gaps: Floats  # [m] the gap that the answer was computed for


class Query(NamedTuple):
    """What is asked of pairs."""

    gap: float  # [m] of the level; infinite: bounds alone will do
    cutoff: float  # [m]
    penetrating: bool  # only pairs count that overlap by more than touching


class Queue(NamedTuple):
    """Pairs that wait for a kernel: their numbers, and their certified least distances [m]."""

    waiting: Indices
    distances: Floats


def empty_memory(answers: Floats) -> Plain:
    """Return the memory, as a plain tuple, of pairs whose rows of answers hold hints or zeros."""
    m = len(answers)
    return tuple(
        Memory(answers=answers, slacks=np.full(m, -np.inf), seen=np.full(m, -1), gaps=np.zeros(m))
    )
