"""``PreparedQuery``: one query, repeated for new poses of the same frames."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal, Protocol, get_args

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry._proximity.engine.pair_query import ANSWERS, CONTACT
from drake_geom_ros.geometry._proximity.engine.prepared import Prepared
from drake_geom_ros.geometry._proximity.world.pose_rows import FRAME_POSES, POSE_WIDTH, REFUSED
from drake_geom_ros.geometry._proximity.world.world import Named
from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.model.frame_pose_vector import FramePoseVector
from drake_geom_ros.geometry.queries.accuracy import AccuracyLike
from drake_geom_ros.geometry.queries.context_state import ContextState
from drake_geom_ros.geometry.queries.query_results import (
    PenetrationResults,
    SignedDistanceResults,
)
from drake_geom_ros.math.array_types import Indices

Asked = Literal['penetrations', 'distances', 'collision']
Answer = PenetrationResults | SignedDistanceResults | bool
_FLOAT64 = np.dtype(np.float64)
_Array, _empty = np.ndarray, np.empty


class Posable(Protocol):
    """A context, as a prepared query needs it."""

    def UpdateFramePoses(self, poses: FramePoseVector) -> None:
        """Set the poses of some frames."""


class PreparedQuery:
    """A call from poses (n, 7) of frames to the answer of a query, see ``prepare`` of a context.

    Calls are those of ``UpdateFramePoses`` and a query object, with the same answers and errors;
    everything that poses do not change is looked up once, and again after a change of the scene.
    """

    query_type: ClassVar[type[Any]]  # set by ``query_object``, which is about contexts

    def __init__(
        self,
        context: Posable,
        state: ContextState,
        frame_ids: Indices,
        question: Asked,
        accuracy: AccuracyLike | None,
        max_distance: float,
    ) -> None:
        if question not in get_args(Asked):
            allowed = ', '.join(get_args(Asked))
            raise ArgumentError(f'prepare was asked for {question!r}; it must be one of {allowed}')
        if math.isnan(max_distance) or (question != 'distances' and max_distance != math.inf):
            raise ArgumentError(
                f'prepare was given max_distance={max_distance} for {question!r}; only distances '
                'have one, a number in metres or infinity'
            )
        self._context, self._state, self._ids = context, state, frame_ids
        self._question, self._accuracy, self._reach = (
            question,
            state.accuracy_for(accuracy),
            max_distance,
        )
        self._usual = self.query_type(context)
        self._query: Prepared | None = None
        self._named = Named(frame_ids[:0], frame_ids[:0])

    def __call__(self, poses: ArrayLike) -> Answer:
        """Return the answer at poses X_PF (n, 7), x y z [m] qx qy qz qw; other frames keep theirs.

        Raises PoseError for invalid poses, as ``FramePoseVector.FromArrays`` does, and as the
        query does.
        """
        state, query = self._state, self._query
        if (
            query is None
            or query.scene != state.model.versions.any + state.filters.version
            or query.handles is not query.near.handles
        ):
            query = self._look_up()
        if query is None or type(poses) is not _Array or poses.dtype is not _FLOAT64:
            return self._ask_usually(poses)
        X_PFs = _empty((len(self._ids), POSE_WIDTH))
        try:
            status = FRAME_POSES.call(self._ids, self._ids, poses, X_PFs)
        except TypeError:  # of another number of dimensions
            status = REFUSED
        if status == REFUSED:
            return self._ask_usually(poses)  # which names the fault
        world = query.world
        world.pose(self._named, X_PFs)
        if self._question == 'collision':
            return state.engine.finds_overlap(query)
        answers = state.engine.answer_of(query)
        if self._question == 'penetrations':
            return PenetrationResults(answers, world.kept_poses())
        return SignedDistanceResults(answers, world.kept_poses())

    def _look_up(self) -> Prepared | None:
        """Return the query for the scene of now; None where a query object has more to do."""
        state, self._query = self._state, None
        world = state.up_to_date_world()
        named = world.named(self._ids)
        of_bounds = self._accuracy == 'bound' and self._question == 'penetrations'
        if (
            *(named is None, bool(state.filters.welded), state.paddings() is not None),
            *(not world.is_whole, world.has_plane_pairs, of_bounds),
        ) != (False,) * 6:
            return None
        assert named is not None
        distances = self._question == 'distances'
        query = state.engine.prepared(
            world,
            state.filters,
            self._accuracy.length,
            self._reach if distances else 0.0,
            not distances,
            CONTACT if self._question == 'collision' else ANSWERS,
        )
        query.scene = state.model.versions.any + state.filters.version
        self._query, self._named = query, named
        return query

    def _ask_usually(self, poses: ArrayLike) -> Answer:
        """Return the answer of a query object."""
        self._context.UpdateFramePoses(FramePoseVector.FromArrays(self._ids, poses))
        usual, accuracy, answer = self._usual, self._accuracy, None
        if self._question == 'collision':
            answer = usual.HasCollisions(accuracy=accuracy)
        elif self._question == 'penetrations':
            answer = usual.ComputePointPairPenetration(accuracy=accuracy)
        else:
            distances = usual.ComputeSignedDistancePairwiseClosestPoints
            answer = distances(self._reach, accuracy=accuracy)
        return answer  # type: ignore[no-any-return]
