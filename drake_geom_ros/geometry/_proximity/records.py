"""What compiled code is handed a query, by name.

The arrays of a world go over as one handle (``handing``), of which compiled code makes the record
in its first lines: ``world = world_of(world)``. The small records below go over as plain tuples,
which Numba recognises sooner than named ones, and are named again likewise: ``Memory(*memory)``.
Neither costs anything there; to hand a record on inside a loop over pairs does, see
``narrow_phase``.
"""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.handing import (
    Flags,
    Integers,
    Matrices,
    RealPairs,
    Reals,
    Rows,
    Vectors,
    taker,
)

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Plain: TypeAlias = tuple[Any, ...]  # a record as it is handed over


class WorldArrays(NamedTuple):
    """All arrays of a ``World`` of nf frames and n geometries, for a handle."""

    # Of frames (nf,).
    moved: Flags
    parents: Integers
    R_PFs: Matrices
    p_PFs: Vectors
    R_WFs: Matrices
    p_WFs: Vectors
    frame_roundings: RealPairs
    # Of geometries (n,), but for ``movable``: the rows of those that are not anchored.
    movable: Integers
    ids: Integers
    frames: Integers
    waiting: Flags
    R_FGs: Matrices
    p_FGs: Vectors
    kept: Rows  # see ``posing``
    types: Integers
    starts: Integers  # (n + 1,)
    pool: Reals
    R_WGs: Matrices
    p_WGs: Vectors
    roundings: RealPairs
    half_extents: Vectors
    outer: Reals
    inner: Reals
    ball_centres: Vectors  # see ``plain_contacts``
    ball_radii: Reals
    stamps: Integers
    travels: Reals


world_of = taker(WorldArrays)


class Memory(NamedTuple):
    """The slots (m,) of ``NearList``: what is known of a pair."""

    answers: Floats  # (m, PAIR_WIDTH, or more) the last answer; A is the first of the pair
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
