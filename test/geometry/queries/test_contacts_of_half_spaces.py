"""Two half spaces that overlap have no surface, no penetration, and never look free."""

import math

import numpy as np
import pytest
from batch.test_contacts import COMPLIANT, NEITHER, RIGID, Pressing
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.contact_scenes import Body, query_of

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    GeometryError,
    GeometrySet,
    HalfSpace,
    Sphere,
)
from drake_geom_ros.geometry.queries.contact_bodies import NoSurface
from truth.bodies.random_bodies import random_rotation

UPRIGHT = np.eye(3)
OVERTURNED = np.diag([1.0, -1.0, -1.0])
SOFT, HARD, BARE = (Body('HalfSpace', (), modulus, 0.1) for modulus in (1e6, 0.0, None))


def tilted(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])


def contacts(second, pose, first=SOFT):
    return query_of([first, second], [(UPRIGHT, [0, 0, 0]), pose])[0].contacts()


OVERLAPPING = {
    'one in the other': (UPRIGHT, [0, 0, -1.0]),
    'crossing': (tilted(1.0), [0, 0, 9.0]),
    'crossing far away': (tilted(math.pi - 1e-12), [0, 0, 1.0]),
    'opposed': (OVERTURNED, [5, 0, -0.1]),
    'touching': (OVERTURNED, [5, 0, 0.0]),
}


@pytest.mark.parametrize('pose', OVERLAPPING.values(), ids=OVERLAPPING)
@pytest.mark.parametrize('pair', [(SOFT, SOFT), (SOFT, HARD), (HARD, HARD), (SOFT, BARE)])
def test_they_are_refused_as_in_pydrake(pair, pose):
    query, *_ = query_of(pair, [(UPRIGHT, [0, 0, 0]), pose])
    for ask in (query.ComputeContactSurfaces, query.ComputeContactSurfacesWithFallback):
        with pytest.raises(GeometryError, match=r'both are half spaces.*Filter the pair\.$'):
            ask()
    surfaces, others, reasons = query.contacts()
    assert (len(surfaces), reasons.tolist()) == (0, [NoSurface.HALF_SPACES])
    assert others.depth.tolist() == [math.inf]
    assert np.isnan(others.p_WCa).all()


def test_opposed_ones_are_free_where_they_are_apart():
    for R in (OVERTURNED, tilted(math.pi)):
        query, *_ = query_of([SOFT, HARD], [(UPRIGHT, [0, 0, 0]), (R, [5, 0, 0.1])])
        assert len(query.ComputeContactSurfaces()) == 0
        assert query.ComputeContactSurfacesWithFallback()[1] == []


def test_nobody_claims_how_deep_opposed_ones_are():
    for pose, bound in ((OVERLAPPING['opposed'], math.inf), (OVERLAPPING['crossing'], 0.0)):
        assert contacts(HARD, pose).others.error_bound.tolist() == [bound]


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32), st.floats(1e-9, 1e3), st.floats(0.0, 1e3))
def test_turned_together_the_gap_decides(seed, gap, aside):
    R = random_rotation(np.random.default_rng(seed))
    for height, count in ((gap, 0), (-gap, 1)):
        poses = [(R, [0, 0, 0]), (R @ OVERTURNED, R @ [aside * gap, 0, height])]
        query, *_ = query_of([SOFT, HARD], poses)
        assert len(query.contacts().others) == count


def test_they_stand_among_other_pairs_by_their_ids():
    bodies = [SOFT, Body('Sphere', (0.5,), None), HARD, Body('Sphere', (0.3,), 1e5, 0.1)]
    poses = [(UPRIGHT, [0, 0, 0]), (UPRIGHT, [0, 0, 0]), (tilted(1.0), [0, 0, 0])]
    query, ids, _ = query_of(bodies, [*poses, (UPRIGHT, [0, 0, 50.0])])
    others, reasons = query.contacts()[1:]
    pairs = list(zip(others.id_A.tolist(), others.id_B.tolist(), strict=True))
    assert pairs == sorted(pairs)
    at = pairs.index((ids[0].get_value(), ids[2].get_value()))
    assert reasons[at] == NoSurface.HALF_SPACES
    assert list(reasons).count(NoSurface.HALF_SPACES) == 1
    assert len(reasons) > 2


def test_filters_leave_them_out_and_later_ones_too():
    query, ids, (scene, context) = query_of([SOFT, HARD], [(UPRIGHT, [0, 0, 0])] * 2)
    assert len(query.contacts().others) == 1
    both = GeometrySet(ids)
    manager = scene.collision_filter_manager(context)
    manager.Apply(CollisionFilterDeclaration().ExcludeWithin(both))
    assert len(query.ComputeContactSurfaces()) == len(query.contacts().others) == 0
    manager.Apply(CollisionFilterDeclaration().AllowWithin(both))
    assert len(query.contacts().others) == 1
    nobody = np.zeros((2, 2), dtype=bool)
    assert len(query.narrowed(nobody).contacts().others) == 0


@pytest.mark.parametrize('padding', [0.0, 0.05])
def test_batches_tell_what_contexts_do(padding):
    kinds = [(HalfSpace(), COMPLIANT), (HalfSpace(), RIGID), (Sphere(0.3), COMPLIANT)]
    kinds += [(HalfSpace(), NEITHER), (Sphere(0.2), NEITHER)]
    scene = Pressing(kinds, padding)
    states = scene.states(np.random.default_rng(2), 12, 0.5)
    states[0, 3] = states[0, 1] = [0, 0, 0.08, 1, 0, 0, 0]
    states[0, 0] = [0, 0, 0, 0, 0, 0, 1]
    found = scene.evaluated(states)
    for s, poses in enumerate(states):
        _, others, why = scene.contacts(poses)
        rows = slice(*found.point_offsets[s : s + 2])
        for name in ('id_A', 'id_B', 'depth', 'error_bound'):
            assert getattr(found, name)[rows].tobytes() == getattr(others, name).tobytes(), name
        assert found.reason[rows].tolist() == why.tolist()
        planes = why.tolist().count(NoSurface.HALF_SPACES)
        # The padding of opposed planes closes their gap.
        assert planes == 3 or (s == 0 and planes == (1 if padding == 0.0 else 3))
    two = Pressing(kinds[:2])
    found = two.evaluated(np.array([[[0.0, 0, 0, 0, 0, 0, 1]] * 2]))
    with pytest.raises(GeometryError, match='overlap and have no surface: both are half spaces'):
        found.total_areas()
