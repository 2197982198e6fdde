"""``PosedScene``: a model with its filters, and the poses of its frames."""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.world.row_change import RowChange
from drake_geom_ros.geometry._proximity.world.world import Named, World
from drake_geom_ros.geometry.errors import PoseError
from drake_geom_ros.geometry.ids import FrameId, SourceId
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model._records import FrameRecord
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector, arrays_of
from drake_geom_ros.geometry.model.scene_content import SceneContent
from drake_geom_ros.geometry.queries.world_tables import ModelMark, changed_world, tables_of
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.tolerances import WELDED_STAYS

_Scene = TypeVar('_Scene', bound='PosedScene')
_MAX_FRAME_LISTS = 64  # a limit, since callers may pose different frames each time


class _WaitingFrames(NamedTuple):
    """The frames that wait for a pose, and the moment when they did."""

    moment: object
    frames: tuple[FrameId, ...]


class PosedScene(SceneContent):
    """A model with its filters, and the world of poses that queries run on.

    ``world`` is that of the last query; ``up_to_date_world()`` includes later registrations. While
    a frame has never received a pose, queries are refused, or, with ``partial``, leave out the
    geometry on it and on its descendants.
    """

    def __init__(self, model: Model, filters: FilterState, partial: bool) -> None:
        super().__init__(model, filters)
        self.partial = partial
        self.world = World(*tables_of(model))
        self.built, self._seen = ModelMark.of(model), model.versions.any
        # Callers pose the same frames each time, so lists of frames are cached: by the bytes of
        # their ids, and those of sources by the ids of these.
        self._named: dict[bytes, Named] = {}
        self._own: dict[int, Named] = {}
        self._waiting = _WaitingFrames(None, ())
        if model.first_X_PFs:
            self.pose_frames(FramePoseVector(model.first_X_PFs))

    def _about(self: _Scene, model: Model) -> _Scene:
        """Return this scene with a copy of the model, and filters and a world of its own."""
        world = self.up_to_date_world()
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__)
        other.model, other.filters, other.world = model, self.filters.copy(), world.copy()
        other._named, other._own = dict(self._named), dict(self._own)
        return other

    def up_to_date_world(self) -> World:
        """Return the world, with changed frames and shapes, and the poses of the others."""
        seen = self.model.versions.any
        if self._seen != seen:
            built = ModelMark.of(self.model)
            if built != self.built:
                former = self.world
                self.world, change = changed_world(former, self.model, self.built)
                self._follow(former, change)
            if built.frames != self.built.frames:
                self._named, self._own = {}, {}
            self.built, self._seen = built, seen
        return self.world

    def _follow(self, former: World, change: RowChange | None) -> None:
        """Adapt what was derived from a former world; None: all of its rows are new."""

    def posed_world(self) -> World:
        """Return the world for a query; raises PoseError if a pose that it needs is missing."""
        world = self.up_to_date_world()
        if not (world.is_whole or self.partial):
            waiting = world.unposed_frames().tolist()
            raise PoseError(
                f'Of {len(world.frames.ids) - 1} frames {len(waiting)} never had a pose: '
                f'{self.describe(waiting)}. Give all frames of a source theirs by '
                'get_source_pose_port(source_id).FixValue(context, poses), some by '
                'UpdateFramePoses(poses) of the context, or what contexts begin with by '
                'SceneGraph.SetFirstPoses(poses).'
            )
        return world

    def waiting_frames(self) -> tuple[FrameId, ...]:
        """Return the frames that never had a pose, parents first; the same ones while they are."""
        world = self.up_to_date_world()
        if world.is_whole:
            return ()
        moment = self.built, world.placings
        if self._waiting.moment != moment:  # asked each cycle, of a robot of 4000 links
            frames = tuple(map(FrameId, world.unposed_frames().tolist()))
            self._waiting = _WaitingFrames(moment, frames)
        return self._waiting.frames

    def placed_frame(self, id: FrameId, *, in_world: bool = True) -> tuple[World, int]:
        """Return the world and the row of a frame in it.

        Raises UnknownIdError for an unknown frame, and PoseError if it has no pose, or if, with
        ``in_world``, an ancestor has none.
        """
        record = self.model.frame(id)
        world = self.posed_world()
        row = int(world.frame_rows(np.array([id.get_value()]))[0])
        waiting = world.unposed_on_way(row)
        if len(waiting) and (in_world or id.get_value() in waiting):
            raise PoseError(
                f"The pose of '{record.name}' ({id!r}) was asked for, but these frames never had "
                f'a pose: {self.describe(waiting)}.'
            )
        return world, row

    def X_WF(self, id: FrameId) -> RigidTransform:
        """Return the pose of a frame in the world; raises as ``placed_frame``."""
        world, row = self.placed_frame(id)
        world.update()
        return _transform(world.R_WFs[row], world.p_WFs[row])

    def X_PF(self, id: FrameId) -> RigidTransform:
        """Return the pose of a frame in its parent; raises as ``placed_frame``."""
        world, row = self.placed_frame(id, in_world=False)
        return _transform(world.R_PFs[row], world.p_PFs[row])

    def X_WFs(self, ids: ArrayLike) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Return the result of ``SceneGraphContext.X_WFs``."""
        world = self.up_to_date_world()
        values = np.asarray(ids, dtype=np.int64)
        for value in values[~world.has_frames(values)].tolist():
            self.model.frame(FrameId(value))  # raises for unknown ids; the world frame is known
        world.update()
        rows = world.frame_rows(values)
        return world.R_WFs[rows], world.p_WFs[rows], world.placed[rows]

    def describe(self, values: list[int]) -> str:
        """Return the names of frames, by their id values, for an error message."""
        names = []
        for frame in map(FrameId, values[:5]):
            record = self.model.frames.get(frame)
            names.append(f"'{record.name}' ({frame!r})" if record else repr(frame))
        more = f' and {len(values) - 5} more' if len(values) > 5 else ''
        return ', '.join(names) + more

    # Poses.

    def pose_source(self, source_id: SourceId, poses: FramePoseVector) -> None:
        """Set the poses of all frames of a source, see ``SceneGraphContext.SetFramePoses``."""
        world = self.up_to_date_world()
        own = self._own.get(source_id.get_value()) or self._source_frames(source_id)
        ids, X_PFs = arrays_of(poses)
        # Mostly the frames come in the order of their ids.
        if ids is own.ids or own.is_of(ids):
            if self.filters.welded:
                self._undo_moved_welds(ids, X_PFs)
            world.pose(own, X_PFs)
            return
        if not np.array_equal(ids := np.sort(ids), own.ids):
            problems = []
            if missing := np.setdiff1d(own.ids, ids).tolist():
                problems.append(f'these frames of it have no pose: {self.describe(missing)}')
            if foreign := np.setdiff1d(ids, own.ids).tolist():
                problems.append(f'these frames are not its own: {self.describe(foreign)}')
            raise PoseError(
                f"Poses for source '{self.model.source_name(source_id)}' were refused, nothing "
                f"was changed: {'; '.join(problems)}. Each fix needs exactly the source's frames."
            )
        self.pose_frames(poses)

    def pose_frames(self, poses: FramePoseVector) -> None:
        """Set the poses of frames of any source, see ``SceneGraphContext.UpdateFramePoses``."""
        world = self.up_to_date_world()
        ids, X_PFs = arrays_of(poses)
        named = self._frames_named(ids.tobytes(), ids)
        if self.filters.welded:
            self._undo_moved_welds(ids, X_PFs)
        world.pose(named, X_PFs)

    def unpose_frames(self, ids: Indices) -> None:
        """Let frames by id values (n,) wait again, see ``SceneGraphContext.UnposeFrames``."""
        if not self.partial:
            raise PoseError(
                'Frames of this context cannot wait for a pose again, since its queries need the '
                'poses of all: make it by CreateSharedContext(partial=True).'
            )
        self.up_to_date_world().unpose(self._frames_named(ids.tobytes(), ids).rows)

    def begin_at(self, frame: FrameRecord, X_PF: RigidTransform) -> None:
        """Pose a frame that got another parent, here and in later contexts of this scene."""
        super().begin_at(frame, X_PF)
        self.pose_frames(FramePoseVector({frame.id: X_PF}))

    def _source_frames(self, source_id: SourceId) -> Named:
        """Return a source's frames by ascending ids, and cache the list."""
        values = [frame.get_value() for frame in self.model.frames_of_source(source_id)]
        ids = np.array(sorted(values), dtype=np.int64)
        own = self._own[source_id.get_value()] = self._frames_named(ids.tobytes(), ids)
        return own

    def _frames_named(self, key: bytes, ids: Indices) -> Named:
        """Return the cached list of frames by id values (n,), whose bytes are the ``key``.

        Raises PoseError when a frame does not exist.
        """
        named = self._named.get(key)
        if named is None:
            world = self.up_to_date_world()
            named = world.named(ids)
            if named is None:
                unknown = ids[~world.has_frames(ids)]
                raise PoseError(
                    'Poses were refused, nothing was changed: these frames are not in this scene: '
                    f'{self.describe(sorted(unknown.tolist()))}.'
                )
            if len(self._named) == _MAX_FRAME_LISTS:
                del self._named[next(iter(self._named))]
            self._named[key] = named
        return named

    def _undo_moved_welds(self, ids: Indices, X_PFs: Floats) -> None:
        """Undo the welds of frames whose new pose differs from their first one."""
        welded = self.filters.welded
        for frame, X_WF in zip(ids.tolist(), X_PFs, strict=True):
            if frame not in welded:
                continue
            first = welded[frame]
            if first is None:
                welded[frame] = X_WF.copy()
            elif np.abs(X_WF - first).max() > WELDED_STAYS:
                self.unweld(frame)


def _transform(R: Floats, p: Floats) -> RigidTransform:
    return RigidTransform(RotationMatrix(R.copy()), p.copy())
