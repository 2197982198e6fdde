"""Contact surfaces that take long: in blocks, within a time, and without losing a pair."""

import numpy as np
import pytest
from oracles.contact_scenes import Body, query_of

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.geometry._contact_surfaces import asking, blocks
from drake_geom_ros.geometry._contact_surfaces.arrays import LATE, PRESSES
from drake_geom_ros.geometry._contact_surfaces.limits import Limit
from drake_geom_ros.geometry.queries.contact_bodies import NoSurface
from truth.bodies.random_bodies import random_rotation

UPRIGHT = np.eye(3)
BALL = Body('Sphere', (0.25,), 1e6, 0.1)


@pytest.fixture
def short_blocks(monkeypatch):
    """Make blocks so short that most pairs need many."""
    for module in (asking, blocks):
        monkeypatch.setattr(module, 'BLOCK', 100)


def heap(seed):
    """Return a query of bodies of all kinds, some of which have no surface."""
    random = np.random.default_rng(seed)
    bodies = [
        *(Body('Sphere', (0.5,), 1e5, 0.2), Body('Box', (0.5, 0.6, 0.7), 1e5)) * 2,
        *(Body('Sphere', (0.05,), 1e5, 0.1), Body('Capsule', (0.2, 0.5), 0.0, 0.2)) * 2,
    ]
    poses = [(random_rotation(random), 0.4 * random.normal(size=3)) for _ in bodies]
    plane = Body('HalfSpace', (), 1e5, 0.5)
    return query_of([*bodies, plane], [*poses, (UPRIGHT, [0.0, 0.0, -0.2])])[0]


def same(one, other):
    """Hold two answers against each other, to the bit."""
    assert len(one.surfaces) == len(other.surfaces)
    assert all(a.Equal(b) for a, b in zip(one.surfaces, other.surfaces, strict=True))
    np.testing.assert_array_equal(one.surfaces.torques_on_M_Wo_W, other.surfaces.torques_on_M_Wo_W)
    np.testing.assert_array_equal(one.reasons, other.reasons)
    np.testing.assert_array_equal(one.others.id_A, other.others.id_A)


@pytest.mark.parametrize('room', [1, 512])
@pytest.mark.parametrize('seed', range(4))
def test_an_answer_in_many_blocks_is_that_of_one(monkeypatch, seed, room):
    query = heap(seed)
    whole = query.contacts()
    assert len(whole.surfaces) > 5
    for block in (2, 100):
        monkeypatch.setattr(asking, 'FIRST_POLYGONS', room)
        monkeypatch.setattr(asking, 'ROOMS', [])
        for module in (asking, blocks):
            monkeypatch.setattr(module, 'BLOCK', block)
        same(whole, query.contacts())


@pytest.mark.parametrize('seed', range(4))
def test_pairs_that_wait_for_others_come_in_their_order(short_blocks, seed):
    query = heap(seed)
    same(query.contacts(), query.contacts(time_budget=1e6))


def two_pairs(*, fine):
    """Return a query of a pair that takes long, before one that is known at once."""
    ball = BALL._replace(hint=fine)
    bodies = [ball, ball, Body('Box', (0.1, 0.1, 0.1), 1e5), Body('HalfSpace', (), 0.0)]
    places = [(5.0, 0.0, 5.0), (5.03, 0.02, 5.1), (0.0, 0.0, 0.04), (0.0, 0.0, 0.0)]
    query, ids, _ = query_of(bodies, [(UPRIGHT, np.array(place)) for place in places])
    return query, [id.get_value() for id in ids]


def test_a_pair_that_takes_too_long_takes_no_time_from_others(monkeypatch):
    query, _ = two_pairs(fine=0.05)
    for module in (asking, blocks):
        monkeypatch.setattr(module, 'BLOCK', 1000)
    world, pairs = query._candidates()
    posed = query._state.posed_bodies(world)
    assert pairs.tolist() == [[0, 1], [2, 3]]
    limited = asking.surfaces_of(posed, pairs, Limit(steps=5000))
    assert limited.states.tolist() == [LATE, PRESSES]
    assert limited.left == 1
    whole = asking.surfaces_of(posed, pairs)
    np.testing.assert_array_equal(limited.surfaces().sums[0], whole.surfaces().sums[1])


def test_a_pair_that_there_is_no_time_for_is_named_with_its_depth(monkeypatch):
    query, ids = two_pairs(fine=0.05)
    assert (len(query.contacts().surfaces), len(query.contacts().others)) == (2, 0)
    for module in (asking, blocks):
        monkeypatch.setattr(module, 'BLOCK', 10)
    for limit in ({'time_budget': 1e-9}, {'at_once': True}):
        hurried = query.contacts(**limit)
        assert hurried.late() == 2
        assert hurried.reasons.tolist() == [NoSurface.OUT_OF_TIME] * 2
        assert hurried.others.id_A.tolist() == ids[::2]
        assert hurried.others.depth[0] > 0.3


def test_what_nobody_waits_for_ends(short_blocks):
    query, _ = two_pairs(fine=0.1)
    asked = []

    def must_stop():
        asked.append(True)
        return len(asked) == 3

    stopped = query.contacts(must_stop=must_stop)
    assert len(asked) == 3
    assert stopped.late() == 2
    assert len(stopped.surfaces) == 0


def test_two_balls_of_32768_tetrahedra_end_within_a_time_budget():
    query, ids = two_pairs(fine=0.007)
    hurried = query.contacts(time_budget=0.01)
    assert hurried.reasons.tolist() == [NoSurface.OUT_OF_TIME]
    assert hurried.surfaces.id_M.tolist() == ids[2:3]


def test_a_time_budget_is_no_negative_number():
    query, _ = two_pairs(fine=0.5)
    for seconds in (-1.0, float('nan')):
        with pytest.raises(ArgumentError, match='time_budget'):
            query.contacts(time_budget=seconds)
