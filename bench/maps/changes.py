"""What it takes to change some cells of a map that is in a scene, beside a map made whole."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from bench.maps.packing import Floats
from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    OccupiedCells,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.sensed_maps import Cells

_RESOLUTION = 0.02  # [m]
_TURNS = 9
_STEPS = 'keys', 'shape', 'tree', 'scene', 'query'


def run(counts: list[int], changes: list[int]) -> None:
    """Print the median times of the processor [ms] of each step."""
    rng = np.random.default_rng(0)
    for count in counts:
        cells = _cells(rng, count)
        scene = _Scene(cells)
        print(f'{len(cells)} cells, ms for ' + ', '.join(_STEPS) + ', all')
        whole = partial(_cells, rng, count)
        _tell('made whole', [scene.put(whole)[1] for _ in range(_TURNS)])
        for change in changes:
            times = []
            for _ in range(_TURNS):
                gone = Cells(_RESOLUTION, np.sort(rng.choice(cells.packed, change, replace=False)))
                new = _cells(rng, change)
                cells, seconds = scene.put(partial(cells.changed, new, gone))
                times.append(seconds)
            _tell(f'{change} added, {change} removed', times)


def _cells(rng: np.random.Generator, count: int) -> Cells:
    """Return cells around the origin, of which a tenth of the room is full."""
    half = int(np.ceil((10.0 * count) ** (1.0 / 3.0) / 2.0))
    return Cells.of_keys(rng.integers(-half, half, (count, 3)), _RESOLUTION)


class _Scene:
    """A ball beside a map."""

    def __init__(self, cells: Cells) -> None:
        self._graph = SceneGraph()
        self._source = self._graph.RegisterSource('bench')
        hand = self._graph.RegisterFrame(self._source, GeometryFrame('hand'))
        ball = GeometryInstance(RigidTransform(), Sphere(0.05), 'ball')
        ball.set_proximity_properties(ProximityProperties())
        self._graph.RegisterGeometry(self._source, hand, ball)
        seen = GeometryInstance(
            RigidTransform(), OccupiedCells(_RESOLUTION, cells.centres()), 'map'
        )
        seen.set_proximity_properties(ProximityProperties())
        self._map = self._graph.RegisterAnchoredGeometry(self._source, seen)
        self._context = self._graph.CreateDefaultContext()
        self._pose = FramePoseVector({hand: RigidTransform([0.0, 0.0, 5.0])})
        self._ask()

    def put(self, make: Callable[[], Cells]) -> tuple[Cells, Floats]:
        """Have the scene hold cells that are made now; return them and each step's seconds."""
        clock = [time.process_time()]

        def timed(result: Any) -> Any:
            clock.append(time.process_time())
            return result

        cells = timed(make())
        shape = timed(OccupiedCells(cells.resolution, cells.centres()))
        timed(shape.prepare())
        timed(self._graph.ChangeShape(self._context, self._source, self._map, shape))
        timed(self._ask())
        return cells, np.diff(clock)

    def _ask(self) -> None:
        self._context.UpdateFramePoses(self._pose)
        query = self._graph.get_query_output_port().Eval(self._context)
        query.ComputeSignedDistancePairwiseClosestPoints()


def _tell(name: str, times: list[Floats]) -> None:
    steps = 1e3 * np.median(times, axis=0)
    told = ''.join(f'{value:8.2f}' for value in (*steps, steps.sum()))
    print(f'  {name:28}{told}')
