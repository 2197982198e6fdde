"""Our side: arrays in, arrays out."""

from __future__ import annotations

import numpy as np

from bench.peers.scenes import NEAR, Floats, Scene
from drake_geom_ros import geometry
from truth.judging.asking import BodyScene

NAME = 'ours'


class Side:
    """A scene graph with one frame a body, and its kernels loaded, as a node has them."""

    def __init__(self, scene: Scene, loaded: bool = True) -> None:
        built = BodyScene(scene.bodies, scene.anchored)
        for a, b in scene.filtered:
            declaration = geometry.CollisionFilterDeclaration().ExcludeBetween(
                geometry.GeometrySet([built.ids[a]]), geometry.GeometrySet([built.ids[b]])
            )
            built.graph.collision_filter_manager().Apply(declaration)
        self.answers = {
            'penetration': self._penetration,
            'candidates': self._candidates,
            'near': lambda: self._distances(NEAR),
            'all': lambda: self._distances(np.inf),
            'points': self._to_points,
            'has_collisions': self._has_collisions,
        }
        self._frames = np.array([frame.get_value() for frame in built.frames])
        self._points = scene.points
        self._context = built.graph.CreateDefaultContext()
        self._port = built.graph.get_source_pose_port(built.source)
        if loaded:
            self._context.compile_kernels()
        self.query = built.asked(self._context)

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
        return len(self.query.FindCollisionCandidates())

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
