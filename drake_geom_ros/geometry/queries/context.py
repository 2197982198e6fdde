"""A context: a copy of the scene model, with poses, that queries are asked of."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry._proximity.engine.engine import ACCURACY_LEVELS, Engine
from drake_geom_ros.geometry._proximity.engine.prepared import Prepared
from drake_geom_ros.geometry._proximity.engine.waiting import count_waiting_pairs
from drake_geom_ros.geometry._proximity.engine.warm_up import warm_up
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.runtime.compiled import Tell
from drake_geom_ros.geometry._proximity.world.world import (
    Named,
    World,
)
from drake_geom_ros.geometry.errors import ArgumentError, PoseError
from drake_geom_ros.geometry.ids import FrameId, SourceId
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.queries.padding import Paddings, paddings_of
from drake_geom_ros.geometry.queries.point_shapes import know_point_shapes
from drake_geom_ros.geometry.queries.tables import tables_of
from drake_geom_ros.math.tolerances import WELDED_STAYS

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class _Built(NamedTuple):
    """The versions of the model that a world was built from."""

    frames: int
    proximity: int


_MOST_SENDERS = 64  # who poses ever other frames must not fill the memory
_MOST_USUAL = 16  # queries that are usual: distances may come without end


class _WaitingPairs(NamedTuple):
    """How many pairs wait for a pose, and when that was so."""

    moment: object
    pairs: int


class SceneGraphContext:
    """What a SceneGraph answers from: its own model, filters and poses.

    Made by ``SceneGraph.CreateDefaultContext()``. Changes of the SceneGraph's model do not reach
    contexts that exist, and the reverse. While a frame never had a pose queries are refused, or,
    with ``partial``, leave out what hangs on it.
    """

    scalar = 'float'  # of the poses: a query object is of the same

    def __init__(
        self, model: Model, filters: FilterState, accuracy: str, partial: bool = False
    ) -> None:
        self._model = model
        self._partial = partial
        self._filters = filters
        self._accuracy = accuracy
        self._engine = Engine()
        self._built, self._seen = self._versions(), model.versions.any
        # Who poses frames names the same ones each time: all lists of them, by the bytes of their
        # ids, and those of sources by the values of theirs.
        self._named: dict[bytes, Named] = {}
        self._own: dict[int, Named] = {}
        self._usual: dict[Hashable, Prepared] = {}
        self._world = World(*tables_of(model))
        self._snapshot: Model | None = None
        self._padded: tuple[int | None, Paddings | None] = None, None  # by a version of roles
        self._waiting_pairs = _WaitingPairs(None, 0)
        # By renderer: what it shows, and of which version; see RenderEngineExact.
        self._packed_scenes: dict[str, Any] = {}
        if model.first_X_PFs:
            self.UpdateFramePoses(FramePoseVector(model.first_X_PFs))

    def copy(self) -> SceneGraphContext:
        """Return a context that shares nothing that either could change."""
        other = SceneGraphContext.__new__(type(self))
        other._model = self._model.copy()
        other._filters = self._filters.copy()
        other._accuracy = self._accuracy
        other._partial = self._partial
        other._engine = Engine()
        other._built, other._seen = other._versions(), other._model.versions.any
        other._named, other._own, other._usual = {}, {}, {}
        other._world = self._up_to_date_world().copy()
        other._snapshot, other._padded = None, (None, None)
        other._waiting_pairs = _WaitingPairs(None, 0)
        other._packed_scenes = dict(self._packed_scenes)
        return other

    def __getstate__(self) -> dict[str, object]:
        return {**self.__dict__, '_usual': {}}  # the arrays of a copy are elsewhere

    def Clone(self) -> SceneGraphContext:
        """Return ``copy()``, by pydrake's name."""
        return self.copy()

    def what_if(self) -> SceneGraphContext:
        """Return a snapshot that may be posed and queried, in another thread too, at little cost.

        For queries only: the snapshots of one state of the model share a copy of it.
        """
        world = self._up_to_date_world()
        if self._snapshot is None or self._snapshot.versions != self._model.versions:
            self._snapshot = self._model.copy()
        other = SceneGraphContext.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other._model = self._snapshot
        other._filters = self._filters.copy()
        other._engine, other._usual = Engine(), {}
        other._world = world.copy()
        other._named, other._own = dict(self._named), dict(self._own)
        return other

    def narrowed(self, considered: NDArray[np.bool_]) -> SceneGraphContext:
        """Return a context that considers only some pairs: see ``QueryObject.narrowed``."""
        world = self._up_to_date_world()
        other = SceneGraphContext.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other._filters = self._filters.narrowed(world.geometries.ids, considered)
        other._engine, other._usual = Engine(), {}
        return other

    def set_default_accuracy(self, accuracy: str) -> None:
        """Set the accuracy of queries that name none: bound, fast, balanced or exact."""
        self._accuracy = checked_accuracy(accuracy)
        self._usual.clear()

    def set_detailed_effects(self, detailed: bool) -> None:
        """Set whether ``QueryObject.effects()`` gives the seconds of cache and kernels separately.

        That costs a query some microseconds.
        """
        self._engine.detailed = detailed

    def compile_kernels(self, tell: Tell | None = None, part: str = 'all') -> list[str]:
        """Compile what queries of this scene run, or load it from the cache; return the kernels.

        Queries compile what they miss; a node does it before its first cycle, and
        ``python -m drake_geom_ros compile`` for all scenes. ``tell(name, number, last)`` is called
        before each part that the cache does not have. Of a ``part`` 'cycle' or 'kernels', two
        processes may compile one each: what runs around the kernels, or these.
        """
        if part not in ('all', 'cycle', 'kernels'):
            raise ValueError(f"part '{part}' is none of 'all', 'cycle', 'kernels'")
        if part != 'kernels':
            warm_up(tell)
        if part == 'cycle':
            return []
        return self._engine.prepare(self._up_to_date_world(), tell)

    def SetFramePoses(self, source_id: SourceId, poses: FramePoseVector) -> None:
        """Pose all frames of a source, or none.

        Raises PoseError when ``poses`` lacks a frame of the source or holds one that is not
        its own; nothing changes then. Values are checked when ``poses`` is made.
        """
        # Once more what ``_up_to_date_world`` does first: see ``FramePoseVector.FromArrays``.
        is_known = self._seen == self._model.versions.any
        world = self._world if is_known else self._up_to_date_world()
        own = self._own.get(source_id._value) or self._source_frames(source_id)
        given, X_PFs = poses._arrays or poses._as_arrays()
        # Mostly the frames come in the order of their ids.
        if given is own.ids or own.is_of(given):
            if self._filters.welded:
                self._look_after_welds(given, X_PFs)
            world.pose(own, X_PFs)
            return
        if not np.array_equal(given := np.sort(given), own.ids):
            problems = []
            if missing := np.setdiff1d(own.ids, given).tolist():
                problems.append(f'these frames of it have no pose: {self._describe(missing)}')
            if foreign := np.setdiff1d(given, own.ids).tolist():
                problems.append(f'these frames are not its own: {self._describe(foreign)}')
            raise PoseError(
                f"Poses for source '{self._model.source_name(source_id)}' were refused, nothing "
                f"was changed: {'; '.join(problems)}. Each fix needs exactly the source's frames."
            )
        self.UpdateFramePoses(poses)

    def X_WFs(self, ids: ArrayLike) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Return R_WF (k, 3, 3) and p_WF (k, 3) [m] of frames by the values (k,) of their ids.

        For many at once, as a picture needs them. The third array (k,) says which of them, and
        all they hang on, have a pose; what stands for the others means nothing. Raises
        UnknownIdError for what is no frame here.
        """
        world = self._up_to_date_world()
        values = np.asarray(ids, dtype=np.int64)
        for value in values[~world.has_frames(values)].tolist():
            self._model.frame(FrameId(value))  # the world, or an error that names it
        world.update()
        rows = world.frame_rows(values)
        return world.R_WFs[rows], world.p_WFs[rows], world.placed[rows]

    def _source_frames(self, source_id: SourceId) -> Named:
        """Return a source's frames by ascending ids, and note them."""
        values = [frame.get_value() for frame in self._model.frames_of_source(source_id)]
        ids = np.array(sorted(values), dtype=np.int64)
        own = self._own[source_id.get_value()] = self._frames_named(ids.tobytes(), ids)
        return own

    def _frames_named(self, key: bytes, ids: Indices) -> Named:
        """Return frames by the values (n,) of their ids, whose bytes are the key.

        Raises PoseError when one does not exist.
        """
        named = self._named.get(key)
        if named is None:
            world = self._up_to_date_world()
            named = world.named(ids)
            if named is None:
                unknown = ids[~world.has_frames(ids)]
                raise PoseError(
                    'Poses were refused, nothing was changed: these frames are not in this scene: '
                    f'{self._describe(sorted(unknown.tolist()))}.'
                )
            if len(self._named) == _MOST_SENDERS:
                del self._named[next(iter(self._named))]
            self._named[key] = named
        return named

    def UpdateFramePoses(self, poses: FramePoseVector) -> None:
        """Pose the frames that ``poses`` names, of any source; the others keep their poses.

        Raises PoseError when a frame does not exist; nothing changes then.
        """
        world = self._up_to_date_world()
        ids, X_PFs = poses._as_arrays()
        named = self._frames_named(ids.tobytes(), ids)
        if self._filters.welded:
            self._look_after_welds(ids, X_PFs)
        world.pose(named, X_PFs)

    def _look_after_welds(self, ids: Indices, X_PFs: Floats) -> None:
        """Undo the weld of a frame that is posed elsewhere than where its first pose put it."""
        welded = self._filters.welded
        for frame, X_WF in zip(ids.tolist(), X_PFs, strict=True):
            if frame not in welded:
                continue
            first = welded[frame]
            if first is None:
                welded[frame] = X_WF.copy()
            elif np.abs(X_WF - first).max() > WELDED_STAYS:
                on_it = self._model.geometries_on(FrameId(frame))
                keys = [g.id.get_value() for g in on_it if g.proximity is not None]
                self._filters.unweld(frame, keys)

    def _describe(self, values: list[int]) -> str:
        """Name frames for an error message."""
        names = []
        for frame in map(FrameId, values[:5]):
            record = self._model.frames.get(frame)
            names.append(f"'{record.name}' ({frame!r})" if record else repr(frame))
        more = f' and {len(values) - 5} more' if len(values) > 5 else ''
        return ', '.join(names) + more

    def _posed_world(self) -> World:
        """Return the world for a query; raises PoseError if it lacks poses that it must have."""
        world = self._up_to_date_world()
        if not (world.is_whole or self._partial):
            waiting = world.unposed_frames().tolist()
            raise PoseError(
                f'Of {len(world.frames.ids) - 1} frames {len(waiting)} never had a pose: '
                f'{self._describe(waiting)}. Give all frames of a source theirs by '
                'get_source_pose_port(source_id).FixValue(context, poses), some by '
                'UpdateFramePoses(poses) of the context, or what contexts begin with by '
                'SceneGraph.SetFirstPoses(poses).'
            )
        return world

    def _pointed_world(self) -> World:
        """Return the world for a query about points, which knows what shapes are to them."""
        world = self._posed_world()
        know_point_shapes(world, self._model)
        return world

    def _query(
        self, usual: Hashable, accuracy: str | None, cutoff: float, penetrating: bool, mode: int
    ) -> Prepared:
        """Return a query as the engine takes it: see ``Engine.prepared``.

        Those at the default accuracy are kept by what is ``usual`` to be asked. Raises PoseError
        if there are no poses that it must have.
        """
        if accuracy is None:
            known = self._usual.get(usual)
            # Either number only grows.
            scene = self._model.versions.any + self._filters.version
            if known is not None and known.scene == scene and known.handles is known.near.handles:
                return known
        level = self._accuracy if accuracy is None else checked_accuracy(accuracy)
        world = self._posed_world()
        query = self._engine.prepared(world, self._filters, level, cutoff, penetrating, mode)
        if accuracy is None:
            if len(self._usual) == _MOST_USUAL:
                self._usual.clear()
            self._usual[usual] = query
            query.scene = self._model.versions.any + self._filters.version
        return query

    def _placed_frame(self, id: FrameId, *, in_world: bool = True) -> tuple[World, int]:
        """Return the world and the row of a frame in it.

        Raises UnknownIdError for one that is not here, and PoseError where it has no pose, or, to
        be known ``in_world``, what it hangs on has none.
        """
        record = self._model.frame(id)
        world = self._posed_world()
        row = int(world.frame_rows(np.array([id.get_value()]))[0])
        waiting = world.unposed_on_way(row)
        if len(waiting) and (in_world or id.get_value() in waiting):
            raise PoseError(
                f"The pose of '{record.name}' ({id!r}) was asked for, but these frames never had "
                f'a pose: {self._describe(waiting)}.'
            )
        return world, row

    def _count_waiting_pairs(self) -> int:
        """Return how many unfiltered pairs have a geometry without a place."""
        world = self._up_to_date_world()
        moment = self._built, world.placings, self._filters.version
        # Asked each cycle, and 20 ms of work where 1000 bodies wait.
        if self._waiting_pairs.moment != moment:
            self._waiting_pairs = _WaitingPairs(moment, count_waiting_pairs(world, self._filters))
        return self._waiting_pairs.pairs

    def _paddings(self) -> Paddings | None:
        """Return the paddings of the geometries, None where there are none, which is quick."""
        version = self._model.versions.proximity
        if self._padded[0] != version:
            ids = self._up_to_date_world().geometries.ids
            self._padded = version, paddings_of(self._model, ids)
        return self._padded[1]

    def _versions(self) -> _Built:
        return _Built(self._model.versions.frames, self._model.versions.proximity)

    def _up_to_date_world(self) -> World:
        """Return the world, rebuilt, poses kept, if frames or shapes changed."""
        seen = self._model.versions.any
        if self._seen != seen:
            built = self._versions()
            if built != self._built:
                self._world = self._world.rebuilt(*tables_of(self._model))
            if built.frames != self._built.frames:
                self._named, self._own = {}, {}
            self._built, self._seen = built, seen
        return self._world


def checked_accuracy(accuracy: str) -> str:
    """Return an accuracy level; raises ArgumentError for a name that is none."""
    if accuracy not in ACCURACY_LEVELS:
        allowed = ', '.join(ACCURACY_LEVELS)
        raise ArgumentError(f'accuracy={accuracy!r} was asked for; it must be one of {allowed}.')
    return accuracy
