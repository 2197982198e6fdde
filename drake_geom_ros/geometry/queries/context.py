"""``SceneGraphContext``: a copy of the scene model with poses, which queries run on."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry._proximity.engine.warm_up import warm_up
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.runtime.compiled import Tell, compilation
from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.ids import FrameId, GeometryId, SourceId
from drake_geom_ros.geometry.model._model import Model
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.model.properties import ProximityProperties
from drake_geom_ros.geometry.model.scene_content import SceneHolder
from drake_geom_ros.geometry.queries.accuracy import AccuracyLike
from drake_geom_ros.geometry.queries.context_state import ContextState
from drake_geom_ros.geometry.queries.prepared_query import Asked, PreparedQuery
from drake_geom_ros.math.array_types import Floats, Indices

_Context = TypeVar('_Context', bound='SceneGraphContext')


class SceneGraphContext(SceneHolder):
    """Model, filters and poses that queries run on.

    Made by ``SceneGraph.CreateDefaultContext()``. Changes of the SceneGraph's model do not reach
    existing contexts, and the reverse. While a frame has never received a pose, queries raise
    PoseError, or, with ``partial``, leave out the geometry on it and on its descendants.
    """

    scalar = 'float'  # type of the poses' numbers; query objects have the same
    _state: ContextState
    _state_type = ContextState

    def __init__(
        self, model: Model, filters: FilterState, accuracy: AccuracyLike, partial: bool = False
    ) -> None:
        self._state = self._state_type(model, filters, accuracy, partial)

    def copy(self: _Context) -> _Context:
        """Return an independent copy."""
        return self._of(self._state.copy())

    def Clone(self: _Context) -> _Context:
        """Return ``copy()``, by pydrake's name."""
        return self.copy()

    def what_if(self: _Context) -> _Context:
        """Return a cheap snapshot to pose and query, also in another thread.

        It is for queries only: the snapshots of one version of the model share a copy of it.
        """
        return self._of(self._state.snapshot())

    @classmethod
    def _of(cls: type[_Context], state: ContextState) -> _Context:
        other = cls.__new__(cls)
        other._state = state
        return other

    def narrowed(
        self: _Context, considered: NDArray[np.bool_], kinds: Indices | None = None
    ) -> _Context:
        """Return a context that considers some pairs only, see ``QueryObject.narrowed``."""
        if kinds is None:
            kinds = np.arange(len(considered))
        return self._of(self._state.narrowed(considered, kinds))

    def with_proximity(
        self: _Context, properties: Mapping[GeometryId, ProximityProperties]
    ) -> _Context:
        """Return a copy with more geometries, see ``QueryObject.with_proximity``."""
        return self._of(self._state.with_proximity(properties))

    def set_default_accuracy(self, accuracy: AccuracyLike) -> None:
        """Set the default accuracy of queries: bound, fast, balanced, exact or a length [m]."""
        self._state.set_accuracy(accuracy)

    def set_detailed_effects(self, detailed: bool) -> None:
        """Set whether ``QueryObject.effects()`` gives the seconds of cache and kernels separately.

        That costs a query some microseconds.
        """
        self._state.engine.detailed = detailed

    def compile_kernels(self, tell: Tell | None = None, part: str = 'all') -> list[str]:
        """Compile the kernels for this scene, or load them from the cache; return their names.

        Queries compile missing kernels themselves. A node calls this before its first cycle, and
        ``python -m drake_geom_ros compile`` for all scenes. ``tell(name, number, last)`` is called
        before each part that the cache lacks. Two processes may compile one ``part`` each:
        'kernels', or 'cycle' for the code around them.
        """
        if part not in ('all', 'cycle', 'kernels'):
            raise ValueError(f"part '{part}' is none of 'all', 'cycle', 'kernels'")
        if part != 'kernels':
            warm_up(tell)
        if part == 'cycle':
            return []
        kernels = self._state.engine.prepare(self._state.up_to_date_world(), tell)
        with compilation(tell, 'contact surfaces', 1, 1):
            self._state.contact_bodies().load_kernels()
        return kernels

    def SetFramePoses(self, source_id: SourceId, poses: FramePoseVector) -> None:
        """Set the poses of all frames of a source.

        Raises PoseError when ``poses`` lacks a frame of the source or has another source's; no
        pose changes then. Values are checked when ``poses`` is made.
        """
        self._state.pose_source(source_id, poses)

    def UpdateFramePoses(self, poses: FramePoseVector) -> None:
        """Set the poses of the frames in ``poses``, of any source; other frames keep theirs.

        Raises PoseError when a frame does not exist; nothing changes then.
        """
        self._state.pose_frames(poses)

    def UnposeFrames(self, frame_ids: Iterable[FrameId]) -> None:
        """Let frames of any source wait for a pose, as before their first one.

        Queries omit the geometry on them and on their descendants until they are posed again.
        Raises PoseError when a frame does not exist, and for a context that is not ``partial``;
        nothing changes then.

            >>> scene_graph = SceneGraph()
            >>> source_id = scene_graph.RegisterSource('people')
            >>> head = scene_graph.RegisterFrame(source_id, GeometryFrame('head'))
            >>> context = scene_graph.CreateSharedContext(partial=True)
            >>> context.UpdateFramePoses(FramePoseVector({head: RigidTransform()}))
            >>> context.UnposeFrames([head])
            >>> QueryObject(context).waiting_frames() == [head]
            True
        """
        values = [frame_id.get_value() for frame_id in frame_ids]
        self._state.unpose_frames(np.array(values, dtype=np.int64))

    def prepare(
        self,
        frame_ids: Sequence[FrameId] | NDArray[np.integer],
        what: Asked,
        *,
        max_distance: float = math.inf,
        accuracy: AccuracyLike | None = None,
    ) -> PreparedQuery:
        """Return a call from poses X_PF (n, 7) of n frames to the answer of a query.

        ``what`` is ``'penetrations'``, ``'distances'`` (up to ``max_distance`` [m]) or
        ``'collision'``. The call poses these frames, of any source, and answers as
        ``ComputePointPairPenetration``, ``ComputeSignedDistancePairwiseClosestPoints`` and
        ``HasCollisions`` do, with the same bits, in fewer steps: this counts in cycles after other
        work. It sees later changes of the context. ``accuracy`` is a level or a length [m], None
        for the default of now. Raises ArgumentError for another ``what`` or an invalid argument,
        and for a context of AutoDiffXd, and PoseError for a frame that is listed twice.

            >>> scene_graph = SceneGraph()
            >>> source_id = scene_graph.RegisterSource('balls')
            >>> frame_ids = []
            >>> for name in 'ab':
            ...     frame_ids.append(scene_graph.RegisterFrame(source_id, GeometryFrame(name)))
            ...     ball = GeometryInstance(RigidTransform(), Sphere(0.1), name)
            ...     ball.set_proximity_properties(ProximityProperties())
            ...     _ = scene_graph.RegisterGeometry(source_id, frame_ids[-1], ball)
            >>> context = scene_graph.CreateDefaultContext()
            >>> distances = context.prepare(frame_ids, 'distances', max_distance=1.0)
            >>> distances([[0, 0, 0, 0, 0, 0, 1], [0, 0, 0.5, 0, 0, 0, 1]]).distance.tolist()
            [0.3]
        """
        if self.scalar != 'float':
            raise ArgumentError(
                f'prepare was asked of a context of {self.scalar}; it has no derivatives: '
                'ask a query object, or a context of a SceneGraph'
            )
        values = FramePoseVector.FromArrays(frame_ids, _at_origin(len(frame_ids))).id_values()
        ids = values.copy()
        return PreparedQuery(self, self._state, ids, what, accuracy, max_distance)

    def X_WFs(self, ids: ArrayLike) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Return R_WF (k, 3, 3) and p_WF (k, 3) [m] of frames by the values (k,) of their ids.

        The third array (k,) is True for frames that have a pose, as all their ancestors do; rows
        of the others are meaningless. Raises UnknownIdError for an id that is no frame here.
        """
        return self._state.X_WFs(ids)


def _at_origin(count: int) -> Floats:
    """Return poses (n, 7) at the origin."""
    return np.tile([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], (count, 1))


def state_of(context: SceneGraphContext) -> ContextState:
    """Return the state of a context, for the packages that answer queries on it."""
    return context._state
