"""Where everything is: frame poses, geometry poses, packed shapes and their bounds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.kernels.bounds import (
    box_half_extents,
    shape_radii,
)

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class FrameTable(NamedTuple):
    """The frames, parents before children; row 0 is the world."""

    ids: Indices  # (nf,) FrameId values
    parents: Indices  # (nf,) rows; the world's is 0


class GeometryTable(NamedTuple):
    """The geometries with the proximity role, in ascending order of their ids."""

    ids: Indices  # (n,) GeometryId values
    frames: Indices  # (n,) rows of the FrameTable
    R_FGs: Floats  # (n, 3, 3)
    p_FGs: Floats  # (n, 3) [m]
    types: Indices  # (n,) shape type numbers
    starts: Indices  # (n + 1,) shape k's parameters are pool[starts[k] : starts[k + 1]]
    pool: Floats


class World:
    """The poses of a scene's frames and the posed, packed proximity geometry.

    Poses go in through ``set_poses``; ``update`` brings everything that hangs on a moved frame up
    to date and leaves the rest alone.
    """

    def __init__(self, frames: FrameTable, geometries: GeometryTable) -> None:
        """Pose every frame at its parent's origin."""
        count = len(frames.ids)
        self.frames = frames
        self.geometries = geometries
        self.R_PFs = np.tile(np.eye(3), (count, 1, 1))
        self.p_PFs = np.zeros((count, 3))
        self.R_WFs = self.R_PFs.copy()
        self.p_WFs = self.p_PFs.copy()
        self._order = np.argsort(frames.ids)
        self._sorted_ids = frames.ids[self._order]
        self._moved = np.ones(count, dtype=np.bool_)
        self._stale = True
        self._allocate_geometries()

    def _allocate_geometries(self) -> None:
        """Make room for the posed geometry and compute what does not depend on poses."""
        table = self.geometries
        n = len(table.ids)
        self.R_WGs = np.empty((n, 3, 3))
        self.p_WGs = np.empty((n, 3))
        self.half_extents = np.empty((n, 3))  # of the box around Go, in World axes [m]
        self.anchored = table.frames == 0
        # Largest distance from Go and largest ball about Go that fits [m].
        self.outer_radii, self.inner_radii = shape_radii(table.types, table.starts, table.pool)

    @property
    def geometry_count(self) -> int:
        """The number of geometries with the proximity role."""
        return len(self.geometries.ids)

    def copy(self) -> World:
        """Return a world with poses of its own; the tables, which never change, are shared."""
        other = World.__new__(World)
        other.__dict__.update(self.__dict__)
        for name, value in self.__dict__.items():
            if isinstance(value, np.ndarray):
                setattr(other, name, value.copy())
        return other

    def rebuilt(self, frames: FrameTable, geometries: GeometryTable) -> World:
        """Return a world of new tables in which every frame that was here keeps its pose."""
        other = World(frames, geometries)
        rows = {int(frame): row for row, frame in enumerate(self.frames.ids)}
        pairs = [(k, rows[int(f)]) for k, f in enumerate(frames.ids) if int(f) in rows]
        new, old = (list(side) for side in zip(*pairs, strict=True))
        other.R_PFs[new], other.p_PFs[new] = self.R_PFs[old], self.p_PFs[old]
        return other

    def has_frames(self, ids: Indices) -> NDArray[np.bool_]:
        """Return which of the FrameId values are in this world and can be posed."""
        at = np.searchsorted(self._sorted_ids, ids).clip(max=len(self._sorted_ids) - 1)
        known: NDArray[np.bool_] = (self._sorted_ids[at] == ids) & (self._order[at] != 0)
        return known

    def frame_rows(self, ids: Indices) -> Indices:
        """Return the rows of FrameId values, all of which are in this world."""
        return self._order[np.searchsorted(self._sorted_ids, ids)]

    def set_poses(self, rows: Indices, R_PFs: Floats, p_PFs: Floats) -> None:
        """Set X_PF of the frames in ``rows`` (n,); a pose that did not change is not a move."""
        changed = np.logical_or(
            (self.R_PFs[rows] != R_PFs).any(axis=(1, 2)), (self.p_PFs[rows] != p_PFs).any(axis=1)
        )
        moved = rows[changed]
        if moved.size:
            self.R_PFs[moved], self.p_PFs[moved] = R_PFs[changed], p_PFs[changed]
            self._moved[moved] = True
            self._stale = True

    def update(self) -> tuple[int, int]:
        """Bring world poses and bounds up to date; return how many frames, geometries moved."""
        if not self._stale:
            return 0, 0
        table = self.geometries
        counts = _update(
            self.frames.parents,
            self._moved,
            (self.R_PFs, self.p_PFs, self.R_WFs, self.p_WFs),
            (table.frames, table.R_FGs, table.p_FGs, table.types, table.starts, table.pool),
            (self.R_WGs, self.p_WGs, self.half_extents),
        )
        self._moved[:] = False
        self._stale = False
        return counts  # type: ignore[no-any-return]


@compiled
def _compose(R_AB, p_AB, R_BC, p_BC, R_AC, p_AC):  # type: ignore[no-untyped-def]
    """Write X_AB X_BC to R_AC, p_AC."""
    for i in range(3):
        p_AC[i] = p_AB[i] + R_AB[i, 0] * p_BC[0] + R_AB[i, 1] * p_BC[1] + R_AB[i, 2] * p_BC[2]
        for j in range(3):
            R_AC[i, j] = (
                R_AB[i, 0] * R_BC[0, j] + R_AB[i, 1] * R_BC[1, j] + R_AB[i, 2] * R_BC[2, j]
            )


@compiled
def _update(parents, moved, frame_poses, table, posed):  # type: ignore[no-untyped-def]
    """Pose the moved frames, what hangs on them, and the geometry on either."""
    R_PFs, p_PFs, R_WFs, p_WFs = frame_poses
    frames, R_FGs, p_FGs, types, starts, pool = table
    R_WGs, p_WGs, half_extents = posed
    moved_frames = 0
    for f in range(1, parents.size):
        parent = parents[f]
        # Row 0, the world, is marked as moved only in a new scene, where everything is new.
        moved[f] = moved[f] or moved[parent]
        if moved[f]:
            moved_frames += 1
            _compose(R_WFs[parent], p_WFs[parent], R_PFs[f], p_PFs[f], R_WFs[f], p_WFs[f])
    moved_geometries = 0
    for g in range(frames.size):
        f = frames[g]
        if moved[f]:
            moved_geometries += 1
            _compose(R_WFs[f], p_WFs[f], R_FGs[g], p_FGs[g], R_WGs[g], p_WGs[g])
            shape = pool[starts[g] : starts[g + 1]]
            box_half_extents(types[g], shape, R_WGs[g], half_extents[g])
    return moved_frames, moved_geometries
