"""pydrake: a SceneGraph of two frames, asked by its QueryObject."""

from __future__ import annotations

from typing import Any

from drake_geom_ros.cross_check.answers import (
    SIGNED_DISTANCE,
    Ask,
    PairAnswer,
    Unsupported,
    checked,
    kind_of,
    measures,
    no_tolerance,
)
from drake_geom_ros.geometry import Shape
from drake_geom_ros.math import RigidTransform


def drake_shape(shape: Shape) -> Any:
    """Return a shape of ours as pydrake's."""
    from pydrake import geometry

    if kind_of(shape) == 'Convex':
        vertices, _ = shape.hull_surface()  # type: ignore[attr-defined]
        return geometry.Convex(points=vertices.T, label='hull')
    return getattr(geometry, kind_of(shape))(*measures(shape))


class PydrakePeer:
    """pydrake's ComputeSignedDistancePairClosestPoints and ComputePointPairPenetration."""

    name = 'pydrake'

    def __init__(self, tolerance: float | None) -> None:
        no_tolerance(self.name, tolerance)

    def pair(self, query: str, shape_a: Shape, shape_b: Shape) -> Ask:
        """Return what asks the query; see Peer."""
        scene = _Scene(shape_a, shape_b)
        return scene.distance if checked(query) == SIGNED_DISTANCE else scene.penetration


class _Scene:
    """Two geometries on frames of their own, and a live query object."""

    def __init__(self, shape_a: Shape, shape_b: Shape) -> None:
        from pydrake import geometry, math

        self._math = math
        graph = geometry.SceneGraph()
        source = graph.RegisterSource('pair')
        self._frames, self._ids = [], []
        for name, shape in (('a', shape_a), ('b', shape_b)):
            frame = graph.RegisterFrame(source, geometry.GeometryFrame(name))
            instance = geometry.GeometryInstance(math.RigidTransform(), drake_shape(shape), name)
            instance.set_proximity_properties(geometry.ProximityProperties())
            self._frames.append(frame)
            self._ids.append(graph.RegisterGeometry(source, frame, instance))
        self._poses = geometry.FramePoseVector()
        self._context = graph.CreateDefaultContext()
        self._port = graph.get_source_pose_port(source)
        self._pose_both(RigidTransform(), RigidTransform())
        self._query = graph.get_query_output_port().Eval(self._context)

    def _pose_both(self, X_WA: RigidTransform, X_WB: RigidTransform) -> None:
        for frame, X in zip(self._frames, (X_WA, X_WB), strict=True):
            R = self._math.RotationMatrix(X.rotation().matrix())
            self._poses.set_value(frame, self._math.RigidTransform(R, X.translation()))
        self._port.FixValue(self._context, self._poses)

    def distance(self, X_WA: RigidTransform, X_WB: RigidTransform) -> PairAnswer:
        self._pose_both(X_WA, X_WB)
        try:
            found = self._query.ComputeSignedDistancePairClosestPoints(*self._ids)
        except RuntimeError as error:
            if 'are not supported' in str(error):  # of this pair of types, whatever the poses
                raise Unsupported(str(error)) from None
            raise
        points = (
            self._query.GetPoseInWorld(found.id_A).multiply(found.p_ACa),
            self._query.GetPoseInWorld(found.id_B).multiply(found.p_BCb),
        )
        return self._in_order(found, found.distance, *points)

    def penetration(self, X_WA: RigidTransform, X_WB: RigidTransform) -> PairAnswer | None:
        self._pose_both(X_WA, X_WB)
        for found in self._query.ComputePointPairPenetration():
            return self._in_order(found, -found.depth, found.p_WCa, found.p_WCb)
        return None

    def _in_order(self, found: Any, distance: float, p_WCa: Any, p_WCb: Any) -> PairAnswer:
        """Return an answer with A and B as asked for, for pydrake orders them as it likes."""
        if found.id_A == self._ids[0]:
            return PairAnswer(distance, found.nhat_BA_W, p_WCa, p_WCb)
        return PairAnswer(distance, -found.nhat_BA_W, p_WCb, p_WCa)
