"""The arrays of a world, in the form that compiled functions take."""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.geometry._proximity.runtime.handles import (
    Flags,
    Integers,
    Matrices,
    RealPairs,
    Reals,
    Rows,
    Vectors,
    taker,
)


class WorldArrays(NamedTuple):
    """All arrays of a ``World`` of nf frames and n geometries, for a handle."""

    placings: Integers  # (1,) number of times that frames got their first pose
    # Of frames (nf,).
    named: Integers  # begins with the rows of the frames posed last
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
    body_data: Rows  # see ``pose_update``
    types: Integers
    starts: Integers  # (n + 1,)
    pool: Reals
    R_WGs: Matrices
    p_WGs: Vectors
    roundings: RealPairs
    half_extents: Vectors
    outer: Reals
    inner: Reals
    ball_centres: Vectors  # see ``quick_contacts``
    ball_radii: Reals
    stamps: Integers
    travels: Reals


world_of = taker(WorldArrays)
