"""The least distance of a state and its nearest pairs: by what is certified, at every level."""

import math

import numpy as np
import pytest
from batch.floating_bodies import Floating
from batch.test_evaluation import PAIR_COLUMNS
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.batch import evaluate
from drake_geom_ros.geometry import ACCURACY_LEVELS, Cylinder, Sphere

EXACT_ROUNDING = 1e-12  # [m] of the truth below, which is that of level exact with its own bound


def lower(found):
    """Return the certified lower bounds (k,) [m] of results."""
    return found.distance - found.error_bound


@pytest.fixture(scope='module')
def two_pairs():
    """Return two cylinders 0.02 m deep in each other, far from two balls 0.02 m apart."""
    bodies = Floating([Cylinder(0.1, 2.0), Cylinder(0.1, 2.0), Sphere(0.1), Sphere(0.1)])
    poses = np.zeros((1, 4, 7))
    poses[..., 6] = 1.0
    poses[0, :, 0] = 0.0, 0.18, 50.0, 50.22
    poses[0, 1, 2] = 1.9  # so that the middle of what bounds alone tell is 0.8 m
    return bodies, poses


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
@pytest.mark.parametrize('max_distance', [math.inf, 0.01])
def test_the_pair_that_overlaps_is_the_least_one(two_pairs, accuracy, max_distance):
    bodies, poses = two_pairs
    asked = {'max_distance': max_distance, 'accuracy': accuracy}
    least = evaluate(bodies.graph, bodies.ids, poses, 'least', **asked)
    assert abs(least.distance[0] + 0.02) <= least.error_bound[0]
    assert lower(least)[0] < 0.0
    cylinders = evaluate(bodies.graph, bodies.ids, poses, 'within', accuracy='exact')
    assert least.id_A[0] == cylinders.id_A[0]
    assert least.id_B[0] == cylinders.id_B[0]


def check(bodies, poses, accuracy, max_distance, count):
    """Hold the least and the nearest of states against all pairs, and against the truth."""
    asked = {'frame_ids': bodies.ids, 'poses': poses}
    every = evaluate(bodies.graph, want='within', accuracy=accuracy, **asked)
    truth = evaluate(bodies.graph, want='within', accuracy='exact', **asked)
    asked |= {'max_distance': max_distance, 'accuracy': accuracy}
    least = evaluate(bodies.graph, want='least', **asked)
    nearest = evaluate(bodies.graph, want='nearest', count=count, **asked)
    within = evaluate(bodies.graph, want='within', **asked)
    for k in range(len(poses)):
        rows, some = slice(*every.offsets[k : k + 2]), slice(*nearest.offsets[k : k + 2])
        true, ends = truth.distance[rows], lower(every)[rows]
        bound = truth.error_bound[rows][np.argmin(true)] + EXACT_ROUNDING
        order = np.argsort(ends, kind='stable')
        expected = order[ends[order] <= max_distance][:count]
        for name in PAIR_COLUMNS:
            np.testing.assert_array_equal(
                getattr(nearest, name)[some], getattr(every, name)[rows][expected]
            )
        left_out = np.delete(true, expected)
        if len(expected) < count:  # only what is certified to be farther is left out
            assert (left_out + EXACT_ROUNDING >= min(max_distance, math.inf)).all()
        else:
            assert (left_out + EXACT_ROUNDING >= ends[expected[-1]]).all()
        if len(expected):
            assert least.distance[k] == nearest.distance[some][0]
            assert abs(least.distance[k] - true.min()) <= least.error_bound[k] + bound
        else:
            assert np.isinf(least.distance[k])
            assert true.min() > max_distance - EXACT_ROUNDING
            assert within.offsets[k] == within.offsets[k + 1]


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
@settings(max_examples=15, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    bodies=st.integers(2, 8),
    spread=st.sampled_from([0.3, 1.0, 3.0]),
    max_distance=st.sampled_from([math.inf, 0.3, 0.01, 0.0, -0.05]),
    count=st.sampled_from([1, 2, 5, 100]),
)
def test_it_holds_the_least_of_all_pairs(accuracy, seed, bodies, spread, max_distance, count):
    rng = np.random.default_rng(seed)
    scene = Floating.random(rng, bodies)
    check(scene, scene.states(rng, 12, spread), accuracy, max_distance, count)


@pytest.mark.parametrize('max_distance', [0.05, 0.01, 0.0])
def test_a_state_that_overlaps_never_gets_a_positive_lower_bound(max_distance):
    rng = np.random.default_rng(2)
    bodies = Floating.random(rng, 6)
    poses = bodies.states(rng, 400, 1.0)
    asked = {'frame_ids': bodies.ids, 'poses': poses}
    overlap = evaluate(bodies.graph, want='collision', **asked)
    assert 50 < overlap.sum() < 350
    for accuracy in ACCURACY_LEVELS:
        least = evaluate(
            bodies.graph, want='least', max_distance=max_distance, accuracy=accuracy, **asked
        )
        assert (lower(least)[overlap] < 0.0).all()
