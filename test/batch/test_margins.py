"""Collisions with a margin: False only where every pair is certified to be farther apart."""

import math
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from batch.floating_bodies import Floating
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.batch import WANTS, evaluate
from drake_geom_ros.geometry import ACCURACY_LEVELS, ArgumentError, PoseError, Sphere

MARGINS = (0.0, 0.01, 0.05, 0.3)


@pytest.fixture(scope='module')
def balls():
    """Return two balls that are 5 mm apart, and poses of them."""
    poses = np.zeros((1, 2, 7))
    poses[0, 1, 0], poses[..., 6] = 0.205, 1.0
    return Floating([Sphere(0.1), Sphere(0.1)]), poses


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
def test_what_is_within_the_margin_collides(balls, accuracy):
    bodies, poses = balls

    def collides(**how):
        (found,) = evaluate(bodies.graph, bodies.ids, poses, 'collision', accuracy=accuracy, **how)
        return bool(found)

    assert collides(max_distance=0.01)
    assert collides(max_distance=0.00500001)
    assert not collides(max_distance=0.00499999)
    assert not collides(max_distance=0.0)
    assert not collides()
    assert not collides(max_distance=math.inf)


@pytest.mark.parametrize('accuracy', ACCURACY_LEVELS)
@settings(max_examples=10, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    bodies=st.integers(2, 8),
    spread=st.sampled_from([0.5, 1.0, 3.0]),
)
def test_it_is_what_the_lower_bounds_of_all_pairs_say(accuracy, seed, bodies, spread):
    rng = np.random.default_rng(seed)
    scene = Floating.random(rng, bodies)
    asked = {'frame_ids': scene.ids, 'poses': scene.states(rng, 20, spread), 'accuracy': accuracy}
    every = evaluate(scene.graph, want='within', **asked)
    spans = zip(every.offsets[:-1], every.offsets[1:], strict=True)
    ends = every.distance - every.error_bound
    least = np.array([ends[first:last].min() for first, last in spans])
    before = evaluate(scene.graph, want='collision', **asked)
    for margin in MARGINS:
        found = evaluate(scene.graph, want='collision', max_distance=margin, **asked)
        np.testing.assert_array_equal(found, least <= margin)
        assert (found | ~before).all()  # a wider one frees no state
        before = found


@pytest.mark.processes
@pytest.mark.parametrize('margin', MARGINS)
def test_threads_processes_and_order_change_no_answer(margin):
    rng = np.random.default_rng(2)
    bodies = Floating.random(rng, 5)
    poses = bodies.states(rng, 90, 2.0)
    asked = {'frame_ids': bodies.ids, 'want': 'collision', 'max_distance': margin}
    once = evaluate(bodies.graph, poses=poses, threads=1, block_size=90, **asked)
    assert 0 < once.sum() < len(once)
    for threads, block_size in ((1, 1), (2, 7), (3, 89)):
        how = {'threads': threads, 'block_size': block_size}
        np.testing.assert_array_equal(evaluate(bodies.graph, poses=poses, **how, **asked), once)
    back = evaluate(bodies.graph, poses=poses[::-1], **asked)
    np.testing.assert_array_equal(back[::-1], once)
    if margin == 0.05:
        with ProcessPoolExecutor(1, mp_context=get_context('spawn')) as executor:
            found = evaluate(bodies.graph, poses=poses, executor=executor, **asked)
        np.testing.assert_array_equal(found, once)


@pytest.mark.parametrize('margin', [-1e-9, -0.01, -math.inf, math.nan])
def test_what_is_no_margin_is_refused(balls, margin):
    bodies, poses = balls
    with pytest.raises(ArgumentError, match='max_distance'):
        evaluate(bodies.graph, bodies.ids, poses, 'collision', max_distance=margin)


def test_numbers_of_threads_and_states_that_are_none_are_refused(balls):
    bodies, poses = balls
    for how in ({'threads': -1}, {'block_size': -5}):
        with pytest.raises(ArgumentError, match='must be >= 0'):
            evaluate(bodies.graph, bodies.ids, poses, 'collision', **how)


@pytest.mark.parametrize('want', WANTS)
def test_a_frame_that_was_never_posed_is_named_whatever_is_asked(balls, want):
    bodies, poses = balls
    points = {'points': [[0.0, 0.0, 0.0]]} if want == 'points' else {}
    with pytest.raises(PoseError, match="which they do not name, never had a pose: 'f1'"):
        evaluate(bodies.graph, bodies.ids[:1], poses[:, :1], want, **points)
