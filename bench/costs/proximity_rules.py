"""What proximity rules add to a cycle: many bodies, none to a thousand rules.

    ./run exec python -m bench.costs.proximity_rules

Balls move 10 mm from cycle to cycle, with 10 ms of sleep in between. A cycle asks for the signed
distances within 0.1 m, and then has rules decided by them. Each rule watches one ball against all
others. Mean, median and 99th percentile without and with rules in microseconds, and their ratio.
"""

from __future__ import annotations

import time

import numpy as np

from drake_geom_ros.geometry import (
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from drake_geom_ros.live.scene.scene_rules import Blind, SceneRules
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.proximity_rules import ProximityRule

BODIES = 1000
RULES = (0, 1, 20, 1000)
CYCLES = 150
REACH, STEP, PAUSE = 0.1, 0.01, 0.01  # [m], [m], [s]
RADIUS, SIDE = 0.05, 1.6  # [m]: some 3000 pairs within reach


class Balls:
    """Balls that walk at random in a cube."""

    def __init__(self) -> None:
        self.graph = SceneGraph()
        source = self.graph.RegisterSource('balls')
        self.frames = []
        for k in range(BODIES):
            self.frames.append(self.graph.RegisterFrame(source, GeometryFrame(f'{k}')))
            ball = GeometryInstance(RigidTransform(), Sphere(RADIUS), 'ball')
            ball.set_proximity_properties(ProximityProperties())
            self.graph.RegisterGeometry(source, self.frames[-1], ball)
        self._rng = np.random.default_rng(1)
        self._p_WFs = self._rng.uniform(0.0, SIDE, (BODIES, 3))
        self.context = self.graph.CreateDefaultContext()
        self.move()

    def move(self) -> None:
        """Go a step in any direction."""
        ways = self._rng.normal(size=(BODIES, 3))
        self._p_WFs += STEP * ways / np.linalg.norm(ways, axis=1, keepdims=True)
        places = zip(self.frames, self._p_WFs, strict=True)
        self.context.UpdateFramePoses(FramePoseVector({f: RigidTransform(p) for f, p in places}))


def rules(count: int) -> list[ProximityRule]:
    """Return rules of one ball each against all others."""
    return [ProximityRule(f'{k}', (f'balls::{k}',), enter=0.01, leave=0.02) for k in range(count)]


def measured(balls: Balls, count: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Return the seconds of cycles without and with rules, and how many pairs were near."""
    query = balls.graph.get_query_output_port().Eval(balls.context)
    watch = SceneRules()
    if count:
        watch.bind(query, 0)
        watch.add(rules(count))
    spent = np.empty((CYCLES, 2))
    nobody = Blind((), ())
    for cycle in range(CYCLES):
        balls.move()
        time.sleep(PAUSE)
        start = time.perf_counter()
        found = query.ComputeSignedDistancePairwiseClosestPoints(REACH)
        between = time.perf_counter()
        if count:
            watch.bind(query, 0)
            watch.decide(between, query, nobody, (found, REACH))
            watch.take_events()
            watch.speed_scale()
        spent[cycle] = between - start, time.perf_counter() - start
    return *spent[10:].T, len(found)


def main() -> None:
    """Print the table."""
    balls = Balls()
    print(f'{BODIES} balls; times in us: mean, median, 99th percentile')
    for count in RULES:
        alone, ruled, pairs = measured(balls, count)
        told = [
            f'{1e6 * t.mean():8.0f} {1e6 * np.median(t):8.0f} {1e6 * np.quantile(t, 0.99):8.0f}'
            for t in (alone, ruled)
        ]
        ratio = ruled.mean() / alone.mean()
        print(f'{count:5d} rules, {pairs} pairs: alone {told[0]}, ruled {told[1]}, {ratio:.2f}')


if __name__ == '__main__':
    main()
