"""The world of a scene: frame poses, geometry poses, packed shapes and their bounds."""

from __future__ import annotations

from typing import NamedTuple
from weakref import ReferenceType, ref

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.shapes.bounds import balls_inside, shape_radii
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import COUNT
from drake_geom_ros.geometry._proximity.kinds import (
    HALF_SPACE,
    OCCUPIED_CELLS,
    POINT_CLOUD,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.runtime.handles import handle_of
from drake_geom_ros.geometry._proximity.runtime.threads import share
from drake_geom_ros.geometry._proximity.world.arrays import WorldArrays
from drake_geom_ros.geometry._proximity.world.columns import Columns
from drake_geom_ros.geometry._proximity.world.kept_poses import KeptPoses, PosedWorld
from drake_geom_ros.geometry._proximity.world.pose_rows import POSE_WIDTH, packed_poses
from drake_geom_ros.geometry._proximity.world.pose_update import (
    LEVER,
    PACE,
    set_poses,
    update,
    update_frames,
    update_geometries,
)
from drake_geom_ros.geometry._proximity.world.row_change import RowChange

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
    roundings: Floats  # (n, 2) TURN and SHIFT of X_FG, see ``pose_rounding``
    types: Indices  # (n,) shape type numbers
    starts: Indices  # (n + 1,) shape k's parameters are pool[starts[k] : starts[k + 1]]
    pool: Floats


class PointShapes(NamedTuple):
    """Shapes of the geometries for points: here a mesh may be its surface instead of its hull."""

    types: Indices  # (n,) shape type numbers
    starts: Indices  # (n + 1,)
    pool: Floats
    kinds: frozenset[int]  # the distinct types

    @classmethod
    def of(cls, types: Indices, starts: Indices, pool: Floats) -> PointShapes:
        """Return packed shapes with their distinct types."""
        return cls(types, starts, pool, frozenset(np.bincount(types).nonzero()[0].tolist()))


class Named:
    """Frames of a world that are posed together, looked up once."""

    __slots__ = ('ids', 'rows')

    def __init__(self, ids: Indices, rows: Indices) -> None:
        """Take FrameId values (n,), which must not change, and rows (n,) of the FrameTable."""
        self.ids, self.rows = ids, rows

    def is_of(self, ids: Indices) -> bool:
        """Return whether these ids, which must not change, are its own; usually the same array."""
        if ids is not self.ids:
            if not np.array_equal(ids, self.ids):
                return False
            self.ids = ids  # probably the array of the next call
        return True


_NOBODY = Named(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
NO_POSES = np.zeros((0, POSE_WIDTH))
_OF_FRAMES = (
    '_R_PFs',
    '_p_PFs',
    'R_WFs',
    'p_WFs',
    '_frame_roundings',
    '_moved',
    '_named',
    '_posed',
)
_OF_GEOMETRIES = ('stamps', 'travels', 'R_WGs', 'p_WGs', 'roundings', 'half_extents')
# Columns that do not depend on poses, in the order of ``_derived_from``.
_DERIVED = ('outer_radii', 'inner_radii', 'ball_centres', 'ball_radii')
_MOST_NEWCOMERS = 64  # anchored geometries that neighbour lists treat as moving ones


class World:
    """The poses of a scene's frames and the posed, packed proximity geometry.

    ``pose`` only stores poses. ``update``, or the compiled call of a query, brings the descendants
    of moved frames up to date and leaves the rest alone. A frame that never had a pose *waits* for
    it, and so do its descendants: their places are unknown, so queries omit them. One that is
    unposed waits again.
    """

    def __init__(self, frames: FrameTable, geometries: GeometryTable) -> None:
        """Make the world of frames that all wait for their first pose."""
        count = len(frames.ids)
        # Attributes that each cycle reads come first, so they are together in memory.
        self.is_stale = True  # world poses and bounds have to be brought up to date
        self.revision = 0  # of the world poses: grows with each update
        # The frames posed last, and their poses (n, POSE_WIDTH) that are not applied yet.
        self.pending_frames, self.pending_poses = _NOBODY, NO_POSES
        self.is_whole = False  # no frame waits for a first pose
        self.is_spent = False  # see ``changed``
        # Poses of the last update, if a result refers to them.
        self._kept_poses: ReferenceType[KeptPoses] | None = None
        self.frames = frames
        self.geometries = geometries
        self._columns = Columns()
        self._R_PFs = np.tile(np.eye(3), (count, 1, 1))
        self._p_PFs = np.zeros((count, 3))
        self.R_WFs = self._R_PFs.copy()
        self.p_WFs = self._p_PFs.copy()
        # Rounding of X_WF: TURN and SHIFT, see ``pose_rounding``.
        self._frame_roundings = np.zeros((count, 2))
        self._sort_ids()
        self._moved = np.ones(count, dtype=np.bool_)
        self._named = np.zeros(count, dtype=np.int64)
        self._posed = np.zeros(count, dtype=np.bool_)
        # In no query: on frames that wait for a first pose, or maps without cells.
        self.waiting = np.ones(len(geometries.ids), dtype=np.bool_)
        self._placings = np.zeros(1, dtype=np.int64)
        self.placed = self._posed.copy()  # (nf,) the frame and all its ancestors have a pose
        self._allocate_geometries()
        self._place(np.zeros(1, dtype=np.int64))

    def _allocate_geometries(self) -> None:
        """Allocate the posed geometry, and compute what does not depend on poses."""
        table = self.geometries
        n = len(table.ids)
        self.stamps = np.zeros(n, dtype=np.int64)  # revision in which a geometry last moved
        # Upper bound of the path length of any point of a geometry since the first update [m].
        self.travels = np.zeros(n)
        self.R_WGs = np.zeros((n, 3, 3))
        self.p_WGs = np.zeros((n, 3))
        # Rounding of X_WG: RADIUS and TILT, see ``pose_rounding``.
        self.roundings = np.zeros((n, 2))
        # Half extents of the box around Go, in World axes, with the rounding of the pose [m].
        self.half_extents = np.zeros((n, 3))
        # The same shapes for points, until the first point query sets others.
        self.point_shapes = PointShapes.of(table.types, table.starts, table.pool)
        self.has_point_shapes = False
        self._is_empty = _empty_maps(table)
        self._classify(np.zeros(0, dtype=np.int64))
        *derived, self._body_data = _derived_from(table)
        (self.outer_radii, self.inner_radii, self.ball_centres, self.ball_radii) = derived
        self._make_handle()

    def _classify(self, newcomers: Indices) -> None:
        """Find the anchored geometries, and the movable ones; ``newcomers`` count as such."""
        table = self.geometries
        self.anchored = table.frames == 0
        # Every query reads this flag, and examines pairs of half spaces only if it is set: filters
        # exclude pairs of two anchored ones.
        planes = table.types == HALF_SPACE
        has_moving = bool((planes & ~self.anchored).any())
        self.has_plane_pairs = has_moving and int(np.count_nonzero(planes)) > 1
        # Anchored geometries that came lately: neighbour lists have not sorted them in, so they
        # look for them as for moving ones.
        self.newcomers = newcomers if len(newcomers) <= _MOST_NEWCOMERS else newcomers[:0]
        is_movable = ~self.anchored
        is_movable[self.newcomers] = True
        self.movable = np.flatnonzero(is_movable)

    def _sort_ids(self) -> None:
        self._order = np.argsort(self.frames.ids)
        self._sorted_ids = self.frames.ids[self._order]

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__.update(state)
        self._make_handle()  # the arrays of a copy are elsewhere

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, '_kept_poses': None}  # results refer to this world, not to a copy

    def _make_handle(self) -> None:
        """Make the handle for compiled code, once, because it costs a microsecond."""
        table = self.geometries
        self._kept_poses = None
        self._posed_now = PosedWorld(
            ids=table.ids,
            types=table.types,
            starts=table.starts,
            pool=table.pool,
            frames=table.frames,
            R_WGs=self.R_WGs,
            frame_ids=self.frames.ids,
            p_WFs=self.p_WFs,
        )
        self.handle = handle_of(self._arrays())

    def _arrays(self) -> WorldArrays:
        table = self.geometries
        return WorldArrays(
            placings=self._placings,
            named=self._named,
            moved=self._moved,
            parents=self.frames.parents,
            R_PFs=self._R_PFs,
            p_PFs=self._p_PFs,
            R_WFs=self.R_WFs,
            p_WFs=self.p_WFs,
            frame_roundings=self._frame_roundings,
            movable=self.movable,
            ids=table.ids,
            frames=table.frames,
            waiting=self.waiting,
            R_FGs=table.R_FGs,
            p_FGs=table.p_FGs,
            body_data=self._body_data,
            types=table.types,
            starts=table.starts,
            pool=table.pool,
            R_WGs=self.R_WGs,
            p_WGs=self.p_WGs,
            roundings=self.roundings,
            half_extents=self.half_extents,
            outer=self.outer_radii,
            inner=self.inner_radii,
            ball_centres=self.ball_centres,
            ball_radii=self.ball_radii,
            stamps=self.stamps,
            travels=self.travels,
        )

    @property
    def placings(self) -> int:
        """Number of times that frames got their first pose."""
        return int(self._placings[0])

    @property
    def R_PFs(self) -> Floats:
        """Orientations of the frames in their parents (nf, 3, 3)."""
        self._apply_pending()
        return self._R_PFs

    @property
    def p_PFs(self) -> Floats:
        """Positions of the frames in their parents (nf, 3) [m]."""
        self._apply_pending()
        return self._p_PFs

    @property
    def paces(self) -> Floats:
        """Recent motion of any point of each geometry in one update (n,) [m], fading."""
        return self._body_data[:, PACE]

    @property
    def geometry_count(self) -> int:
        """The number of geometries with the proximity role."""
        return len(self.geometries.ids)

    def copy(self) -> World:
        """Return a world with poses of its own; the tables, which never change, are shared."""
        self._apply_pending()
        other = World.__new__(World)
        other.__dict__.update(self.__dict__)
        other._columns = self._columns.copy()
        for name, value in self.__dict__.items():
            if isinstance(value, np.ndarray):
                setattr(other, name, value.copy())
        other._make_handle()
        return other

    def rebuilt(self, frames: FrameTable, geometries: GeometryTable) -> World:
        """Return a world of new tables in which every frame of this one has its pose."""
        other = World(frames, geometries)
        rows = {int(frame): row for row, frame in enumerate(self.frames.ids)}
        pairs = [(k, rows[int(f)]) for k, f in enumerate(frames.ids) if int(f) in rows]
        new, old = (np.array(side) for side in zip(*pairs, strict=True))
        other._R_PFs[new], other._p_PFs[new] = self.R_PFs[old], self.p_PFs[old]
        other._place(new[self._posed[old]])
        return other

    def changed(
        self, frames: FrameTable, new: GeometryTable, change: RowChange, new_points: PointShapes
    ) -> World:
        """Return a world of changed geometries, in which the others keep all that they have here.

        ``frames`` begin with those of this world. ``new`` (k,) are the changed geometries and
        those that were added, with the rows of ``frames``; ``change`` says where they go.
        ``new_points`` are the shapes of these for points, if this world has such shapes.

        This world is *spent* then, since what moves with poses is changed in place: it may only be
        ``rebuilt``.
        """
        self._apply_pending()
        derived, empty = _derived_from(new), _empty_maps(new)
        self._keep_results()
        other = World.__new__(World)
        other.__dict__.update(self.__dict__)
        self.is_spent = True
        other._placings = self._placings.copy()
        other._columns = columns = self._columns.copy()
        other._add_frames(frames)
        before, is_empty = self.geometries, self._is_empty
        of_table = {
            name: columns.changed(name, getattr(before, name), getattr(new, name), change)
            for name in ('ids', 'frames', 'R_FGs', 'p_FGs', 'roundings')
        }
        shapes = columns.changed_shapes('pair', before[5:], new[5:], change)
        other.geometries = GeometryTable(
            **of_table, types=shapes[0], starts=shapes[1], pool=shapes[2]
        )
        for name, column in zip(_DERIVED, derived, strict=False):
            setattr(other, name, columns.changed(name, getattr(self, name), column, change))
        other._body_data = change.in_place(self._body_data, derived[-1])
        for name in _OF_GEOMETRIES:
            setattr(other, name, change.in_place(getattr(self, name), 0))
        if self.has_point_shapes:
            shapes = columns.changed_shapes('point', self.point_shapes[:3], new_points[:3], change)
        other.point_shapes = PointShapes.of(*shapes)
        other._is_empty = change.merged(is_empty, empty)
        other.waiting = other.unplaced() | other._is_empty
        if empty.any() or is_empty.any():
            other._placings += 1  # lists have no place for what was empty
        stayed, came = change.places_of(self.newcomers), change.new[new.frames == 0]
        other._classify(np.sort(np.concatenate((stayed, came))))
        other._make_handle()
        other._pose_new(change.new)
        return other

    def _add_frames(self, frames: FrameTable) -> None:
        """Copy the arrays of frames, with more frames behind the others that have no pose yet."""
        former, self.frames = len(self.frames.ids), frames
        more = len(frames.ids) - former
        added = RowChange.appended(former, more)
        for name in _OF_FRAMES:
            column = getattr(self, name)
            setattr(self, name, added.merged(column, 0) if more else column.copy())
        if more:
            self._R_PFs[former:] = self.R_WFs[former:] = np.eye(3)
            self._moved[former:] = True
            self.placed = added.merged(self.placed, False)
            self._sort_ids()
            self.is_whole, self.is_stale = False, True

    def _pose_new(self, rows: Indices) -> None:
        """Pose geometries as their frames are, also those that wait for a first pose.

        A first pose that equals that of a waiting frame, at the origin, moves nothing.
        """
        if self._moved[0]:
            return  # the first update poses all
        self.revision += 1
        moved = self._moved.copy()
        self._moved[:] = True
        for row in rows.tolist():
            update_geometries(self.handle, self.revision, row, row + 1)
        self._moved[:] = moved

    def has_other_shapes_only(self, other: World) -> bool:
        """Return whether another world differs by shapes of the same types at most, and poses.

        Ids may differ as long as their order is the same. A map without cells has no pairs, so one
        that has some now is more than another shape.
        """
        table, its_table = self.geometries, other.geometries
        if not np.array_equal(self._is_empty, other._is_empty):
            return False
        return np.array_equal(self.frames.parents, other.frames.parents) and all(
            np.array_equal(getattr(table, name), getattr(its_table, name))
            for name in ('frames', 'R_FGs', 'p_FGs', 'roundings', 'types')
        )

    def take_shapes(self, other: World) -> None:
        """Take the shapes of a world of which ``has_other_shapes_only`` is true."""
        self._apply_pending()
        shapes = other.geometries
        self.geometries = self.geometries._replace(starts=shapes.starts, pool=shapes.pool)
        self.point_shapes, self.has_point_shapes = other.point_shapes, other.has_point_shapes
        for name in _DERIVED:
            setattr(self, name, getattr(other, name).copy())
        self._body_data[:, LEVER] = other._body_data[:, LEVER]
        self._moved[:], self.is_stale = True, True  # all boxes are computed anew
        self._make_handle()

    def pose_as(self, other: World) -> None:
        """Pose the frames that another world has on the same parents as they are posed there.

        Those that wait there, wait here.
        """
        _, here, there = np.intersect1d(
            self.frames.ids, other.frames.ids, assume_unique=True, return_indices=True
        )
        parents = self.frames.ids[self.frames.parents[here]]
        is_same = parents == other.frames.ids[other.frames.parents[there]]
        R_PFs, p_PFs = other.R_PFs[there], other.p_PFs[there]
        moved = ~self._posed[here] | (R_PFs != self.R_PFs[here]).any(axis=(1, 2))
        moved |= (p_PFs != self.p_PFs[here]).any(axis=1)
        chosen = (here > 0) & is_same & moved & other._posed[there]
        if chosen.any():
            self.set_poses(here[chosen], R_PFs[chosen], p_PFs[chosen])
        waiting = (here > 0) & is_same & self._posed[here] & ~other._posed[there]
        if waiting.any():
            self.unpose(here[waiting])

    def has_frames(self, ids: Indices) -> NDArray[np.bool_]:
        """Return which of the FrameId values are in this world and can be posed."""
        at = np.searchsorted(self._sorted_ids, ids).clip(max=len(self._sorted_ids) - 1)
        is_posable: NDArray[np.bool_] = (self._sorted_ids[at] == ids) & (self._order[at] != 0)
        return is_posable

    def frame_rows(self, ids: Indices) -> Indices:
        """Return the rows of FrameId values, all of which are in this world."""
        return self._order[np.searchsorted(self._sorted_ids, ids)]

    def geometry_rows(self, ids: Indices) -> Indices:
        """Return the rows of GeometryId values, all of which are in this world."""
        return np.searchsorted(self.geometries.ids, ids).astype(np.int64)

    def named(self, ids: Indices) -> Named | None:
        """Return the frames of FrameId values (n,), or None if not all of them can be posed."""
        return Named(ids.copy(), self.frame_rows(ids)) if self.has_frames(ids).all() else None

    def _place(self, rows: Indices) -> None:
        """Mark the frames in ``rows`` (n,) as posed, and the descendants that wait no longer."""
        self._posed[rows] = True
        self._note_posed()

    def unpose(self, rows: Indices) -> None:
        """Let the frames in ``rows`` (n,), and what hangs on them, wait for a pose again."""
        self._apply_pending()
        self._posed[rows] = False
        self._note_posed()
        self.is_stale = True  # an answer of before is none of now

    def _note_posed(self) -> None:
        """Bring up to date what follows from which frames are posed."""
        self.is_whole = bool(self._posed.all())
        self.placed = self._posed.copy()
        for row, parent in enumerate(self.frames.parents.tolist()):
            self.placed[row] &= self.placed[parent]
        self.waiting[:] = self.unplaced() | self._is_empty
        self._placings += 1

    def unplaced(self) -> NDArray[np.bool_]:
        """Return which geometries (n,) wait for a first pose."""
        return ~self.placed[self.geometries.frames]

    def unposed_frames(self) -> Indices:
        """Return the FrameId values of the frames that never had a pose, parents first."""
        return self.frames.ids[~self._posed]

    def unposed_on_way(self, row: int) -> list[int]:
        """Return those of ``unposed_frames`` among a frame and its ancestors."""
        unposed = []
        while not self.placed[row]:
            if not self._posed[row]:
                unposed.append(int(self.frames.ids[row]))
            row = int(self.frames.parents[row])
        return unposed

    def set_poses(self, rows: Indices, R_PFs: Floats, p_PFs: Floats) -> None:
        """Set X_PF of the frames in ``rows`` (n,), as ``pose`` does."""
        rows = np.asarray(rows, dtype=np.int64)
        self.pose(Named(self.frames.ids[rows], rows), packed_poses(R_PFs, p_PFs))

    def pose(self, named: Named, X_PFs: Floats) -> None:
        """Store X_PF (n, POSE_WIDTH) of frames for the next update; the array must not change.

        An equal pose is not a move.
        """
        if self.pending_frames is not named:
            self._apply_pending()
            self.pending_frames = named
            self._named[: len(named.rows)] = named.rows
        if not self.is_whole and not self._posed[named.rows].all():
            self._place(named.rows)
        self.pending_poses, self.is_stale = X_PFs, True
        if self._kept_poses is not None:
            self._keep_results()

    def _keep_results(self) -> None:
        """Copy the poses of the last query for the results of it that still exist."""
        if self._kept_poses is not None:
            kept_poses, self._kept_poses = self._kept_poses(), None
            if kept_poses is not None:
                kept_poses.keep()

    def _apply_pending(self) -> None:
        """Write pending poses to ``_R_PFs`` and ``_p_PFs``, and mark their frames as moved."""
        pending_poses, self.pending_poses = self.pending_poses, NO_POSES
        if len(pending_poses):
            set_poses(self.pending_frames.rows, pending_poses, self.handle)

    def update_shared(self) -> tuple[int, int]:
        """Bring world poses and bounds up to date as ``update`` does, by threads."""
        if not self.is_stale:
            return 0, 0
        rows, pending_poses, revision = (
            self.pending_frames.rows,
            self.pending_poses,
            self.revision + 1,
        )

        def set_some(first: int, last: int) -> None:
            set_poses(rows[first:last], pending_poses[first:last], self.handle)

        def pose_some(first: int, last: int) -> int:
            moved: int = update_geometries(self.handle, revision, first, last)
            return moved

        share(len(pending_poses), set_some)
        frames = update_frames(self.handle)
        is_new = bool(self._moved[0])
        geometries = sum(share(self.geometry_count if is_new else len(self.movable), pose_some))
        self._moved[:] = False
        self.revision, self.pending_poses, self.is_stale = revision, NO_POSES, False
        return frames, geometries

    def kept_poses(self) -> KeptPoses:
        """Return the poses of the last update, which later ones do not change."""
        kept_poses = None if self._kept_poses is None else self._kept_poses()
        if kept_poses is None:
            kept_poses = KeptPoses()
            kept_poses.now = self._posed_now
            self._kept_poses = ref(kept_poses)
        return kept_poses

    def update(self) -> tuple[int, int]:
        """Bring world poses and bounds up to date; return how many frames, geometries moved."""
        if not self.is_stale:
            return 0, 0
        self._apply_pending()
        counts = update(self.handle, self.revision + 1)
        self.revision, self.is_stale = self.revision + 1, False
        return counts


def _derived_from(table: GeometryTable) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return what does not depend on poses: radii, balls, and ``body_data`` of geometries.

    They are the largest distance from Go and the largest ball about Go that fits (n,) [m], centres
    in G (n, 3) and radii (n,) [m] of balls inside the shapes, which need not be about Go, and all
    that ``pose_update`` reads, in one array (n, 5), since each array passed to compiled code takes
    time.
    """
    shapes = table.types, table.starts, table.pool
    outer, inner = shape_radii(*shapes)
    centres, radii = balls_inside(*shapes, inner)
    levers = np.where(table.types == SPHERE, 0.0, outer)
    at_origin = (table.R_FGs == np.eye(3)).all(axis=(1, 2)) & ~table.p_FGs.any(axis=1)
    rest = np.zeros(len(table.types))
    body_data = np.column_stack((table.roundings, levers, at_origin, rest))
    return outer, inner, centres, radii, body_data


def _empty_maps(table: GeometryTable) -> NDArray[np.bool_]:
    """Return which geometries (n,) are sensed maps without cells."""
    is_empty = (table.types == OCCUPIED_CELLS) | (table.types == POINT_CLOUD)
    for k in np.flatnonzero(is_empty).tolist():
        shape = table.pool[table.starts[k] : table.starts[k + 1]]
        is_empty[k] = shape[int(shape[-1]) + COUNT] == 0.0
    return is_empty
