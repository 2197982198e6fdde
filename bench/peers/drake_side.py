"""pydrake's side: a MultibodyPlant of free bodies, posed by SetPositions.

The plant makes the poses in C++; a FramePoseVector of RigidTransforms made in Python would cost
5 to 10 us a body. Results are lists of records: the length is taken and the distance of each is
read into an array, which is less than what a user of the witness points pays.
"""

from __future__ import annotations

import numpy as np
from pydrake import geometry, math
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from bench.peers.scenes import NEAR, Floats, Scene
from drake_geom_ros.cross_check.bodies import Body
from truth.peers.pydrake_peer import drake_shape

NAME = 'pydrake'


class Side:
    """A plant and its scene graph in one diagram."""

    def __init__(self, scene: Scene) -> None:
        builder = DiagramBuilder()
        self._plant, graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
        bodies, ids = [], []
        for number, one in enumerate(scene.bodies):
            bodies.append(self._plant.AddRigidBody(f'body {number}', inertia))
            ids.append(self._register(bodies[-1], math.RigidTransform(), one, f'b{number}'))
        for number, one in enumerate(scene.anchored):
            X_WG = math.RigidTransform(math.RotationMatrix(one.R), one.p)
            self._register(self._plant.world_body(), X_WG, one, f'a{number}')
        self._plant.Finalize()
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
        self._starts = np.array([body.floating_positions_start() for body in bodies])
        self._diagram = builder.Build()
        self._root = self._diagram.CreateDefaultContext()
        self._context = self._plant.GetMyMutableContextFromRoot(self._root)
        port = graph.get_query_output_port()
        self._query = port.Eval(graph.GetMyContextFromRoot(self._root))
        self._points = scene.points

    def _register(
        self, body: object, X_BG: math.RigidTransform, one: Body, name: str
    ) -> geometry.GeometryId:
        friction = CoulombFriction(1.0, 1.0)
        return self._plant.RegisterCollisionGeometry(
            body, X_BG, drake_shape(one.shape), name, friction
        )

    def layout(self, poses: Floats) -> Floats:
        """Return poses (n, 7) as positions of the plant: qw qx qy qz x y z of each body."""
        positions = np.empty(7 * len(poses))
        positions[self._starts[:, None] + np.arange(7)] = poses[:, [6, 3, 4, 5, 0, 1, 2]]
        return positions

    def set_poses(self, positions: Floats) -> None:
        """Pose all bodies."""
        self._plant.SetPositions(self._context, positions)

    def _penetration(self) -> int:
        pairs = self._query.ComputePointPairPenetration()
        return len(np.array([pair.depth for pair in pairs]))

    def _candidates(self) -> int:
        return len(self._query.FindCollisionCandidates())

    def _distances(self, most: float) -> int:
        pairs = self._query.ComputeSignedDistancePairwiseClosestPoints(most)
        return len(np.array([pair.distance for pair in pairs]))

    def _to_points(self) -> int:
        ask = self._query.ComputeSignedDistanceToPoint
        return len(np.array([found.distance for p_WQ in self._points for found in ask(p_WQ)]))

    def _has_collisions(self) -> int:
        return int(self._query.HasCollisions())
