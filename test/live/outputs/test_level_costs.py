"""Costs of levels for the report: when they are measured, and how they are scaled."""

import numpy as np
import pytest
from live.live_scenes import Topic, live_scene

from drake_geom_ros.live.outputs import level_costs
from drake_geom_ros.live.outputs.level_costs import LevelCosts

TEXT = """
geometries:
- {name: a, shape: {type: sphere, radius: 0.1}}
- {name: b, frame: f, shape: {type: sphere, radius: 0.1}}
- {name: c, frame: f, shape: {type: sphere, radius: 0.1}, pose: {position: [0.1, 0, 0]}}
frames:
- {name: f, pose: {position: [0.3, 0, 0]}}
"""


class Clock:
    now = 0.0

    def perf_counter(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(level_costs, 'time', clock)
    return clock


@pytest.fixture
def live():
    return live_scene(TEXT, lambda: 0.0)


def test_costs_are_those_of_a_pair_times_the_pairs_of_a_second(live, clock, monkeypatch):
    costs = LevelCosts(live, Topic())
    assert costs.last.levels == []
    asked = []

    def cost_of_levels(query, reach, seed):
        asked.append((reach, seed))
        return {'bound': 1e-6, 'exact': 3e-6}, 2

    monkeypatch.setattr('drake_geom_ros.geometry.QueryObject.cost_of_levels', cost_of_levels)
    for _ in range(10):
        costs.count(40, 0.5)
    clock.now += 2.0
    costs.measure()
    assert asked == [(0.5, 1)]
    assert costs.last.levels == ['bound', 'exact']
    np.testing.assert_allclose(costs.last.seconds, [200e-6, 600e-6])
    assert costs.last.samples == 2
    # Only the last second counts, and another sample is taken.
    costs.count(10, 0.5)
    clock.now += 1.0
    costs.measure()
    np.testing.assert_allclose(costs.last.seconds, [10e-6, 30e-6])
    assert asked[1] == (0.5, 2)


def test_nothing_is_measured_for_nobody_or_for_nothing(live, clock, monkeypatch):
    def forbidden(*arguments, **keywords):
        raise AssertionError('measured')

    monkeypatch.setattr('drake_geom_ros.geometry.QueryObject.cost_of_levels', forbidden)
    publisher = Topic()
    costs = LevelCosts(live, publisher)
    clock.now += 1.0
    costs.measure()
    publisher.listeners = 0
    costs.count(5, 0.5)
    clock.now += 1.0
    costs.measure()
    assert (costs.last.levels, costs.last.samples) == ([], 0)


def test_the_live_scene_is_measured_and_not_touched(live, scene):
    costs = LevelCosts(live, Topic())
    scene.query.ComputeSignedDistancePairwiseClosestPoints()
    effects = scene.query.effects()
    costs.count(effects.narrowphase_pairs, 0.5)
    costs.measure()
    assert costs.last.levels == ['bound', '0.01', 'fast', 'balanced', 'exact']
    assert costs.last.samples == effects.narrowphase_pairs == 2
    assert scene.query.effects() == effects
