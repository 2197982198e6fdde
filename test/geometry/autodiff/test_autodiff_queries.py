"""Queries of AutoDiffXd: every pair of shapes, every answer, and no word where there is none."""

import copy

import numpy as np
import pytest
from oracles.shape_scenes import PAIRS, SHAPES, MovingPair, lattice_pair, random_pair
from scipy.spatial.transform import Rotation

from drake_geom_ros.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue
from drake_geom_ros.geometry import (
    Box,
    Capsule,
    FramePoseVector_,
    GeometryError,
    QueryObject_,
    Sphere,
)
from drake_geom_ros.geometry.autodiff.poses import with_derivatives
from drake_geom_ros.math import RigidTransform, RigidTransform_, RotationMatrix
from truth.bodies.random_bodies import random_directions

VECTORS = ('nhat_BA_W', 'p_ACa', 'p_BCb')


def query_of(pair, Vs, number=AutoDiffXd):
    """Return the query object of a pair whose frames move with V (12, n) for n variables."""
    graph = pair.graph.ToAutoDiffXd()
    context = graph.CreateDefaultContext()
    poses = FramePoseVector_[AutoDiffXd]()
    for frame, X, V in zip(pair.frames, pair.poses, (Vs[:6], Vs[6:]), strict=True):
        poses.set_value(frame, with_derivatives(X, V, number))
    graph.get_source_pose_port(pair.source).FixValue(context, poses)
    return graph.get_query_output_port().Eval(context)


def off(pair, V, rates, names):
    """Return how far rates of vectors are from differences, at the best of three steps."""
    found = []
    for h in (1e-4, 1e-5, 1e-6):
        after, before = pair.after(V, h), pair.after(V, -h)
        steps = [(getattr(after, n) - getattr(before, n))[0] / (2 * h) for n in names]
        found.append(np.abs(np.concatenate(steps) - rates).max() / max(1.0, np.abs(rates).max()))
    return min(found)


@pytest.mark.parametrize('names', PAIRS, ids='-'.join)
def test_all_of_a_pair_foretells_what_moving_does(names):
    rng, told = np.random.default_rng(7), 0
    for distance in (0.05, 0.05, -0.01, -0.01):
        pair = random_pair(rng, names, distance)
        V = rng.normal(size=12)
        query, values = query_of(pair, V[:, None]), pair.ask()
        (found,) = query.ComputeSignedDistancePairwiseClosestPoints()
        assert found.distance.value() == values.distance[0]
        np.testing.assert_allclose(
            found.distance.derivatives(), values.gradients[0] @ V, rtol=0, atol=1e-12
        )
        told += found.is_gradient_unique
        if found.is_gradient_unique:
            rates = np.concatenate([ExtractGradient(getattr(found, n))[:, 0] for n in VECTORS])
            assert off(pair, V, rates, VECTORS) < 1e-4
        if distance < 0.0:
            (contact,) = query.ComputePointPairPenetration()
            assert contact.depth.value() == -values.distance[0]
            np.testing.assert_array_equal(
                contact.depth.derivatives(), -found.distance.derivatives()
            )
            if contact.is_gradient_unique:
                at = ('p_WCa', 'p_WCb')
                rates = np.concatenate([ExtractGradient(getattr(contact, n))[:, 0] for n in at])
                assert off(pair, V, rates, at) < 1e-4
    assert told >= 3


@pytest.mark.parametrize('name', SHAPES)
def test_all_of_a_point_foretells_what_moving_does(name):
    rng, told = np.random.default_rng(len(name)), 0
    pair = MovingPair(SHAPES[name], SHAPES['sphere'])
    V, v_Qs, h = rng.normal(size=12), rng.normal(size=(20, 3)), 1e-5
    p_WQs = [0.1, -0.2, 0.3] + random_directions(rng, 20) * rng.uniform(0.02, 0.4, (20, 1))
    numbers = np.vectorize(lambda p, v: AutoDiffXd(p, [v]), otypes=[object])(p_WQs, v_Qs)
    found = query_of(pair, V[:, None]).ComputeSignedDistanceToPoint(numbers)
    steps = []
    for t in (h, -h):
        pair.place(
            *(RigidTransform(_turned(V[k : k + 3], t), t * V[k + 3 : k + 6]) for k in (0, 6))
        )
        steps.append(pair.query.ComputeSignedDistanceToPoint(p_WQs + t * v_Qs))
    ahead, behind = steps
    for k, each in enumerate(found):
        rate = (ahead.distance[k] - behind.distance[k]) / (2 * h)
        if not each.is_grad_W_unique:
            continue
        try:
            of_N, of_grad = ExtractGradient(each.p_GN)[:, 0], ExtractGradient(each.grad_W)[:, 0]
        except GeometryError:
            continue
        if abs(each.distance.derivatives()[0] - rate) < 1e-6:  # no kink within the step
            told += 1
            for rates, name_of in ((of_N, 'p_GN'), (of_grad, 'grad_W')):
                differences = getattr(ahead, name_of)[k] - getattr(behind, name_of)[k]
                np.testing.assert_allclose(rates, differences / (2 * h), rtol=1e-3, atol=1e-4)
    assert told >= 30


def _turned(w, t):
    return RotationMatrix(Rotation.from_rotvec(t * w).as_matrix())


WITHOUT = {
    'points .* not the only ones': lattice_pair(('box', 'box'), (0, 0), (0, 0, 5)),
    'normal is not the only one': lattice_pair(('box', 'sphere'), (0, 0), (0, 0, 0)),
    'border of an edge or face': lattice_pair(('sphere', 'box'), (0, 0), (1, 1, 5)),
}


@pytest.mark.parametrize('why', WITHOUT)
def test_where_points_have_no_derivatives_asking_says_why(why):
    (found,) = query_of(WITHOUT[why], np.eye(12)).ComputeSignedDistancePairwiseClosestPoints()
    assert found.distance.derivatives().shape == (12,)
    for name in VECTORS:
        with pytest.raises(GeometryError, match=why):
            getattr(found, name)
    with pytest.raises(AttributeError, match='has no depth'):
        _ = found.depth


def test_bounds_have_no_derivatives_of_points():
    pair = random_pair(np.random.default_rng(0), ('box', 'sphere'), 0.05)
    asked = query_of(pair, np.eye(12)).ComputeSignedDistancePairwiseClosestPoints
    (found,) = asked(accuracy='bound')
    with pytest.raises(GeometryError, match='bounds alone'):
        _ = found.nhat_BA_W


def test_constants_have_no_derivatives_and_all_their_points():
    pair = lattice_pair(('box', 'box'), (0, 0), (0, 0, 5))
    query = query_of(pair, np.zeros((12, 0)))
    (found,) = query.ComputeSignedDistancePairwiseClosestPoints()
    assert found.distance.derivatives().size == 0
    np.testing.assert_array_equal(ExtractValue(found.p_ACa)[:, 0], pair.ask().p_ACa[0])


def test_other_questions_are_answered_as_for_floats():
    pair = random_pair(np.random.default_rng(3), ('capsule', 'box'), -0.01)
    query = query_of(pair, np.eye(12))
    assert query.HasCollisions()
    assert query.FindCollisionCandidates() == [tuple(pair.ids)]
    assert query.inspector().num_geometries() == 2
    one = query.ComputeSignedDistancePairClosestPoints(*pair.ids)
    a, b = pair.ids
    older = query.ComputeSignedDistancePairClosestPoints(id_A=b, id_B=a)
    assert one.distance == older.distance == pair.ask().distance[0]
    baked = copy.copy(query)
    for geometry in pair.ids:
        expected = pair.query.X_WG(geometry).GetAsMatrix34()
        for each in (query, baked):
            found = each.GetPoseInWorld(geometry).GetAsMatrix34()
            np.testing.assert_allclose(ExtractValue(found), expected, rtol=0, atol=1e-15)
    moved = ExtractGradient(baked.GetPoseInParent(pair.frames[1]).translation())
    np.testing.assert_array_equal(moved, np.eye(12)[9:])


def test_points_of_floats_stay_and_others_are_of_the_same_variables():
    pair = MovingPair(Sphere(0.1), Capsule(0.1, 0.2))
    query = query_of(pair, np.eye(12))
    (found, _) = query.ComputeSignedDistanceToPoint([1.0, 0.0, 0.0])
    assert found.distance.derivatives().shape == (12,)
    with pytest.raises(GeometryError, match='by 12 variables and p_WQ by 3'):
        query.ComputeSignedDistanceToPoint([AutoDiffXd(1.0, 3, k) for k in range(3)])


def test_it_can_only_be_asked_of_a_scene_of_its_scalar():
    with pytest.raises(GeometryError, match='belongs to no scene'):
        QueryObject_[AutoDiffXd]().HasCollisions()
    pair = MovingPair(Sphere(0.1), Box(1, 1, 1))
    context = pair.graph.ToAutoDiffXd().CreateDefaultContext()
    with pytest.raises(RuntimeError, match='take the port of that one'):
        pair.graph.get_query_output_port().Eval(context)
    with pytest.raises(RuntimeError, match='Eval: context'):
        pair.graph.ToAutoDiffXd().get_query_output_port().Eval(pair.context)
    with pytest.raises(RuntimeError, match=r'RigidTransform_\[AutoDiffXd\]'):
        FramePoseVector_[AutoDiffXd]({pair.frames[0]: RigidTransform()})
    X = RigidTransform_[AutoDiffXd](np.eye(4))
    poses = FramePoseVector_[AutoDiffXd](dict.fromkeys(pair.frames, X))
    with pytest.raises(RuntimeError, match='FixValue: value'):
        pair.graph.get_source_pose_port(pair.source).FixValue(pair.context, poses)
