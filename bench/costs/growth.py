"""One change of a large scene and the next answer: kept rows against tables made again.

    ./run exec python -m bench.costs.growth [--geometries 2000 16000] [--turns 11]

A tenth of the bodies moves, on 100 frames; the rest is anchored. Each change is timed with the
query after it (signed distances up to 1 cm), without what that query takes when nothing changed.
``whole`` is the same change with all tables made again, as if too many geometries had changed.
The first change after that copies tables to where they have room to grow; it is timed apart.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from statistics import fmean, median
from unittest.mock import patch

import numpy as np

from drake_geom_ros.geometry import (
    Box,
    CollisionFilterDeclaration,
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraph,
    Shape,
    Sphere,
)
from drake_geom_ros.geometry.queries import world_tables
from drake_geom_ros.math import RigidTransform

FRAMES = 100
REACH = 0.01  # [m] of the query


class Scene:
    """A scene graph with a context that sees its changes, and the changes that are timed."""

    def __init__(self, count: int) -> None:
        self._rng, self._count = np.random.default_rng(count), 0
        self._width = 0.3 * count ** (1 / 3)
        self._graph = SceneGraph()
        self._source = self._graph.RegisterSource('bench')
        frames = [
            self._graph.RegisterFrame(self._source, GeometryFrame(f'frame {k}'))
            for k in range(FRAMES)
        ]
        world = self._graph.world_frame_id()
        self._ids = [self._add(frames[k % FRAMES] if k % 10 == 0 else world) for k in range(count)]
        context = self._graph.CreateSharedContext()
        poses = np.zeros((FRAMES, 7))
        poses[:, :3], poses[:, 6] = self._rng.uniform(-1, 1, (FRAMES, 3)), 1.0
        context.UpdateFramePoses(FramePoseVector.FromArrays(frames, poses))
        self._query = self._graph.get_query_output_port().Eval(context)
        self._mover, self._context, self._poses = frames, context, poses
        self.answer()

    def answer(self) -> None:
        """Ask for the pairs within reach, at new poses."""
        self._poses[:, :3] += self._rng.uniform(-1e-4, 1e-4, (FRAMES, 3))
        self._context.UpdateFramePoses(FramePoseVector.FromArrays(self._mover, self._poses))
        self._query.ComputeSignedDistancePairwiseClosestPoints(REACH)

    def _add(self, frame: FrameId) -> GeometryId:
        self._count += 1
        pose = RigidTransform(self._rng.uniform(-self._width, self._width, 3))
        instance = GeometryInstance(pose, self._shape(), f'body {self._count}')
        instance.set_proximity_properties(ProximityProperties())
        return self._graph.RegisterGeometry(self._source, frame, instance)

    def _shape(self) -> Shape:
        return Sphere(0.05) if self._count % 2 else Box(0.1, 0.1, 0.1)

    def _any(self) -> GeometryId:
        return self._ids[self._rng.integers(len(self._ids))]

    def one_more(self) -> None:
        """Register a geometry."""
        self._ids.append(self._add(self._graph.world_frame_id()))

    def one_less(self) -> None:
        """Remove a geometry."""
        self._graph.RemoveGeometry(self._source, self._ids.pop(self._rng.integers(len(self._ids))))

    def shape(self) -> None:
        """Change the shape of a geometry."""
        self._graph.ChangeShape(self._source, self._any(), Sphere(0.04))

    def role(self) -> None:
        """Remove the role of a geometry, and assign it again."""
        id = self._any()
        self._graph.RemoveRole(self._source, geometry_id=id, role=Role.kProximity)
        self._graph.AssignRole(self._source, id, ProximityProperties(), RoleAssign.kNew)

    def filter(self) -> None:
        """Exclude a pair."""
        pair = GeometrySet([self._any(), self._any()])
        declaration = CollisionFilterDeclaration().ExcludeWithin(pair)
        self._graph.collision_filter_manager().Apply(declaration)


def milliseconds(*calls: Callable[[], None]) -> float:
    """Return the processor time of calls [ms], which other work on the machine hardly changes."""
    start = time.process_time()
    for call in calls:
        call()
    return 1e3 * (time.process_time() - start)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--geometries', type=int, nargs='+', default=[2000, 16000])
    parser.add_argument('--turns', type=int, default=11)
    options = parser.parse_args()
    print('processor time [ms] of a change and the next answer, beyond that of an unchanged scene')
    print(
        f'{"geometries":>10}  {"change":10}'
        + f'{"kept: median, mean, p99":>28}{"first":>9}{"whole":>9}{"whole/kept":>12}'
    )
    for count in options.geometries:
        scene = Scene(count)
        usual = median(milliseconds(scene.answer) for _ in range(101))
        for name in ('one_more', 'one_less', 'shape', 'role', 'filter'):
            change = getattr(scene, name)
            with patch.object(world_tables, 'MUCH', 10 * count):
                whole = [milliseconds(change, scene.answer) - usual for _ in range(options.turns)]
            first = milliseconds(change, scene.answer) - usual
            kept = [milliseconds(change, scene.answer) - usual for _ in range(3 * options.turns)]
            values = ''.join(
                f'{value:9.2f}' for value in (median(kept), fmean(kept), np.quantile(kept, 0.99))
            )
            ratio = median(whole) / median(kept)
            print(
                f'{count:10d}  {name:10}{values:>28}{first:9.2f}{median(whole):9.2f}{ratio:12.1f}'
            )


if __name__ == '__main__':
    main()
