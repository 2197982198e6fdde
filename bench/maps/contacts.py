"""Whether a body is in contact with a map, beside how deep it is."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from bench.maps.packing import Floats
from drake_geom_ros.geometry import (
    Box,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    OccupiedCells,
    ProximityProperties,
    QueryObject,
    SceneGraph,
)
from drake_geom_ros.math import RigidTransform

_RESOLUTION = 0.05  # [m]
_BODY = 0.6, 0.5, 1.2  # [m]


def run(count: int, states: int) -> None:
    """Print times of the processor [ms] of a contact and of its depth, in maps of some density."""
    rng = np.random.default_rng(0)
    print('ms: contact alone, median, mean and p99; with depth; ratio of the means; in contact')
    for full in (0.01, 0.1, 0.6):
        half = int(np.ceil((count / full) ** (1.0 / 3.0) / 2.0))
        keys = np.unique(rng.integers(-half, half, (count, 3)), axis=0)
        cells = OccupiedCells(_RESOLUTION, _RESOLUTION * keys)
        places = rng.uniform(-half, half, (states, 3)) * _RESOLUTION
        contact = _Scene(cells, lambda query: query.HasCollisions())
        depth = _Scene(cells, lambda query: len(query.ComputePointPairPenetration()) > 0)
        times = np.empty((2, states))
        found = 0
        for k, place in enumerate(places):
            answers = []
            for row, scene in enumerate((contact, depth)):
                answer, times[row, k] = scene.ask(place)
                answers.append(answer)
            if answers[0] != answers[1]:
                raise RuntimeError(f'a contact at {place} m is {answers[0]} without a depth')
            found += answers[0]
        (alone, deep) = (1e3 * each[1:] for each in times)  # the first looks things up
        print(
            f'{len(keys)} cells, {full:g} full: {_said(alone)}; {_said(deep)}; '
            f'{deep.mean() / alone.mean():.1f}; {found} of {states}'
        )


class _Scene:
    """A box that moves in a map, and one question about it."""

    def __init__(self, cells: OccupiedCells, question: Callable[[QueryObject], bool]) -> None:
        graph = SceneGraph()
        source = graph.RegisterSource('bench')
        self._frame = graph.RegisterFrame(source, GeometryFrame('box'))
        for frame, shape in ((self._frame, Box(*_BODY)), (graph.world_frame_id(), cells)):
            instance = GeometryInstance(RigidTransform(), shape, type(shape).__name__)
            instance.set_proximity_properties(ProximityProperties())
            graph.RegisterGeometry(source, frame, instance)
        self._context: Any = graph.CreateDefaultContext()
        self._query = graph.get_query_output_port().Eval(self._context)
        self._question = question

    def ask(self, place: Floats) -> tuple[bool, float]:
        """Return the answer at a place [m], and the seconds of the processor that it took."""
        poses = np.array([[*place, 0.0, 0.0, 0.0, 1.0]])
        self._context.UpdateFramePoses(FramePoseVector.FromArrays([self._frame], poses))
        start = time.process_time()
        answer = self._question(self._query)
        return answer, time.process_time() - start


def _said(times: Floats) -> str:
    return f'{np.median(times):.3f} {times.mean():.3f} {np.quantile(times, 0.99):.3f}'
