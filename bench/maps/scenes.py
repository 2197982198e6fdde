"""What sensors might see around the two Pandas, as a map of any resolution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.batches.ours import SCENE
from drake_geom_ros.batch import Joints
from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometryId,
    GeometryInstance,
    GeometrySet,
    OccupiedCells,
    ProximityProperties,
    Role,
    SceneGraph,
    SceneGraphContext,
    Shape,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.sensed_maps import Cells

Floats = NDArray[np.float64]

STEP = 0.01  # [m]
_BALLS = 24


def surfaces(step: float, rng: np.random.Generator) -> Floats:
    """Return points (n, 3) [m], no farther apart than a step: walls, a table, a shelf, balls."""
    sheets = [
        sheet(step, (-1.3, 1.3), (-0.95, -0.95), (0.0, 1.5)),
        sheet(step, (-1.3, 1.3), (0.95, 0.95), (0.0, 1.5)),
        sheet(step, (-1.0, 1.0), (-0.7, 0.7), (0.25, 0.25)),
        sheet(step, (-0.9, 0.9), (0.55, 0.95), (1.3, 1.3)),
    ]
    for _ in range(_BALLS):
        middle, radius = rng.uniform((-1.0, -0.5, 0.45), (1.0, 0.5, 1.4)), rng.uniform(0.02, 0.06)
        count = max(8, round(4.0 * np.pi * (2.0 * radius / step) ** 2))
        directions = rng.normal(size=(count, 3))
        sheets.append(middle + radius * directions / np.linalg.norm(directions, axis=1)[:, None])
    return np.concatenate(sheets)


def sheet(step: float, *ranges: tuple[float, float]) -> Floats:
    """Return points (n, 3) [m] of a flat grid, no farther apart than a step."""
    axes = [np.linspace(a, b, 1 + int(np.ceil((b - a) / step))) for a, b in ranges]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)


def seen_cells(resolution: float, seed: int = 0) -> OccupiedCells:
    """Return the surfaces as cells of an octree's grid."""
    points = surfaces(0.5 * resolution, np.random.default_rng(seed))
    return OccupiedCells(resolution, Cells.of_points(points, resolution).centres())


@dataclass
class Arms:
    """Both arms and one map, of which only pairs of a link and the map count."""

    graph: SceneGraph
    context: SceneGraphContext
    joints: Joints
    links: list[GeometryId]
    seen: GeometryId

    @classmethod
    def beside(cls, shape: Shape) -> Arms:
        """Return the arms of the demo beside a map."""
        graph = SceneGraph()
        loaded = load_scene(SCENE.read_text(), graph)
        inspector = graph.model_inspector()
        every = inspector.GetAllGeometryIds(Role.kProximity)
        robots = set(loaded.robots)
        links = [id for (source, _, _), id in loaded.geometries.items() if source in robots]
        others = [id for id in every if id not in set(links)]
        manager = graph.collision_filter_manager()
        declaration = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(every))
        source = graph.RegisterSource('camera')
        instance = GeometryInstance(RigidTransform(), shape, 'seen')
        instance.set_proximity_properties(ProximityProperties())
        seen = graph.RegisterAnchoredGeometry(source, instance)
        manager.Apply(declaration.ExcludeBetween(GeometrySet(others), GeometrySet([seen])))
        context, joints = graph.CreateDefaultContext(), Joints.of(loaded)
        links = [id for id in links if id in set(every)]
        return cls(graph, context, joints, links, seen)

    def states(self, count: int, rng: np.random.Generator) -> Floats:
        """Return poses (count, n, 7) of the links along motions in which they touch no cell.

        From one state to the next no link's origin moves more than STEP, but between two motions.
        """
        low, high = self.joints.lower, self.joints.upper
        found: list[Floats] = []
        while sum(map(len, found)) < count:
            ends = rng.uniform(0.75 * low + 0.25 * high, 0.25 * low + 0.75 * high, (2, len(low)))
            way = 1e-3 * (ends[1] - ends[0])
            first, next_one = self.joints.poses(np.stack([ends[0], ends[0] + way]))
            moved = np.linalg.norm(next_one[:, :3] - first[:, :3], axis=1).max()
            path = self.joints.poses(ends[0] + np.arange(40)[:, None] * (STEP / moved) * way)
            free = [poses for poses in path if not self._touches(poses)]
            found.append(np.array(free).reshape(-1, *path.shape[1:]))
        return np.concatenate(found)[:count]

    def _touches(self, poses: Floats) -> bool:
        self.pose(poses)
        query = self.graph.get_query_output_port().Eval(self.context)
        return bool(query.HasCollisions())

    def pose(self, poses: Floats) -> None:
        """Pose the links."""
        self.context.UpdateFramePoses(FramePoseVector.FromArrays(self.joints.frame_ids, poses))
