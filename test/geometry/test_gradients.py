"""Gradients of whole results: what moving shows, and an honest word where there are many."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.shape_scenes import PAIRS, SHAPES, MovingPair, lattice_pair, random_pair

from drake_geom_ros.geometry import (
    ArgumentError,
    Box,
    Capsule,
    Cylinder,
    GeometryError,
    HalfSpace,
    SignedDistanceResults,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix

DISTANCES = (0.05, 0.0, -0.01)
places = st.tuples(*3 * [st.integers(-4, 4)])
turns = st.tuples(*2 * [st.integers(0, 23)])
seeds = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize('names', PAIRS, ids='-'.join)
def test_it_foretells_what_moving_does(names):
    rng = np.random.default_rng(sum(map(ord, ''.join(names))))
    unique = 0
    for distance in DISTANCES:
        for _ in range(4):
            pair = random_pair(rng, names, distance)
            found = pair.ask()
            if distance < 0.0:  # on the way in another way out may have become the shortest
                assert found.distance[0] < 0.0
            else:
                assert found.distance[0] == pytest.approx(distance, abs=1e-10)
            if found.is_gradient_unique[0]:
                unique += 1
                assert pair.foretells(found.gradients[0], rng.normal(size=12)), distance
    assert unique >= 10


@settings(max_examples=150)
@given(st.sampled_from(PAIRS), turns, places, seeds)
def test_it_is_said_to_be_unique_only_where_it_is(names, turned, place, seed):
    """Among parallel, concentric and touching features the flag has to be honest."""
    pair = lattice_pair(names, turned, place)
    found = pair.ask()
    if found.is_gradient_unique[0]:
        V = np.random.default_rng(seed).normal(size=12)
        assert pair.foretells(found.gradients[0], V)


def two(A, B, p_WB, *rpy):
    pair = MovingPair(A, B, *2 * [RigidTransform()])
    return pair.place(RigidTransform(), RigidTransform(RollPitchYaw(*(rpy or (0, 0, 0))), p_WB))


CUBE, CAN, PILL = Box(0.2, 0.2, 0.2), Cylinder(0.1, 0.2), Capsule(0.1, 0.4)
QUARTER = np.pi / 2
AMBIGUOUS = {
    'faces that lie parallel': two(CUBE, CUBE, [0, 0, 0.3]),
    'faces that lie parallel, in overlap': two(CUBE, CUBE, [0, 0, 0.15]),
    'edges that lie parallel': two(CUBE, CUBE, [0.3, 0.3, 0.05]),
    'an edge above a face': two(CUBE, CUBE, [0, 0, 0.3], np.pi / 4, 0, 0),
    'a capsule on a face': two(CUBE, Capsule(0.1, 0.1), [0, 0, 0.3], QUARTER, 0, 0),
    'a capsule beside a capsule': two(Capsule(0.1, 0.2), Capsule(0.1, 0.3), [0.3, 0, 0.1]),
    'a cylinder lying on the floor': two(HalfSpace(), CAN, [0, 0, 0.2], QUARTER, 0, 0),
    'a cylinder standing on the floor': two(HalfSpace(), CAN, [0, 0, 0.3]),
    'caps that face each other': two(CAN, Cylinder(0.2, 0.2), [0.05, 0, 0.3]),
    'concentric balls': two(Sphere(0.1), Sphere(0.2), [0, 0, 0]),
    'a ball in the middle of a cube': two(CUBE, Sphere(0.05), [0, 0, 0]),
    'a ball on the axis of a cylinder': two(Cylinder(0.1, 0.6), Sphere(0.05), [0, 0, 0.01]),
    'capsules that cross in their middles': two(PILL, PILL, [0, 0, 0], QUARTER, 0, 0),
    'corners that touch': two(CUBE, CUBE, [0.2, 0.2, 0.2]),
    'a corner that touches an edge': two(CUBE, CUBE, [0, 0.1 + 0.02**0.5, 0.2], 0, 0, np.pi / 4),
}  # fmt: skip


@pytest.mark.parametrize('name', AMBIGUOUS)
def test_where_it_is_one_of_many_it_is_said_and_is_one_of_them(name):
    """It lies between the slopes on either side, as members of the generalised gradient do."""
    pair = AMBIGUOUS[name]
    found = pair.ask()
    assert not found.is_gradient_unique[0]
    gradient, kinks, t = found.gradients[0], 0, 1e-6
    for V in np.random.default_rng(3).normal(size=(12, 12)):
        ahead = (pair.after(V, t).distance[0] - found.distance[0]) / t
        behind = (found.distance[0] - pair.after(V, -t).distance[0]) / t
        kinks += abs(ahead - behind) > 1e-3
        assert min(ahead, behind) - 1e-4 <= gradient @ V <= max(ahead, behind) + 1e-4
    assert kinks >= 6


def test_general_poses_are_not_called_ambiguous():
    for pair in (
        two(CUBE, CUBE, [0, 0, 0.4], 0.5, 0.4, 0.3),
        two(CUBE, Sphere(0.1), [0, 0.02, 0.3]),
        two(Capsule(0.1, 0.2), Capsule(0.1, 0.2), [0.3, 0, 0], QUARTER, 0, 0),
        two(CUBE, Sphere(0.1), [0, 0.02, 0.2]),
        two(Sphere(0.1), Sphere(0.1), [0.2, 0, 0]),
        two(CUBE, Cylinder(0.1, 0.2), [0.01, 0, 0.35], 0.4, 0.2, 0),
    ):
        assert pair.ask().is_gradient_unique[0]


@settings(max_examples=40)
@given(st.sampled_from(PAIRS), st.sampled_from(DISTANCES), seeds)
def test_moving_both_as_one_changes_nothing(names, distance, seed):
    rng = np.random.default_rng(seed)
    pair = random_pair(rng, names, distance)
    w, v = rng.normal(size=(2, 3))
    p_WFs = [X_WF.translation() for X_WF in pair.poses]
    V = np.concatenate([np.append(w, v + np.cross(w, p_WF)) for p_WF in p_WFs])
    assert pair.ask().gradients[0] @ V == pytest.approx(0.0, abs=1e-12)


@settings(max_examples=40)
@given(st.sampled_from(PAIRS), st.sampled_from((0.05, -0.01)), seeds)
def test_it_is_the_same_with_the_roles_exchanged(names, distance, seed):
    pair = random_pair(np.random.default_rng(seed), names, distance)
    offsets = RigidTransform([0.1, -0.2, 0.3]), RigidTransform([0, 0.2, 0])
    other = MovingPair(*(SHAPES[name] for name in names[::-1]), *offsets[::-1])
    found, swapped = pair.ask(), other.place(*pair.poses[::-1]).ask()
    assert found.is_gradient_unique[0] == swapped.is_gradient_unique[0]
    if found.is_gradient_unique[0]:
        np.testing.assert_allclose(
            np.roll(swapped.gradients[0], 6), found.gradients[0], rtol=0, atol=1e-6
        )


def test_answers_from_bounds_vouch_for_none():
    pair = two(Sphere(0.1), CUBE, [0.4, 0.1, 0.0])
    assert pair.ask().is_gradient_unique[0]
    bound = pair.ask(accuracy='bound')
    assert not bound.is_gradient_unique[0]
    assert np.isfinite(bound.gradients).all()


def test_it_agrees_with_the_record_and_belongs_to_frames():
    pair = random_pair(np.random.default_rng(1), ('box', 'ellipsoid'), 0.05)
    found = pair.ask()
    np.testing.assert_allclose(
        found.gradients[0], np.hstack(found[0].gradient()), rtol=0, atol=1e-15
    )
    assert found.frame_id_A.tolist() == [pair.frames[0].get_value()]
    assert found.frame_id_B.tolist() == [pair.frames[1].get_value()]
    for array in (found.gradients, found.is_gradient_unique):
        with pytest.raises(ValueError, match='read-only'):
            array[:] = 0


def test_depths_have_the_opposite_sign_and_results_outlive_the_pose():
    pair = random_pair(np.random.default_rng(2), ('box', 'capsule'), -0.01)
    contacts = pair.query.ComputePointPairPenetration()
    distances = pair.query.ComputeSignedDistancePairwiseClosestPoints()
    pair.place(RigidTransform([5, 5, 5]), RigidTransform(RotationMatrix.MakeXRotation(1.0)))
    assert pair.query.ComputePointPairPenetration() == []
    np.testing.assert_array_equal(contacts.gradients, -distances.gradients)
    J = np.random.default_rng(0).normal(size=(2, 1, 6, 3))
    np.testing.assert_array_equal(contacts.depth_jacobian(*J), -distances.distance_jacobian(*J))
    assert contacts.is_gradient_unique.all()


def test_results_of_many_states_have_none():
    found = random_pair(np.random.default_rng(2), ('box', 'capsule'), 0.05).ask()
    of_states = SignedDistanceResults(found._batch)
    with pytest.raises(GeometryError, match='results of many states'):
        _ = of_states.gradients


def test_no_pairs_have_no_gradients():
    pair = two(Sphere(0.1), CUBE, [5.0, 0.0, 0.0])
    found = pair.query.ComputeSignedDistancePairwiseClosestPoints(0.1)
    assert found.gradients.shape == (0, 12)
    assert found.is_gradient_unique.shape == (0,)
    J = np.zeros((6, 7))
    assert found.distance_jacobian(J, J).shape == (0, 7)
    assert found.jacobian_by_frames({pair.frames[0]: J}).shape == (0, 7)


@pytest.mark.parametrize('J', [np.zeros(6), np.zeros((5, 2)), np.zeros((3, 6, 2))])
def test_jacobians_of_other_shapes_are_refused(J):
    found = random_pair(np.random.default_rng(2), ('box', 'capsule'), 0.05).ask()
    with pytest.raises(ArgumentError, match=r'\(1, 6, n\)'):
        found.distance_jacobian(J, np.zeros((6, 2)))
    with pytest.raises(ArgumentError, match='same ones'):
        found.distance_jacobian(np.zeros((6, 2)), np.zeros((6, 3)))
