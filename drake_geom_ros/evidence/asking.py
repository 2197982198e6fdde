"""Two bodies in a scene of ours, asked by every query that there is."""

from __future__ import annotations

from drake_geom_ros.evidence.hard_cases.cases import Body
from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    PenetrationResults,
    PointDistanceResults,
    SceneGraph,
    SignedDistanceResults,
)
from drake_geom_ros.math import RigidTransform


class PairScene:
    """A scene of the shapes of A and B; the bodies are posed as often as wanted."""

    def __init__(self, a: Body, b: Body) -> None:
        graph = SceneGraph()
        self._source = graph.RegisterSource('pair')
        self._frames, self._ids = [], []
        for name, one in (('a', a), ('b', b)):
            self._frames.append(graph.RegisterFrame(self._source, GeometryFrame(name)))
            instance = GeometryInstance(RigidTransform(), one.shape, name)
            instance.set_proximity_properties(one.properties)
            geometry = graph.RegisterGeometry(self._source, self._frames[-1], instance)
            self._ids.append(geometry)
        self._context = graph.CreateDefaultContext()
        self._port = graph.get_source_pose_port(self._source)
        self.query = graph.get_query_output_port().Eval(self._context)
        self.pose(a.pose, b.pose)

    def pose(self, X_WA: RigidTransform, X_WB: RigidTransform) -> None:
        """Pose both bodies."""
        poses = dict(zip(self._frames, (X_WA, X_WB), strict=True))
        self._port.FixValue(self._context, FramePoseVector(poses))

    def distance(self, accuracy: str = 'exact') -> SignedDistanceResults:
        """Return the pair's signed distance, asked for by name."""
        return self.query.signed_distance_of_pair(*self._ids, accuracy=accuracy)

    def pairwise(self, max_distance: float, accuracy: str = 'exact') -> SignedDistanceResults:
        """Return the pairs no farther apart than a distance: this one, or none."""
        return self.query.ComputeSignedDistancePairwiseClosestPoints(
            max_distance, accuracy=accuracy
        )

    def penetration(self, accuracy: str = 'exact') -> PenetrationResults:
        """Return the pair if it overlaps."""
        return self.query.ComputePointPairPenetration(accuracy=accuracy)

    def collides(self) -> bool:
        """Return whether the pair overlaps."""
        return bool(self.query.HasCollisions())

    def is_candidate(self) -> bool:
        """Return whether bounds leave it open that the pair overlaps."""
        return len(self.query.collision_candidates()) == 1

    def to_point(self, one: Body) -> PointDistanceResults:
        """Return the distances from both shapes to the centre of a body."""
        return self.query.ComputeSignedDistanceToPoint(one.p)
