"""Our side: arrays in, arrays out."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from bench.peers.our_shapes import our_shape
from bench.peers.scenes import NEAR, Floats, Scene, Shape
from drake_geom_ros import geometry
from drake_geom_ros.math import RigidTransform, RotationMatrix

NAME = 'ours'


class Side:
    """A scene graph with one frame a body."""

    def __init__(self, scene: Scene) -> None:
        graph = geometry.SceneGraph()
        self._source = graph.RegisterSource('bench')
        frames, ids = [], []
        for number, shape in enumerate(scene.bodies):
            frame = geometry.GeometryFrame(f'body {number}')
            frames.append(graph.RegisterFrame(self._source, frame))
            ids.append(self._register(graph, frames[-1], shape, f'body {number}'))
        for number, (shape, X_WG) in enumerate(scene.anchored):
            self._register(graph, graph.world_frame_id(), shape, f'anchored {number}', X_WG)
        for a, b in scene.filtered:
            declaration = geometry.CollisionFilterDeclaration().ExcludeBetween(
                geometry.GeometrySet([ids[a]]), geometry.GeometrySet([ids[b]])
            )
            graph.collision_filter_manager().Apply(declaration)
        self.answers = {
            'penetration': self._penetration,
            'candidates': self._candidates,
            'near': lambda: self._distances(NEAR),
            'all': lambda: self._distances(np.inf),
            'points': self._to_points,
            'has_collisions': self._has_collisions,
        }
        self._frames = np.array([frame.get_value() for frame in frames])
        self._points = scene.points
        self._context = graph.CreateDefaultContext()
        self._port = graph.get_source_pose_port(self._source)
        self.query = graph.get_query_output_port().Eval(self._context)

    def _register(
        self,
        graph: geometry.SceneGraph,
        frame: geometry.FrameId,
        shape: Shape,
        name: str,
        X_FG: Floats | None = None,
    ) -> geometry.GeometryId:
        instance = geometry.GeometryInstance(_transform(X_FG), our_shape(shape), name)
        instance.set_proximity_properties(geometry.ProximityProperties())
        return graph.RegisterGeometry(self._source, frame, instance)

    def layout(self, poses: Floats) -> Floats:
        """Return poses (n, 7) as this library takes them."""
        return poses

    def set_poses(self, poses: Floats) -> None:
        """Pose all bodies."""
        vector = geometry.FramePoseVector.FromArrays(self._frames, poses)
        self._port.FixValue(self._context, vector)

    def _penetration(self) -> int:
        pairs = self.query.ComputePointPairPenetration()
        arrays = pairs.id_A, pairs.id_B, pairs.depth, pairs.p_WCa, pairs.p_WCb, pairs.nhat_BA_W
        return len(arrays[0])

    def _candidates(self) -> int:
        return len(self.query.collision_candidates())

    def _distances(self, most: float) -> int:
        pairs = self.query.ComputeSignedDistancePairwiseClosestPoints(most)
        arrays = pairs.id_A, pairs.id_B, pairs.distance, pairs.p_ACa, pairs.p_BCb, pairs.nhat_BA_W
        return len(arrays[0])

    def _to_points(self) -> int:
        found = self.query.ComputeSignedDistanceToPoint(self._points)
        arrays = found.id_G, found.point_index, found.distance, found.p_GN, found.grad_W
        return len(arrays[0])

    def _has_collisions(self) -> int:
        return int(self.query.HasCollisions())


def _transform(X: Floats | None) -> RigidTransform:
    if X is None:
        return RigidTransform()
    return RigidTransform(RotationMatrix(Rotation.from_quat(X[3:]).as_matrix()), X[:3])
