"""Closing speeds and times to contact: what motion shows, and nothing where nobody knows."""

import numpy as np
import pytest
from oracles.shape_scenes import PAIRS, MovingPair, random_pair

from drake_geom_ros.geometry import ArgumentError, Box, Sphere, closing_speeds
from drake_geom_ros.math import RigidTransform


@pytest.mark.parametrize('names', PAIRS[::4], ids='-'.join)
def test_it_is_the_speed_at_which_the_distance_shrinks(names):
    rng, h = np.random.default_rng(11), 1e-6
    pair = random_pair(rng, names, 0.05)
    V = rng.normal(size=12)
    found = closing_speeds(pair.ask(), dict(zip(pair.frames, (V[:6], V[6:]), strict=True)))
    rate = (pair.after(V, -h).distance[0] - pair.after(V, h).distance[0]) / (2 * h)
    assert found.known.all()
    assert found.speed[0] == pytest.approx(rate, abs=1e-5)


def test_balls_that_meet_do_so_after_that_time():
    pair = MovingPair(Sphere(0.1), Sphere(0.2), *2 * [RigidTransform()])
    pair.place(RigidTransform(), RigidTransform([2.0, 0.0, 0.0]))
    a, b = pair.frames
    towards = closing_speeds(pair.ask(), {a: [0, 0, 9, 0.5, 0, 0], b: [0, 0, 0, -0.35, 1.0, 0]})
    assert towards.speed.tolist() == [pytest.approx(0.85)]
    assert towards.time_to_contact.tolist() == [pytest.approx(2.0)]
    apart = closing_speeds(pair.ask(), {a: np.zeros(6), b: [0, 0, 0, 1, 0, 0]})
    assert (apart.speed[0], apart.time_to_contact[0]) == (-1.0, np.inf)
    pair.place(RigidTransform(), RigidTransform([0.25, 0.0, 0.0]))
    within = closing_speeds(pair.ask(), {a: np.zeros(6), b: [0, 0, 0, 1, 0, 0]})
    assert (within.speed[0], within.time_to_contact[0]) == (-1.0, 0.0)


def test_without_a_twist_nothing_is_said():
    pair = MovingPair(Sphere(0.1), Box(0.2, 0.2, 0.2))
    for V_WFs in ({}, {pair.frames[0]: np.zeros(6)}):
        found = closing_speeds(pair.ask(), V_WFs)
        assert not found.known.any()
        assert np.isnan([found.speed[0], found.time_to_contact[0]]).all()
    far = pair.query.ComputeSignedDistancePairwiseClosestPoints(-5.0)
    assert len(closing_speeds(far, {}).speed) == 0


@pytest.mark.parametrize('twist', [np.zeros(5), [0, 0, 0, np.nan, 0, 0], np.zeros((6, 1))])
def test_what_is_no_twist_is_refused(twist):
    pair = MovingPair(Sphere(0.1), Sphere(0.1))
    with pytest.raises(ArgumentError, match='six finite numbers'):
        closing_speeds(pair.ask(), {pair.frames[0]: twist})


def test_of_overlaps_it_is_how_fast_they_grow():
    pair = random_pair(np.random.default_rng(3), ('box', 'cylinder'), -0.01)
    V = np.random.default_rng(4).normal(size=12)
    twists = dict(zip(pair.frames, (V[:6], V[6:]), strict=True))
    found = closing_speeds(pair.query.ComputePointPairPenetration(), twists)
    same = closing_speeds(pair.ask(), twists)
    assert found.speed.tolist() == same.speed.tolist()
    assert found.time_to_contact.tolist() == same.time_to_contact.tolist() == [0.0]
    assert closing_speeds(pair.query.ComputePointPairPenetration(), {}).known.tolist() == [False]
