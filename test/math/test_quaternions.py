"""Quaternions and angle-axes: what they are made of, and the rotation they stand for."""

import math

import numpy as np
import pytest

from drake_geom_ros.common.eigen_geometry import AngleAxis, Quaternion
from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix

R_AB = RollPitchYaw(0.3, -1.2, 2.5).ToRotationMatrix()
HALF = math.sqrt(0.5)


def test_a_quaternion_is_made_in_every_way():
    made = [
        Quaternion(HALF, HALF, 0, 0),
        Quaternion(w=HALF, x=HALF, y=0, z=0),
        Quaternion([HALF, HALF, 0, 0]),
        Quaternion(wxyz=[HALF, HALF, 0, 0]),
        Quaternion(rotation=RotationMatrix.MakeXRotation(math.pi / 2).matrix()),
        Quaternion(other=Quaternion(HALF, HALF, 0, 0)),
    ]
    for q in made:
        np.testing.assert_allclose(q.wxyz(), [HALF, HALF, 0, 0], rtol=0, atol=2e-16)
    assert Quaternion().wxyz().tolist() == Quaternion.Identity().wxyz().tolist() == [1, 0, 0, 0]


def test_the_numbers_of_a_quaternion():
    q = Quaternion(0.5, -0.5, 0.5, -0.5)
    assert (q.w(), q.x(), q.y(), q.z()) == (0.5, -0.5, 0.5, -0.5)
    assert q.xyz().tolist() == [-0.5, 0.5, -0.5]
    assert q.conjugate().wxyz().tolist() == q.inverse().wxyz().tolist() == [0.5, 0.5, -0.5, 0.5]
    assert repr(eval(repr(q))) == repr(q)


@pytest.mark.parametrize('angle', [0.0, 1e-9, 0.4, math.pi])
def test_angle_and_axis_come_back(angle):
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    given = AngleAxis(angle, axis)
    back = AngleAxis(rotation=given.rotation())
    assert back.angle() == pytest.approx(angle, abs=1e-15)
    if angle:
        turned = back.axis() if back.axis() @ axis > 0 else -back.axis()
        np.testing.assert_allclose(turned, axis, rtol=0, atol=1e-7 if angle < 1e-3 else 1e-14)
    np.testing.assert_allclose(given.inverse().rotation(), given.rotation().T, rtol=0, atol=1e-15)
    assert AngleAxis(quaternion=Quaternion(-1, 0, 0, 0)).angle() == 0.0


def test_rotation_matrices_give_and_take_them():
    for made in (
        RotationMatrix(R_AB.ToQuaternion()),
        RotationMatrix(quaternion=R_AB.ToQuaternion()),
        RotationMatrix(R_AB.ToAngleAxis()),
        RotationMatrix(theta_lambda=R_AB.ToAngleAxis()),
        RotationMatrix(quaternion=R_AB.ToRollPitchYaw().ToQuaternion()),
    ):
        np.testing.assert_allclose(made.matrix(), R_AB.matrix(), rtol=0, atol=1e-15)
    assert 0 <= R_AB.ToAngleAxis().angle() <= math.pi
    assert AngleAxis().angle() == AngleAxis.Identity().angle() == 0.0
    assert AngleAxis(other=AngleAxis(2.0, [0, 1, 0])).axis().tolist() == [0, 1, 0]


def test_poses_take_them():
    theta_lambda = R_AB.ToAngleAxis()
    expected = RigidTransform(R_AB, [1, 2, 3])
    pose = RigidTransform(p=[1, 2, 3])
    for given in ({'theta_lambda': theta_lambda}, {'quaternion': R_AB.ToQuaternion()}):
        assert RigidTransform(p=[1, 2, 3], **given).IsNearlyEqualTo(expected, 1e-15)
        pose.set_rotation(**given)
        assert pose.IsNearlyEqualTo(expected, 1e-15)
    pose.set_rotation(rpy=RollPitchYaw(R_AB))
    assert pose.IsNearlyEqualTo(expected, 1e-15)
    assert RigidTransform(theta_lambda, [1, 2, 3]).IsNearlyEqualTo(expected, 1e-15)
    with pytest.raises(RuntimeError, match='set_rotation: give one of'):
        pose.set_rotation()
    with pytest.raises(RuntimeError, match='give one of'):
        RotationMatrix(R_AB, theta_lambda=theta_lambda)


@pytest.mark.parametrize(
    ('make', 'words'),
    [
        (lambda: Quaternion(1, 1, 0, 0), 'has length 1.41421356; it must be 1'),
        (lambda: Quaternion([1 + 2e-5, 0, 0, 0]), 'must be 1'),
        (lambda: Quaternion([1, 0, 0]), 'is not 4 finite numbers'),
        (lambda: Quaternion(wxyz='abcd'), 'is not 4 numbers'),
        (lambda: Quaternion(rotation=2 * np.eye(3)), 'is not a rotation'),
        (lambda: Quaternion([1, 0, 0, 0], rotation=np.eye(3)), 'give one description'),
        (lambda: AngleAxis(1.0, [0, 0, 2]), 'AngleAxis: axis'),
        (lambda: AngleAxis(1.0), 'give both angle and axis'),
    ],
)
def test_what_is_no_rotation_is_refused(make, words):
    with pytest.raises(RuntimeError, match=words):
        make()


def test_four_numbers_are_a_point_or_a_direction():
    X_AB = RigidTransform(R_AB, [1, 2, 3])
    for vec_B in ([4, 5, 6, 1], [4, 5, 6, 0]):
        expected = X_AB.GetAsMatrix4() @ vec_B
        for vec_A in (X_AB @ vec_B, X_AB.multiply(vec_B=vec_B)):
            np.testing.assert_allclose(vec_A, expected, rtol=0, atol=1e-15)
    with pytest.raises(RuntimeError, match=r'the last of \[4.0, 5.0, 6.0, 0.5\] is not 0 or 1'):
        X_AB @ [4, 5, 6, 0.5]
    np.testing.assert_array_equal(X_AB.multiply(p_BoQ_B=[4, 5, 6]), X_AB @ [4, 5, 6])
    np.testing.assert_array_equal(R_AB.multiply(v_B=[4, 5, 6]), R_AB @ [4, 5, 6])


@pytest.mark.parametrize('tiny', [5e-324, 3e-310, 1.2e-160, 1e-100])
def test_an_angle_whose_square_is_none_has_an_axis_of_unit_length(tiny):
    turn = AngleAxis(quaternion=Quaternion(1.0, tiny, -tiny, 0.0))
    np.testing.assert_allclose(turn.axis(), [math.sqrt(0.5), -math.sqrt(0.5), 0.0], rtol=1e-15)
    assert turn.angle() == pytest.approx(2.0 * math.sqrt(2.0) * tiny, rel=1e-12, abs=1e-323)
