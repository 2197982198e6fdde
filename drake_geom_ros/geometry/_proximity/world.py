"""Where everything is: frame poses, geometry poses, packed shapes and their bounds."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.bounds import (
    box_half_extents,
    shape_radii,
)
from drake_geom_ros.geometry._proximity.kernels.supports import SPHERE
from drake_geom_ros.geometry._proximity.kernels.views import part, row
from drake_geom_ros.geometry._proximity.tolerances import EPS

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

FADING = 15 / 16  # of the pace in an update: a body that stops is still taken for slow a while


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
        self._last_named = b'', np.zeros(0, dtype=np.int64)
        self._moved = np.ones(count, dtype=np.bool_)
        self._stale = True
        self._allocate_geometries()

    def _allocate_geometries(self) -> None:
        """Make room for the posed geometry and compute what does not depend on poses."""
        table = self.geometries
        n = len(table.ids)
        self.revision = 0  # of the world poses: grows with each update that moves something
        self.stamps = np.zeros(n, dtype=np.int64)  # revision in which a geometry last moved
        # How far any point of a geometry can have come since the first update, along the path
        # [m], never less than the truth; and how far it came lately in one update, fading.
        self.travels = np.zeros(n)
        self.paces = np.zeros(n)
        self.R_WGs = np.zeros((n, 3, 3))
        self.p_WGs = np.zeros((n, 3))
        self.half_extents = np.zeros((n, 3))  # of the box around Go, in World axes [m]
        self.anchored = table.frames == 0
        self.movable = np.flatnonzero(~self.anchored)
        # Largest distance from Go and largest ball about Go that fits [m].
        self.outer_radii, self.inner_radii = shape_radii(table.types, table.starts, table.pool)
        # A ball that turns about its centre goes nowhere.
        self._turn_radii = np.where(table.types == SPHERE, 0.0, self.outer_radii)
        self._gather_arguments()

    def _gather_arguments(self) -> None:
        """Gather what compiled code is given each cycle: to do it then costs a microsecond."""
        table = self.geometries
        self._arguments = (
            *(self._moved, self.frames.parents),
            *(self.R_PFs, self.p_PFs, self.R_WFs, self.p_WFs),
            *(self.movable, table.frames),
            *(table.R_FGs, table.p_FGs, table.types, table.starts, table.pool),
            *(self.R_WGs, self.p_WGs, self.half_extents),
            *(self._turn_radii, self.stamps, self.travels, self.paces),
        )
        # For the narrow phase: shapes, where they are, how large, and how they moved.
        self.scene = (
            *(table.types, table.starts, table.pool, self.R_WGs, self.p_WGs),
            *(self.half_extents, self.outer_radii, self.inner_radii, self.travels, self.stamps),
        )
        # For those who gather results.
        self.posed = (
            *(table.ids, table.types, table.frames),
            *(self.R_WGs, self.p_WGs, self.p_WFs, self.outer_radii),
        )

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
        other._gather_arguments()
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

    def rows_to_pose(self, ids: Indices) -> Indices | None:
        """Return the rows of FrameId values, or None when not all of them can be posed."""
        # Whoever poses frames names the same ones each time.
        text = ids.tobytes()
        if text != self._last_named[0]:
            if not self.has_frames(ids).all():
                return None
            self._last_named = text, self.frame_rows(ids)
        return self._last_named[1]

    def set_poses(self, rows: Indices, R_PFs: Floats, p_PFs: Floats) -> None:
        """Set X_PF of the frames in ``rows`` (n,); a pose that did not change is not a move."""
        if _set_poses(rows, R_PFs, p_PFs, self.R_PFs, self.p_PFs, self._moved):
            self._stale = True

    def update(self) -> tuple[int, int]:
        """Bring world poses and bounds up to date; return how many frames, geometries moved."""
        if not self._stale:
            return 0, 0
        self.revision += 1
        counts = _update(self.revision, *self._arguments)
        self._stale = False
        return counts  # type: ignore[no-any-return]


@compiled
def _set_poses(rows, R_news, p_news, R_PFs, p_PFs, moved):  # type: ignore[no-untyped-def]
    """Copy the poses that differ and mark their frames; return whether one did."""
    any_moved = False
    for k in range(rows.size):
        f = rows[k]
        same = True
        for i in range(3):
            same &= p_news[k, i] == p_PFs[f, i]
            p_PFs[f, i] = p_news[k, i]
            for j in range(3):
                same &= R_news[k, i, j] == R_PFs[f, i, j]
                R_PFs[f, i, j] = R_news[k, i, j]
        if not same:
            moved[f] = True
            any_moved = True
    return any_moved


@inlined
def _compose(R_ABs, p_ABs, a, R_BCs, p_BCs, b, R_ACs, p_ACs, c):  # type: ignore[no-untyped-def]
    """Write X_AB X_BC of rows a and b to row c; return the squares of what turned and moved it.

    They are the squared Frobenius norm [-] and the squared length [m^2] of the differences. (Rows
    by number, for a view of a row costs as much as the product; by unsigned number, for the test
    for negative ones costs half as much.)
    """
    a, b, c = np.uint64(a), np.uint64(b), np.uint64(c)
    turned, moved = 0.0, 0.0
    for i in range(3):
        x, y, z = R_ABs[a, i, 0], R_ABs[a, i, 1], R_ABs[a, i, 2]
        p = p_ABs[a, i] + x * p_BCs[b, 0] + y * p_BCs[b, 1] + z * p_BCs[b, 2]
        moved += (p - p_ACs[c, i]) * (p - p_ACs[c, i])
        p_ACs[c, i] = p
        for j in range(3):
            r = x * R_BCs[b, 0, j] + y * R_BCs[b, 1, j] + z * R_BCs[b, 2, j]
            turned += (r - R_ACs[c, i, j]) * (r - R_ACs[c, i, j])
            R_ACs[c, i, j] = r
    return turned, moved


@inlined
def _way(turned, moved, turn_radius):  # type: ignore[no-untyped-def]
    """Return how far a point of a body can have come by a step of ``_compose`` [m], rounded up.

    A point at x_G moves by (R - R') x + (p - p'), and the spectral norm of the difference of two
    rotations is their Frobenius norm over the square root of two.
    """
    way = math.sqrt(moved)
    if turned > 0.0 and turn_radius > 0.0:
        way += turn_radius * (math.sqrt(0.5 * turned) + 8.0 * EPS)
    return way * (1.0 + 8.0 * EPS)


@compiled
def _update(  # type: ignore[no-untyped-def]
    revision,
    moved,
    parents,
    R_PFs,
    p_PFs,
    R_WFs,
    p_WFs,
    movable,
    on,
    R_FGs,
    p_FGs,
    types,
    starts,
    pool,
    R_WGs,
    p_WGs,
    half_extents,
    turn_radii,
    stamps,
    travels,
    paces,
):
    """Pose the moved frames, what hangs on them, and the geometry on either."""
    moved_frames = 0
    for f in range(1, parents.size):
        parent = parents[f]
        # Row 0, the world, is marked as moved only in a new scene, where everything is new.
        moved[f] = moved[f] or moved[parent]
        if moved[f]:
            moved_frames += 1
            if parent == 0:
                for i in range(3):
                    p_WFs[f, i] = p_PFs[f, i]
                    for j in range(3):
                        R_WFs[f, i, j] = R_PFs[f, i, j]
                continue
            _compose(R_WFs, p_WFs, parent, R_PFs, p_PFs, f, R_WFs, p_WFs, f)
    moved_geometries = 0
    every = moved[0]
    for k in range(on.size if every else movable.size):
        g = k if every else movable[k]
        f = on[g]
        if moved[f]:
            moved_geometries += 1
            squares = _compose(R_WFs, p_WFs, f, R_FGs, p_FGs, g, R_WGs, p_WGs, g)
            if stamps[g] == 0 or turn_radii[g] > 0.0:
                shape = part(pool, starts[g], starts[g + 1])
                box_half_extents(types[g], shape, row(R_WGs, g), row(half_extents, g))
            if stamps[g] > 0:
                way = _way(squares[0], squares[1], turn_radii[g])
                travels[g] = (travels[g] + way) * (1.0 + 2.0 * EPS)
                paces[g] = max(way, FADING * paces[g])
            stamps[g] = revision
    moved[:] = False
    return moved_frames, moved_geometries
