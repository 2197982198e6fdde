"""RigidTransform: laws, the ways to make one, and what is refused."""

import copy
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles.poses import matrix_of, random_poses

from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix

POSES = random_poses(60, seed=4)
TRANSFORMS = [RigidTransform.FromArray(pose) for pose in POSES]
indices = st.integers(0, len(POSES) - 1)


@given(a=indices, b=indices, c=indices)
def test_group_laws(a, b, c):
    X, Y, Z = TRANSFORMS[a], TRANSFORMS[b], TRANSFORMS[c]
    assert ((X @ Y) @ Z).IsNearlyEqualTo(X @ (Y @ Z), 1e-14)
    assert (X @ X.inverse()).IsNearlyIdentity(1e-14)
    assert (X @ Y).inverse().IsNearlyEqualTo(Y.inverse() @ X.inverse(), 1e-14)
    assert X.InvertAndCompose(Y).IsNearlyEqualTo(X.inverse() @ Y, 1e-14)
    assert (X @ RigidTransform.Identity()).IsExactlyEqualTo(X)


@given(a=indices, b=indices)
def test_agrees_with_matrices(a, b):
    product = TRANSFORMS[a] @ TRANSFORMS[b]
    truth = matrix_of(POSES[a]) @ matrix_of(POSES[b])
    np.testing.assert_allclose(product.GetAsMatrix4(), truth, rtol=0, atol=1e-14)
    np.testing.assert_allclose(product.GetAsMatrix34(), truth[:3], rtol=0, atol=1e-14)


def test_points_are_moved_one_or_many():
    X = RigidTransform(RotationMatrix.MakeZRotation(math.pi / 2), [1, 2, 3])
    np.testing.assert_allclose(X @ [1, 0, 0], [1, 3, 3], rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        X.multiply(np.eye(3)), np.add(X.rotation().matrix(), [[1], [2], [3]])
    )
    assert (X @ np.zeros((3, 0))).shape == (3, 0)
    with pytest.raises(RuntimeError, match=r'shape \(2,\)'):
        X @ [1, 2]


def test_the_ways_to_make_one():
    rpy, p = RollPitchYaw(0.1, 0.2, 0.3), [1.0, 2.0, 3.0]
    R = RotationMatrix(rpy)
    w, x, y, z = R.ToQuaternionAsVector()
    X = RigidTransform(R, p)
    same = [
        RigidTransform(rpy, p),
        RigidTransform(R=R, p=p),
        RigidTransform(rpy=rpy, p=p),
        RigidTransform([w, x, y, z], p),
        RigidTransform(quaternion=[w, x, y, z], p=p),
        RigidTransform(X.GetAsMatrix4()),
        RigidTransform(X.GetAsMatrix34().tolist()),
        RigidTransform(pose=X.GetAsMatrix34()),
        RigidTransform(X),
        RigidTransform(other=X),
        RigidTransform.FromArray([*p, x, y, z, w]),
    ]
    for other in same:
        assert other.IsNearlyEqualTo(X, 2e-15)
    assert RigidTransform().IsExactlyIdentity()
    assert RigidTransform(R).translation().tolist() == [0, 0, 0]
    assert RigidTransform(p) == RigidTransform(p=p) == RigidTransform(np.reshape(p, (3, 1)))
    np.testing.assert_allclose(X.ToArray(), [*p, x, y, z, w], rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (([1, 2],), 'shape'),
        (([1, 2, math.nan],), 'p = .*finite'),
        ((RotationMatrix(), [1, 2]), 'p = '),
        ((np.ones((4, 4)),), 'is not'),
        ((np.eye(4) * 2,), 'is not'),
        ((np.eye(3), [0, 0, 0]), r'RotationMatrix\(R\)'),
        (([2.0, 0, 0, 0], [0, 0, 0]), 'norm 2'),
        ((RotationMatrix(), [0, 0, 0], 1), 'at most'),
        ((np.eye(4), [0, 0, 0]), 'is not'),
    ],
)
def test_what_is_no_pose_is_refused(arguments, words):
    with pytest.raises(RuntimeError, match=words):
        RigidTransform(*arguments)


def test_two_rotations_are_refused():
    with pytest.raises(RuntimeError, match='give one of'):
        RigidTransform(R=RotationMatrix(), rpy=RollPitchYaw(0, 0, 0))
    with pytest.raises(RuntimeError, match='pose'):
        RigidTransform.FromArray([0, 0, 0, 0, 0, 0, 2])


def test_setters_change_one_pose_only():
    X = RigidTransform([1, 2, 3])
    for other in (RigidTransform(X), copy.copy(X), copy.deepcopy(X)):
        other.set_translation([0, 0, 9])
        other.set_rotation(RollPitchYaw(0, 0, 1))
        assert X.translation().tolist() == [1, 2, 3]
        assert X.rotation().IsExactlyIdentity()
        assert other.translation().tolist() == [0, 0, 9]
        other.set(RotationMatrix(), [4, 5, 6])
        assert other == RigidTransform([4, 5, 6])
        assert other.SetIdentity() is other
        assert other.IsExactlyIdentity()
    with pytest.raises(RuntimeError, match='finite'):
        X.set_translation([0, 0, math.inf])
    assert X.IsExactlyEqualTo(RigidTransform([1, 2, 3]))
    with pytest.raises(ValueError, match='read-only'):
        X.translation()[0] = 7.0


def test_comparisons():
    X, Y = RigidTransform([0, 0, 1e-3]), RigidTransform()
    assert X.GetMaximumAbsoluteDifference(Y) == 1e-3
    assert X.GetMaximumAbsoluteTranslationDifference(Y) == 1e-3
    assert X.IsNearlyEqualTo(Y, 1e-3)
    assert not X.IsNearlyEqualTo(Y, 0.9e-3)
    assert not X.IsExactlyEqualTo(Y)
    assert not X.IsNearlyIdentity(1e-4)
    assert X != Y
    assert X != 'X'


def test_prints_as_it_is_made():
    X = TRANSFORMS[1]
    assert eval(repr(X)).IsExactlyEqualTo(X)
