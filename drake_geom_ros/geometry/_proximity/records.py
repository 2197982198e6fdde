"""What compiled code is handed a query, by name.

Python hands it over as plain tuples, which are made of these records once: to recognise a named
tuple of eleven arrays takes Numba 0.68 two microseconds more than a plain one (measured). Compiled
code names it again in its first lines, ``scene = Scene(*scene)``, which costs nothing. To hand
a record on inside a loop over pairs does cost, see ``narrow_phase``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.compiled import inlined
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

    def some(self, names: Sequence[str]) -> Plain:
        """Return some of the arrays, by their names, as a plain tuple."""
        return tuple(getattr(self, name) for name in names)


# What ``batches.gather`` takes of it.
POSED = 'ids', 'types', 'frames', 'R_WGs', 'p_WGs', 'roundings', 'p_WFs', 'outer'

world_of = taker(WorldArrays)


@inlined
def scene_of(world):  # type: ignore[no-untyped-def]
    """Return the ``Scene`` of ``WorldArrays``."""
    return Scene(
        world.types,
        world.starts,
        world.pool,
        world.R_WGs,
        world.p_WGs,
        world.roundings,
        world.half_extents,
        world.outer,
        world.inner,
        world.travels,
        world.stamps,
    )


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
