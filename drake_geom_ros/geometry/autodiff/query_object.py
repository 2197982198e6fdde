"""``QueryObject_[AutoDiffXd]``: queries about poses with derivatives."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from drake_geom_ros.autodiffutils.arrays import (
    autodiff_array,
    derivatives_of,
    scalar_type,
    values_of,
)
from drake_geom_ros.autodiffutils.autodiff import is_autodiff
from drake_geom_ros.geometry.autodiff.context import (
    ContextStateAutoDiffXd,
    SceneGraphContextAutoDiffXd,
    SceneGraphInspectorAutoDiffXd,
    state_of,
)
from drake_geom_ros.geometry.autodiff.derived import PairWitnesses, PointWitnesses
from drake_geom_ros.geometry.autodiff.poses import with_derivatives
from drake_geom_ros.geometry.autodiff.records import (
    PenetrationAsPointPairAutoDiffXd,
    SignedDistancePairAutoDiffXd,
    SignedDistanceToPointAutoDiffXd,
)
from drake_geom_ros.geometry.errors import ArgumentError
from drake_geom_ros.geometry.ids import FrameId, GeometryId, only_id
from drake_geom_ros.geometry.queries.accuracy import AccuracyLike
from drake_geom_ros.geometry.queries.context_state import NO_SCENE
from drake_geom_ros.geometry.queries.query_object import QueryObject
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.missing import refuse_missing_member

if TYPE_CHECKING:
    from drake_geom_ros.autodiffutils.transforms import RigidTransformAutoDiffXd
    from drake_geom_ros.geometry.queries.query_results import (
        PenetrationResults,
        SignedDistanceResults,
    )


class QueryObjectAutoDiffXd:
    """Queries on a context of ``SceneGraph_[AutoDiffXd]``, with derivatives.

    Values are those of ``QueryObject``; distances and depths have the derivatives of
    ``gradients``, for every pair of shapes. Without a context every query raises GeometryError.
    """

    def __init__(self, context: SceneGraphContextAutoDiffXd | None = None) -> None:
        self._values = QueryObject(context)
        self._context = context
        # The state without a scene raises GeometryError in every query.
        self._state = (
            cast(ContextStateAutoDiffXd, NO_SCENE) if context is None else state_of(context)
        )

    if not TYPE_CHECKING:  # mypy would take any method for one that is there
        __getattr__ = refuse_missing_member

    def __copy__(self) -> QueryObjectAutoDiffXd:
        return QueryObjectAutoDiffXd(self._context and self._context.copy())

    def __deepcopy__(self, memo: dict[int, object]) -> QueryObjectAutoDiffXd:
        return self.__copy__()

    def inspector(self) -> SceneGraphInspectorAutoDiffXd:
        """Return the inspector of this context's model."""
        return SceneGraphInspectorAutoDiffXd(self._state.model, self._state.filters)

    # Poses.

    def GetPoseInWorld(self, id: FrameId | GeometryId) -> RigidTransformAutoDiffXd:
        """Return X_WF of a frame or X_WG of a geometry; raises for an unknown id."""
        return self.X_WG(id) if isinstance(id, GeometryId) else self.X_WF(id)

    def GetPoseInParent(self, frame_id: FrameId) -> RigidTransformAutoDiffXd:
        """Return X_PF, the pose of a frame in its parent; raises for an unknown id."""
        return self.X_PF(frame_id)

    def X_WF(self, id: FrameId) -> RigidTransformAutoDiffXd:
        """Return the pose of a frame in the world; raises for an unknown id."""
        X_WF = self._values.X_WF(id)
        world, row = self._state.placed_frame(id)
        V_WF = self._state.spatial_velocities(world)[row]
        return with_derivatives(X_WF, V_WF, self._state.number)

    def X_PF(self, id: FrameId) -> RigidTransformAutoDiffXd:
        """Return the pose of a frame in its parent; raises for an unknown id."""
        V_PF = self._state.velocity_in_parent(id)
        return with_derivatives(self._values.X_PF(id), V_PF, self._state.number)

    def X_WG(self, id: GeometryId) -> RigidTransformAutoDiffXd:
        """Return the pose of a geometry in the world; raises for an unknown id."""
        record = self._state.model.geometry(id)
        X_WG: RigidTransformAutoDiffXd = self.X_WF(record.frame_id) @ record.X_FG
        return X_WG

    # Pairs.

    def ComputePointPairPenetration(
        self, *, accuracy: AccuracyLike | None = None
    ) -> list[PenetrationAsPointPairAutoDiffXd]:
        """Return the unfiltered pairs that overlap, as QueryObject does."""
        results = self._values.ComputePointPairPenetration(accuracy=accuracy)
        depths, witnesses = self._of_pairs(results, results.depth, results.depth_jacobian)
        return [
            PenetrationAsPointPairAutoDiffXd(
                id_A=GeometryId(int(results.id_A[k])),
                id_B=GeometryId(int(results.id_B[k])),
                depth=depths[k],
                is_gradient_unique=bool(results.is_gradient_unique[k]),
                error_bound=float(results.error_bound[k]),
                method=int(results.method[k]),
            ).completed_by(partial(witnesses.in_world, k))
            for k in range(len(results))
        ]

    def ComputeSignedDistancePairwiseClosestPoints(
        self, max_distance: float = math.inf, *, accuracy: AccuracyLike | None = None
    ) -> list[SignedDistancePairAutoDiffXd]:
        """Return the unfiltered pairs within ``max_distance`` [m], as QueryObject does."""
        compute = self._values.ComputeSignedDistancePairwiseClosestPoints
        return self._distances(compute(max_distance, accuracy=accuracy))

    def ComputeSignedDistancePairClosestPoints(
        self,
        geometry_id_A: GeometryId | None = None,
        geometry_id_B: GeometryId | None = None,
        *,
        accuracy: AccuracyLike | None = None,
        id_A: GeometryId | None = None,
        id_B: GeometryId | None = None,
    ) -> SignedDistancePairAutoDiffXd:
        """Return the signed distance of two geometries, as QueryObject does."""
        first = only_id('geometry_id_A', geometry_id_A, id_A)
        second = only_id('geometry_id_B', geometry_id_B, id_B)
        compute = self._values.signed_distance_of_pair
        return self._distances(compute(first, second, accuracy=accuracy))[0]

    def FindCollisionCandidates(self) -> list[tuple[GeometryId, GeometryId]]:
        """Return the unfiltered pairs that bounding volumes do not separate, sorted by ids."""
        return self._values.FindCollisionCandidates()

    def HasCollisions(self) -> bool:
        """Return whether ComputePointPairPenetration would report a pair."""
        return self._values.HasCollisions()

    def _distances(self, results: SignedDistanceResults) -> list[SignedDistancePairAutoDiffXd]:
        """Return the records of results."""
        distances, witnesses = self._of_pairs(results, results.distance, results.distance_jacobian)
        return [
            SignedDistancePairAutoDiffXd(
                id_A=GeometryId(int(results.id_A[k])),
                id_B=GeometryId(int(results.id_B[k])),
                distance=distances[k],
                is_nhat_BA_W_unique=bool(results.is_nhat_BA_W_unique[k]),
                is_gradient_unique=bool(results.is_gradient_unique[k]),
                error_bound=float(results.error_bound[k]),
                method=int(results.method[k]),
            ).completed_by(partial(witnesses.in_bodies, k))
            for k in range(len(results))
        ]

    def _of_pairs(
        self,
        results: SignedDistanceResults | PenetrationResults,
        values: Floats,
        jacobian: Callable[[Floats, Floats], Floats],
    ) -> tuple[Any, PairWitnesses]:
        """Return the reported values with derivatives, and the derivatives of the points."""
        V_WFs = self._state.spatial_velocities(self._state.up_to_date_world())
        witnesses = PairWitnesses(results, V_WFs, self._state.number)
        J_As, J_Bs = witnesses.velocities
        rates = jacobian(J_As, J_Bs)
        return autodiff_array(values, rates, self._state.number), witnesses

    # Points.

    def ComputeSignedDistanceToPoint(
        self, p_WQ: Any, threshold: float = math.inf, *, accuracy: AccuracyLike | None = None
    ) -> list[SignedDistanceToPointAutoDiffXd]:
        """Return the signed distances from all geometries to a point, or to points (m, 3).

        Points of floats are constants. Otherwise it is as in QueryObject.
        """
        points = np.asarray(p_WQ)
        compute = self._values.ComputeSignedDistanceToPoint
        results = compute(values_of(points), threshold, accuracy=accuracy)
        V_WFs = self._state.spatial_velocities(self._state.up_to_date_world())
        v_Qs = derivatives_of(points.reshape(-1, 3))
        V_WFs, v_Qs = _of_the_same(V_WFs, v_Qs)
        moving = any(map(is_autodiff, points.astype(object).ravel()))
        number = scalar_type(points) if moving else self._state.number
        witnesses = PointWitnesses(results, V_WFs, v_Qs, number)
        rates = results.distance_jacobian(witnesses.velocities, witnesses.of_points)
        distances = autodiff_array(results.distance, rates, number)
        return [
            SignedDistanceToPointAutoDiffXd(
                id_G=GeometryId(int(results.id_G[k])),
                distance=distances[k],
                is_grad_W_unique=bool(results.is_grad_W_unique[k]),
                error_bound=float(results.error_bound[k]),
                method=int(results.method[k]),
                point_index=int(results.point_index[k]),
            ).completed_by(partial(witnesses.nearest, k))
            for k in range(len(results))
        ]


def _of_the_same(V_WFs: Floats, v_Qs: Floats) -> tuple[Floats, Floats]:
    """Return both with the same number of variables; constants get zeros."""
    n, m = V_WFs.shape[-1], v_Qs.shape[-1]
    if n and m and n != m:
        raise ArgumentError(
            f'ComputeSignedDistanceToPoint: poses have derivatives by {n} variables and p_WQ by '
            f'{m}; both must be by the same ones, see InitializeAutoDiffTuple.'
        )
    if not n:
        V_WFs = np.zeros((*V_WFs.shape[:-1], m))
    if not m:
        v_Qs = np.zeros((*v_Qs.shape[:-1], n))
    return V_WFs, v_Qs
