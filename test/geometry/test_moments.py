"""What results remember of the poses that they are for, when the poses change."""

import threading

import numpy as np
import pytest
from oracles.shape_scenes import random_pair

from drake_geom_ros.geometry import GeometryError, SignedDistanceResults
from drake_geom_ros.geometry.queries.context import state_of
from drake_geom_ros.math import RigidTransform

AWAY = RigidTransform([0.3, 5.0, 5.0]), RigidTransform([2.0, 0.0, 0.1])


@pytest.fixture
def pair():
    return random_pair(np.random.default_rng(7), ('box', 'cylinder'), 0.05)


def told(results):
    return results.gradients.copy(), results.is_gradient_unique.copy()


def test_answers_do_not_change_with_the_poses(pair):
    expected = told(pair.ask())
    point = pair.query.ComputeSignedDistanceToPoint([1.0, 2.0, 3.0])
    of_point = point.gradients.copy()
    late, again = pair.ask(), pair.query.ComputeSignedDistanceToPoint([1.0, 2.0, 3.0])
    pair.place(*AWAY)
    pair.ask()  # poses are taken over by the next query
    for found, wanted in zip(told(late), expected, strict=True):
        np.testing.assert_array_equal(found, wanted)
    np.testing.assert_array_equal(again.gradients, of_point)
    assert not np.array_equal(pair.ask().gradients, expected[0])


def test_arrays_that_somebody_holds_are_never_written_again(pair):
    """A part of one is enough."""
    column, ids = pair.ask().distance, pair.ask().id_A
    expected = column.copy(), ids.copy()
    memory = column.ctypes.data
    for pose in (AWAY, pair.poses, AWAY):
        pair.place(*pose)
        later = pair.ask().distance
        assert later.ctypes.data != memory
    np.testing.assert_array_equal(column, expected[0])
    np.testing.assert_array_equal(ids, expected[1])
    assert later != column


def test_results_of_the_same_poses_share_one_copy(pair):
    world = state_of(pair.context).posed_world()
    held, shared = pair.ask(), pair.ask()
    assert held._kept_poses is shared._kept_poses
    assert held._kept_poses.keep().R_WGs is not world.R_WGs
    pair.place(*AWAY)
    assert pair.ask()._kept_poses is not held._kept_poses


def test_what_was_asked_of_results_that_are_gone_does_not_stay(pair):
    """Nobody holds the results, whose copy of the poses was made and serves no others."""
    before = pair.ask().gradients
    pair.place(*AWAY)
    after = pair.ask().gradients
    assert not np.array_equal(after, before)
    pair.ask()
    assert np.array_equal(pair.ask().gradients, after)


def test_results_that_nobody_holds_cost_no_copy(pair):
    home = pair.poses
    pair.ask()
    pair.place(*AWAY)
    held = pair.ask()
    assert not held._kept_poses.is_kept()
    pair.place(*home)
    assert held._kept_poses.is_kept()


def test_a_copy_of_a_context_shares_no_moment(pair):
    held = pair.ask()
    expected, copy = told(pair.ask()), pair.context.copy()
    assert state_of(copy).posed_world()._kept_poses is None
    pair.place(*AWAY)
    pair.ask()
    np.testing.assert_array_equal(told(held)[0], expected[0])


@pytest.mark.clock
def test_one_thread_asks_while_another_moves(pair):
    """What was read is of one moment, whole, however the poses change beside it."""
    expected = [X.rotation().matrix() for X in pair.poses]
    for _ in range(50):
        results = pair.ask()
        asked = []
        reader = threading.Thread(target=lambda r=results, a=asked: a.append(r._kept_poses.keep()))
        reader.start()
        pair.poses, back = AWAY, pair.poses
        pair.place(*AWAY)
        pair.ask()
        reader.join()
        pair.place(*back)
        np.testing.assert_array_equal(asked[0].R_WGs, expected)


def test_results_of_many_states_have_no_moment(pair):
    with pytest.raises(GeometryError, match='results of many states'):
        SignedDistanceResults(pair.ask()._batch).is_gradient_unique  # noqa: B018
