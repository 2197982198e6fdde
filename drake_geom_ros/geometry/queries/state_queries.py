"""Queries about many states of a scene: what is asked, the scene as arrays, and who answers."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from functools import partial

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._contact_surfaces.arrays import Bodies
from drake_geom_ros.geometry._contact_surfaces.packing import packed, packed_half_space
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.kernels.calling.points import (
    POINT_DISTANCE,
    POINT_ERROR_BOUND,
)
from drake_geom_ros.geometry._proximity.near.neighbour_list import NeighbourList
from drake_geom_ros.geometry._proximity.pairs.answer_rows import OVERLAPS, PairBatch, PointBatch
from drake_geom_ros.geometry._proximity.states.state_loops import StateLoops
from drake_geom_ros.geometry._proximity.tolerances import GAPS_OF_LEVELS
from drake_geom_ros.geometry._proximity.world.world import (
    FrameTable,
    GeometryTable,
    PointShapes,
    World,
)
from drake_geom_ros.geometry.errors import GeometryError, PoseError
from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector, arrays_of
from drake_geom_ros.geometry.model.scene_content import SceneContent, proximity_keys_on
from drake_geom_ros.geometry.queries.contact_queries import Contacts
from drake_geom_ros.geometry.queries.context import SceneGraphContext, state_of
from drake_geom_ros.geometry.queries.padding import (
    Paddings,
    lower_ends,
    padded_point_rows,
    padded_rows,
)
from drake_geom_ros.geometry.queries.point_shapes import know_point_shapes
from drake_geom_ros.geometry.queries.query_results import (
    PenetrationResults,
    PointDistanceResults,
    SignedDistanceResults,
)
from drake_geom_ros.geometry.queries.state_contacts import StateContacts
from drake_geom_ros.math.tolerances import WELDED_STAYS

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
# Found pairs or points of a block of states: how many each state has (N,), and all of them.
Found = tuple[Indices, SignedDistanceResults | PointDistanceResults]


@dataclass(frozen=True, eq=False)
class PackedScene:
    """The proximity geometry of a context as arrays, which may go to another process.

    Frames and geometries are known by their place; ids, which no other process shares, are left
    out. So two scenes of the same content have the same ``digest``, whoever made them.
    """

    parents: Indices  # (nf,) of the frames; the first is the world
    R_PFs: Floats  # (nf, 3, 3) poses of the frames that no state moves
    p_PFs: Floats  # (nf, 3) [m]
    frames: Indices  # (n,) of the geometries
    R_FGs: Floats  # (n, 3, 3)
    p_FGs: Floats  # (n, 3) [m]
    roundings: Floats  # (n, 2) of X_FG
    types: Indices  # (n,)
    starts: Indices  # (n + 1,) of the shapes' parameters
    pool: Floats
    # What they are to points; of those who ask about none the same.
    point_types: Indices
    point_starts: Indices
    point_pool: Floats
    pairs: Indices  # (k, 2) that no filter leaves out
    moved: Indices  # the frames whose poses make a state
    paddings: Floats  # (n,) [m] of the geometries, and of which points take a mesh's surface
    meshes: NDArray[np.bool_]  # (n,)
    # What they are to contact surfaces; of those who ask about none no body.
    body_of: Indices  # (n,) the row of each one's body; -1: it has none
    bodies: Bodies

    @classmethod
    def of(
        cls,
        context: SceneGraphContext,
        frame_ids: Indices,
        still: Mapping[int, Floats] | None = None,
        *,
        about_points: bool = True,
        about_contacts: bool = False,
    ) -> tuple[PackedScene, Indices]:
        """Return a context's scene of now, and its geometries' id values (n,) by their place.

        ``frame_ids`` are values of the frames that states pose, ``still`` the poses X_PF (7,) of
        those among them that have the same in each state: what is welded to the world stays so
        there, and nowhere else. Only who asks ``about_points`` has to pack what meshes are to
        these, and who asks ``about_contacts`` their bodies. Raises PoseError for one that is
        not there or is there twice, and for other frames that never had a pose.
        """
        state = state_of(context)
        world = state.up_to_date_world()
        if about_points:
            know_point_shapes(world, state.model)
        world = world.copy()
        named = world.named(frame_ids)
        if named is None or len(np.unique(frame_ids)) < len(frame_ids):
            known = world.has_frames(frame_ids)
            bad = frame_ids[~known].tolist() or sorted(frame_ids.tolist())
            problem = 'are not in this scene' if not known.all() else 'are not all different'
            raise PoseError(f'States were refused: these frames {problem}: {state.describe(bad)}.')
        rows = named.rows
        world.set_poses(rows, world.R_PFs[rows], world.p_PFs[rows])
        if waiting := world.unposed_frames().tolist():
            raise PoseError(
                'States were refused: these frames, which they do not name, never had a pose: '
                f'{state.describe(waiting)}.'
            )
        world.update()
        near = NeighbourList(world)
        near.bring_up_to_date(world, _unwelded(state, frame_ids, still or {}), math.inf)
        table = world.geometries
        none = np.zeros(len(table.ids))
        body_of, bodies = np.full(len(table.ids), -1), packed([packed_half_space(0.0)])
        if about_contacts:
            _, _, body_of, bodies = state.contact_bodies()
        paddings = state.paddings() or Paddings(none, none.astype(bool))
        # What no state keeps is no part of the content.
        R_PFs, p_PFs = world.R_PFs.copy(), world.p_PFs.copy()
        R_PFs[rows], p_PFs[rows] = np.eye(3), 0.0
        scene = cls(
            parents=world.frames.parents,
            R_PFs=R_PFs,
            p_PFs=p_PFs,
            frames=table.frames,
            R_FGs=table.R_FGs,
            p_FGs=table.p_FGs,
            roundings=table.roundings,
            types=table.types,
            starts=table.starts,
            pool=table.pool,
            point_types=world.point_shapes.types,
            point_starts=world.point_shapes.starts,
            point_pool=world.point_shapes.pool,
            pairs=near.pairs,
            moved=rows,
            paddings=paddings.radii,
            meshes=paddings.meshes,
            body_of=body_of,
            bodies=bodies,
        )
        return scene, table.ids

    @property
    def digest(self) -> str:
        """A name for the content: the SHA-256 of all arrays."""
        found = hashlib.sha256()
        for field in fields(self):
            value = getattr(self, field.name)
            for array in value if isinstance(value, Bodies) else (value,):
                found.update(f'{field.name} {array.dtype.str} {array.shape}\n'.encode())
                found.update(np.ascontiguousarray(array).tobytes())
        return found.hexdigest()

    def has_moving_pairs(self) -> bool:
        """Return whether any pair has a geometry that hangs on a frame which states pose."""
        moving = np.isin(np.arange(len(self.parents)), self.moved)
        for frame, parent in enumerate(self.parents.tolist()):
            moving[frame] |= moving[parent]
        return bool(moving[self.frames[self.pairs]].any())

    def world(self) -> World:
        """Return a world of its own, all frames with a pose."""
        count = len(self.parents)
        world = World(
            FrameTable(np.arange(count), self.parents.copy()),
            GeometryTable(
                ids=np.arange(len(self.types)),
                frames=self.frames.copy(),
                R_FGs=self.R_FGs.copy(),
                p_FGs=self.p_FGs.copy(),
                roundings=self.roundings.copy(),
                types=self.types.copy(),
                starts=self.starts.copy(),
                pool=self.pool.copy(),
            ),
        )
        types, starts = self.point_types.copy(), self.point_starts.copy()
        kinds = frozenset(types.tolist())
        world.point_shapes = PointShapes(types, starts, self.point_pool.copy(), kinds)
        rows = np.arange(1, count)
        world.set_poses(rows, self.R_PFs[1:].copy(), self.p_PFs[1:].copy())
        return world


def default_accuracy(context: SceneGraphContext) -> str:
    """Return the accuracy of queries of a context that name none."""
    return state_of(context).accuracy


class StateQueries:
    """Answers about states of a packed scene, without the GIL; each thread takes one of its own.

    A state is the pose X_PF, x y z [m] qx qy qz qw, of each frame that the scene has as moved.
    What is found names geometries by their place in the scene. Every answer is, to the bit, that
    of a QueryObject of a context that was never asked before. ``stop`` (1,) set to another number
    than 0, by another thread, ends a call early: it raises InterruptedError then.
    """

    def __init__(self, scene: PackedScene) -> None:
        self._world = scene.world()
        self._loops = StateLoops(self._world, scene.pairs.copy(), scene.moved.copy())
        self._paddings = Paddings(scene.paddings, scene.meshes) if scene.paddings.any() else None
        self._contacts = None
        if (scene.body_of >= 0).any():
            rows = scene.moved.copy()
            self._contacts = StateContacts(scene.world(), rows, scene.body_of, scene.bodies)

    def has_collisions(
        self, poses: Floats, accuracy: str, stop: Indices, margin: float | None = None
    ) -> NDArray[np.bool_]:
        """Return HasCollisions of each state (N, n, 7); with a margin [m] whether a pair is in it.

        That is so unless every pair is certified to be farther apart than the margin.
        """
        if self._paddings is not None:
            counts, rows = self._padded(poses, accuracy, margin or 0.0, stop)
            near = rows[:, OVERLAPS] > 0.0
            if margin is not None:
                near = lower_ends(rows) <= margin
            return _any_of_each(counts, near)
        if margin is None:
            done, found = self._loops.overlaps(poses, GAPS_OF_LEVELS[accuracy], stop)
        else:
            done, found = self._loops.near(poses, GAPS_OF_LEVELS[accuracy], margin, stop)
        _check_done(done, poses, stop)
        return found

    def nearest(
        self, poses: Floats, accuracy: str, max_distance: float, most: int, stop: Indices
    ) -> Found:
        """Return the pairs of the least lower bounds of each state (N, n, 7), at most so many.

        In their order, a lower bound being distance minus error bound. Left out is what has a
        higher one than the last of so many, or one above ``max_distance`` [m].
        """
        if self._paddings is not None:
            return self._padded_nearest(poses, accuracy, max_distance, most, stop)
        done, counts, batch = self._loops.nearest(
            poses, GAPS_OF_LEVELS[accuracy], max_distance, most, stop
        )
        _check_done(done, poses, stop)
        return counts, SignedDistanceResults(batch)

    def within(self, poses: Floats, accuracy: str, max_distance: float, stop: Indices) -> Found:
        """Return ComputeSignedDistancePairwiseClosestPoints of each state (N, n, 7)."""
        if self._paddings is not None:
            return self._padded_within(poses, accuracy, max_distance, stop)
        done, counts, batch = self._loops.within(
            poses, GAPS_OF_LEVELS[accuracy], max_distance, stop
        )
        _check_done(done, poses, stop)
        return counts, SignedDistanceResults(batch)

    def points(
        self,
        poses: Floats,
        p_WQs: Floats,
        threshold: float,
        stop: Indices,
        *,
        shared: bool = False,
    ) -> Found:
        """Return ComputeSignedDistanceToPoint of points (m, 3) in each state (N, n, 7).

        The points of a single state may be ``shared`` out to all threads.
        """
        paddings = self._paddings
        if paddings is not None and (paddings.meshes & (paddings.radii > 0)).any():
            raise PoseError(
                'States were refused: points near padded meshes are asked of a QueryObject, which '
                'knows where the mesh is'
            )
        reach = threshold + (0.0 if paddings is None else paddings.of_pair)
        done, counts, batch = self._loops.points(poses, p_WQs, reach, stop, shared=shared)
        _check_done(done, poses, stop)
        if self._paddings is None:
            return counts, PointDistanceResults(batch)
        rows, _ = padded_point_rows(batch.rows, batch.ids, self._paddings)
        keep = rows[:, POINT_DISTANCE] - rows[:, POINT_ERROR_BOUND] <= threshold
        batch = PointBatch(batch.ids[keep], batch.points[keep], rows[keep])
        return _count_of_each(counts, keep), PointDistanceResults(batch)

    def contacts(self, poses: Floats, accuracy: str, stop: Indices) -> Iterator[Contacts]:
        """Yield what QueryObject.contacts tells of each state (N, n, 7), overlaps at a level.

        Raises GeometryError where no geometry has hydroelastic properties.
        """
        if self._contacts is None:
            raise GeometryError(
                'Contacts of states were asked for, and no geometry has hydroelastic properties: '
                'see AddRigidHydroelasticProperties and AddCompliantHydroelasticProperties.'
            )
        reach = 0.0 if self._paddings is None else self._paddings.of_pair
        done, counts, (ids, _) = self._loops.within(poses, GAPS_OF_LEVELS['bound'], reach, stop)
        _check_done(done, poses, stop)
        for number, last in enumerate(np.cumsum(counts).tolist()):
            _check_done(number if stop[0] else len(poses), poses, stop)
            state = poses[number : number + 1]
            overlaps = partial(self._penetrations, state, accuracy, stop)
            pairs = ids[last - int(counts[number]) : last]
            yield self._contacts.of(state[0], pairs, overlaps)

    def _penetrations(self, state: Floats, accuracy: str, stop: Indices) -> PenetrationResults:
        """Return ComputePointPairPenetration of a state (1, n, 7)."""
        _, found = self.within(state, accuracy, 0.0, stop)
        assert isinstance(found, SignedDistanceResults)
        return found.penetrations()

    def _padded(
        self, poses: Floats, accuracy: str, reach: float, stop: Indices
    ) -> tuple[Indices, Floats]:
        """Return how many pairs each state has near, and all rows, of the padded bodies."""
        counts, _, rows = self._padded_rows(poses, accuracy, reach, stop)
        return counts, rows

    def _padded_rows(
        self, poses: Floats, accuracy: str, reach: float, stop: Indices
    ) -> tuple[Indices, Indices, Floats]:
        assert self._paddings is not None
        far = reach + self._paddings.of_pair
        done, counts, (ids, rows) = self._loops.within(poses, GAPS_OF_LEVELS[accuracy], far, stop)
        _check_done(done, poses, stop)
        return counts, ids, padded_rows(rows, ids, self._paddings, self._world)

    def _padded_within(
        self, poses: Floats, accuracy: str, max_distance: float, stop: Indices
    ) -> Found:
        counts, ids, rows = self._padded_rows(poses, accuracy, max_distance, stop)
        keep = lower_ends(rows) <= max_distance
        return _count_of_each(counts, keep), SignedDistanceResults(
            PairBatch(ids[keep], rows[keep])
        )

    def _padded_nearest(
        self, poses: Floats, accuracy: str, max_distance: float, most: int, stop: Indices
    ) -> Found:
        counts, ids, rows = self._padded_rows(poses, accuracy, max_distance, stop)
        lower = lower_ends(rows)
        state = np.repeat(np.arange(len(counts)), counts)
        order = np.lexsort((lower, state))
        ranks = np.arange(len(order)) - np.repeat(np.cumsum(counts) - counts, counts)
        order = order[(ranks < most) & (lower[order] <= max_distance)]
        kept = np.bincount(state[order], minlength=len(counts))
        return kept, SignedDistanceResults(PairBatch(ids[order], rows[order]))


def _count_of_each(counts: Indices, keep: NDArray[np.bool_]) -> Indices:
    """Return how many of the rows of each state are kept."""
    state = np.repeat(np.arange(len(counts)), counts)
    return np.bincount(state[keep], minlength=len(counts))


def _any_of_each(counts: Indices, keep: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which states have a row that is kept."""
    found: NDArray[np.bool_] = _count_of_each(counts, keep) > 0
    return found


def _check_done(done: int, poses: Floats, stop: Indices) -> None:
    """Raise InterruptedError where states were left out, StateError where one has no pose."""
    if done == len(poses):
        return
    if stop[0]:
        raise InterruptedError(f'stopped after {done} of {len(poses)} states')
    raise StateError(
        'a pose is x y z [m] and a unit quaternion qx qy qz qw, all finite; '
        f'there are {poses[done].tolist()}',
        done,
    )


class StateError(PoseError):
    """A state that is none; ``number`` is which one."""

    def __init__(self, reason: str, number: int) -> None:
        super().__init__(reason)
        self.number = number


def _unwelded(
    content: SceneContent, frame_ids: Indices, still: Mapping[int, Floats]
) -> FilterState:
    """Return the filters where no frame that states move from its place is welded to the world."""
    filters = content.filters
    moved = [
        frame
        for frame in filters.welded.keys() & set(frame_ids.tolist())
        if not _stays_welded(filters.welded[frame], still.get(frame))
    ]
    if moved:
        filters = filters.copy()
        for frame in moved:
            filters.unweld(frame, proximity_keys_on(content.model, FrameId(frame)))
    return filters


def _stays_welded(first: Floats | None, pose: Floats | None) -> bool:
    """Tell whether a pose (7,) of all states is the first one that a welded frame had, if any."""
    if pose is None:
        return False
    _, (X_WF,) = arrays_of(FramePoseVector.FromArrays(np.ones(1, dtype=np.int64), pose[None]))
    return first is None or bool(np.abs(X_WF - first).max() <= WELDED_STAYS)
