"""pydrake's side of ``bench.batches``: a plant of the same URDF, its loop and its checker."""

from __future__ import annotations

from typing import Any

import numpy as np
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.common import Parallelism
from pydrake.geometry import CollisionFilterDeclaration, GeometrySet
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import MinimumDistanceLowerBoundConstraint
from pydrake.multibody.plant import CoulombFriction
from pydrake.planning import RobotDiagramBuilder, SceneGraphCollisionChecker

from truth.peers.pydrake_peer import drake_shape

Name = tuple[str, str, str]


class DrakeSide:
    """Two arms, welded where the scene file puts them, and everything else on the world.

    Collisions are asked of its checker, ``CheckConfigsCollisionFree``.
    """

    name = 'pydrake'

    def __init__(self, ours: Any) -> None:
        builder = RobotDiagramBuilder(time_step=0.0)
        self._plant = builder.plant()
        self._arms: dict[str, Any] = {}
        parser = builder.parser()
        parser.SetAutoRenaming(True)
        robots = ours.loaded.robots.items()
        package = next(iter(robots))[1].urdf.parents[3]
        parser.package_map().Add('example-robot-data', str(package))
        for name, robot in robots:
            (arm,) = parser.AddModels(str(robot.urdf))
            X_WB = RigidTransform(robot.X_WB.GetAsMatrix4())
            foot = self._plant.GetFrameByName('panda_link0', arm)
            self._plant.WeldFrames(self._plant.world_frame(), foot, X_WB)
            self._arms[name] = arm
        self._names: dict[Any, Name] = {}
        self._register(ours)
        self._plant.Finalize()
        self._name_links(ours)
        self._diagram_builder = builder
        self._scene_graph = builder.scene_graph()
        self._built: Any = None
        self._columns = self._layout(ours)

    def _register(self, ours: Any) -> None:
        """Register what stands still on the world body."""
        inspector, world = ours.scene_graph.model_inspector(), self._plant.world_body()
        friction = CoulombFriction(1.0, 1.0)
        for name, X in ours.standing_poses().items():
            shape = drake_shape(inspector.GetShape(ours.loaded.geometries[name]))
            X_WG = RigidTransform(X.GetAsMatrix4())
            new = self._plant.RegisterCollisionGeometry(
                world, X_WG, shape, '_'.join(name), friction
            )
            self._names[new] = name

    def _name_links(self, ours: Any) -> None:
        """Call the arms' geometries as ours, which come in the order of the URDF too."""
        ordered: dict[tuple[str, str], list[Name]] = {}
        for source, link, name in ours.loaded.geometries:
            ordered.setdefault((source, link), []).append((source, link, name))
        for source, arm in self._arms.items():
            for index in self._plant.GetBodyIndices(arm):
                body = self._plant.get_body(index)
                ids = self._plant.GetCollisionGeometriesForBody(body)
                own = ordered.get((source, body.name()), [])
                self._names.update(zip(ids, own, strict=True))

    def _layout(self, ours: Any) -> list[int]:
        """Return which column of a state each position of the plant takes."""
        columns = [0] * self._plant.num_positions()
        for source, arm in self._arms.items():
            for index in self._plant.GetJointIndices(arm):
                joint = self._plant.get_joint(index)
                if joint.num_positions() == 1:
                    name = joint.name().replace('panda_finger_joint2', 'panda_finger_joint1')
                    columns[joint.position_start()] = ours.joints.names.index(f'{source}::{name}')
        return columns

    def pairs(self) -> set[frozenset[Name]]:
        """Return the unfiltered pairs."""
        found = self._scene_graph.model_inspector().GetCollisionCandidates()
        return {frozenset((self._names[a], self._names[b])) for a, b in found}

    def keep_only(self, pairs: set[frozenset[Name]]) -> None:
        """Filter what the other library filters, then build."""
        ids = {name: id for id, name in self._names.items()}
        manager = self._scene_graph.collision_filter_manager()
        for pair in self.pairs() - pairs:
            a, b = (GeometrySet([ids[name]]) for name in pair)
            manager.Apply(CollisionFilterDeclaration().ExcludeBetween(a, b))
        self._inspected = self.pairs()
        self.pairs = lambda: self._inspected  # type: ignore[method-assign]
        diagram = self._diagram_builder.Build()
        self._context = diagram.CreateDefaultContext()
        self._port = diagram.scene_graph().get_query_output_port()
        self._own = diagram.mutable_plant_context(self._context)
        self._query_context = diagram.mutable_scene_graph_context(self._context)
        self._diagram = diagram
        self._checker = SceneGraphCollisionChecker(
            model=diagram,
            robot_model_instances=list(self._arms.values()),
            edge_step_size=0.1,
        )

    def least(self, states: np.ndarray) -> np.ndarray:
        """Return the least signed distance [m] of each state, by a loop over one context."""
        found = np.empty(len(states))
        for k, q in enumerate(states[:, self._columns]):
            self._plant.SetPositions(self._own, q)
            query = self._port.Eval(self._query_context)
            pairs = query.ComputeSignedDistancePairwiseClosestPoints()
            found[k] = min(pair.distance for pair in pairs)
        return found

    def collisions(self, states: np.ndarray) -> np.ndarray:
        """Return which states collide."""
        configurations = list(states[:, self._columns])
        free = self._checker.CheckConfigsCollisionFree(configurations, Parallelism(False))
        return ~np.array(free, dtype=bool)

    def each(self, states: np.ndarray) -> np.ndarray:
        """Return which states are free, each asked about alone."""
        free = self._checker.CheckConfigCollisionFree
        return np.array([free(q) for q in states[:, self._columns]], dtype=bool)

    def minimum_distance(self, bound: float, offset: float) -> Any:
        """Return its constraint, from joint values (n,) to a value and its derivatives (n,)."""
        constraint = MinimumDistanceLowerBoundConstraint(
            self._plant, bound, self._own, influence_distance_offset=offset
        )
        followers = np.zeros((len(self._columns), max(self._columns) + 1))
        followers[np.arange(len(self._columns)), self._columns] = 1.0

        def evaluate(q: np.ndarray) -> tuple[float, np.ndarray]:
            values = InitializeAutoDiff(followers @ q, gradient=followers).ravel()
            (output,) = constraint.Eval(values)
            return output.value(), output.derivatives()

        return evaluate

    def distances_to_points(self, state: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return the least signed distance [m] of all geometries to each point (m, 3)."""
        self._plant.SetPositions(self._own, state[self._columns])
        query = self._port.Eval(self._query_context)
        answers = (query.ComputeSignedDistanceToPoint(point) for point in points)
        return np.array([min(each.distance for each in answer) for answer in answers])

    def edge_is_free(self, path: np.ndarray, steps: int) -> bool:
        """Return whether all of so many steps of an edge (2, 16) are free."""
        first, last = path[:, self._columns]
        way = self._checker.ComputeConfigurationDistance(first, last)
        self._checker.set_edge_step_size(max(way / steps, 1e-9))
        return bool(self._checker.CheckEdgeCollisionFree(first, last))
