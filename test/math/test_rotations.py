"""RotationMatrix and RollPitchYaw against SciPy, and the laws of rotations."""

import math
import types

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles.poses import random_poses
from scipy.spatial.transform import Rotation

from drake_geom_ros.math import RollPitchYaw, RotationMatrix
from drake_geom_ros.math.tolerances import ROTATION

ROTATIONS = [Rotation.from_quat(pose[3:]) for pose in random_poses(60, seed=2)]
angles = st.floats(-10.0, 10.0)


def close(a, b, atol=1e-15):
    np.testing.assert_allclose(a, b, rtol=0, atol=atol)


@pytest.mark.parametrize('index', range(0, 60, 7))
def test_laws(index):
    R, S = (RotationMatrix(ROTATIONS[k].as_matrix()) for k in (index, 59 - index))
    close((R @ R.inverse()).matrix(), np.eye(3))
    close((R @ S).inverse().matrix(), (S.inverse() @ R.inverse()).matrix())
    close(R.InvertAndCompose(S).matrix(), (R.transpose() @ S).matrix())
    close(R @ (S @ [1, 2, 3]), (R @ S) @ [1, 2, 3], atol=1e-14)
    assert (R @ S).IsValid()
    assert (R @ RotationMatrix.Identity()).matrix().tolist() == R.matrix().tolist()


def test_vectors_are_rotated_one_or_many():
    R = RotationMatrix.MakeZRotation(math.pi / 2)
    close(R @ [1, 0, 0], [0, 1, 0])
    close(R @ np.eye(3), R.matrix())
    assert (R @ np.zeros((3, 5))).shape == (3, 5)
    with pytest.raises(RuntimeError, match=r'shape \(4,\)'):
        R @ [1, 2, 3, 4]


@pytest.mark.parametrize(('name', 'axis'), [('X', 'x'), ('Y', 'y'), ('Z', 'z')])
def test_rotations_about_an_axis(name, axis):
    R = getattr(RotationMatrix, f'Make{name}Rotation')(0.7)
    close(R.matrix(), Rotation.from_euler(axis, 0.7).as_matrix())


@given(roll=angles, pitch=angles, yaw=angles)
def test_roll_pitch_yaw_agrees_with_scipy_and_comes_back(roll, pitch, yaw):
    R = RotationMatrix(RollPitchYaw(roll, pitch, yaw))
    close(R.matrix(), Rotation.from_euler('xyz', [roll, pitch, yaw]).as_matrix())
    back = R.ToRollPitchYaw()
    close(back.ToRotationMatrix().matrix(), R.matrix(), atol=4e-15)
    assert abs(back.pitch_angle()) <= math.pi / 2
    assert max(abs(back.roll_angle()), abs(back.yaw_angle())) <= math.pi


@pytest.mark.parametrize('sign', [-1, 1])
@pytest.mark.parametrize('off', [0.0, 1e-16, 1e-12, 1e-8, 1e-7, 1e-5])
def test_roll_pitch_yaw_survives_gimbal_lock(sign, off):
    R = RollPitchYaw(0.3, sign * (math.pi / 2 - off), -1.1).ToRotationMatrix()
    close(R.ToRollPitchYaw().ToRotationMatrix().matrix(), R.matrix(), atol=2e-15)


@pytest.mark.parametrize('rotation', ROTATIONS[::9])
def test_quaternions_are_in_drakes_order(rotation):
    x, y, z, w = rotation.as_quat()
    wxyz = np.array([w, x, y, z]) * (1 if w >= 0 else -1)
    for R in (
        RotationMatrix([w, x, y, z]),
        RotationMatrix(quaternion=[w, x, y, z]),
        RotationMatrix(types.SimpleNamespace(wxyz=lambda: np.array([w, x, y, z]))),
    ):
        close(R.matrix(), rotation.as_matrix())
        if abs(w) > 1e-12:
            close(R.ToQuaternionAsVector(), wxyz)
            close(R.ToRollPitchYaw().ToQuaternionAsVector(), wxyz, atol=4e-15)
    close(
        RollPitchYaw(quaternion=[w, x, y, z]).ToRotationMatrix().matrix(),
        rotation.as_matrix(),
        atol=4e-15,
    )


@pytest.mark.parametrize('axis', [0, 1, 2])
@pytest.mark.parametrize('b', [[1, 2, 3], [-4, 0, 0], [0, 1e-5, 0], [3, 3, -3], [1e3, 1, 1e-9]])
def test_one_vector_makes_a_rotation(b, axis):
    R = RotationMatrix.MakeFromOneVector(b, axis)
    assert R.IsValid()
    close(R.col(axis), np.array(b) / np.linalg.norm(b), atol=2e-16)


@pytest.mark.parametrize(
    ('b', 'axis', 'words'),
    [
        ([0, 0, 1e-11], 2, r'\|b_A\| = 1e-11'),
        ([1, 0, 0], 3, 'axis_index = 3'),
        ([1, 0, math.nan], 0, 'b_A.*finite'),
        ([1, 0], 0, 'b_A'),
    ],
)
def test_one_vector_that_has_no_direction(b, axis, words):
    with pytest.raises(RuntimeError, match=words):
        RotationMatrix.MakeFromOneVector(b, axis)


def test_projection_finds_the_nearest_rotation():
    rng = np.random.default_rng(3)
    truth = ROTATIONS[1].as_matrix()
    noisy = truth + 1e-3 * rng.normal(size=(3, 3))
    nearest = RotationMatrix.ProjectToRotationMatrix(noisy)
    assert nearest.IsValid()
    distance = np.linalg.norm(nearest.matrix() - noisy)
    for _ in range(200):
        other = Rotation.from_rotvec(1e-3 * rng.normal(size=3)).as_matrix() @ nearest.matrix()
        assert np.linalg.norm(other - noisy) > distance
    close(RotationMatrix.ProjectToRotationMatrix(7 * truth).matrix(), truth, atol=2e-15)
    for bad in (np.zeros((3, 3)), -np.eye(3), np.full((3, 3), np.nan), np.eye(2)):
        with pytest.raises(RuntimeError, match='positive determinant'):
            RotationMatrix.ProjectToRotationMatrix(bad)


@pytest.mark.parametrize(
    ('value', 'words'),
    [
        (np.ones((3, 3)), 'ProjectToRotationMatrix'),
        (-np.eye(3), 'max .* is inf'),
        (np.eye(3) * (1 + 1e-10), '2e-10, allowed 1e-10'),
        (np.full((3, 3), np.nan), 'not a rotation'),
        ([2.0, 0, 0, 0], 'norm 2'),
        (np.eye(4), r'shape \(4, 4\)'),
        ('x', 'not a rotation'),
    ],
)
def test_what_is_no_rotation_is_refused(value, words):
    with pytest.raises(RuntimeError, match=words):
        RotationMatrix(value)


def test_a_rotation_is_made_of_one_thing():
    with pytest.raises(RuntimeError, match='give one of'):
        RotationMatrix(np.eye(3), rpy=RollPitchYaw(0, 0, 0))
    for values in ((), (1.0, 2.0)):
        with pytest.raises(RuntimeError, match='give roll, pitch, yaw'):
            RollPitchYaw(*values)
    with pytest.raises(RuntimeError, match='RollPitchYaw: rpy'):
        RollPitchYaw([0, math.inf, 0])


def test_copies_and_values():
    R = RotationMatrix(rpy=RollPitchYaw([0.1, 0.2, 0.3]))
    copy = RotationMatrix(other=R)
    assert copy == R != RotationMatrix()
    assert RotationMatrix() != 3
    copy.set(np.eye(3))
    assert copy.IsExactlyIdentity()
    assert not R.IsExactlyIdentity()
    assert RotationMatrix.MakeXRotation(ROTATION / 2).IsNearlyIdentity()
    assert not RotationMatrix.MakeXRotation(1e-3).IsNearlyIdentity(1e-4)
    assert R.row(0).tolist() == R.matrix()[0].tolist()
    with pytest.raises(ValueError, match='read-only'):
        R.matrix()[0, 0] = 2.0
    rpy = RollPitchYaw(R)
    assert RollPitchYaw(other=rpy) == rpy == RollPitchYaw(rpy)
    assert RollPitchYaw(R=R) == RollPitchYaw(matrix=R.matrix())
    assert rpy != R
    close(rpy.vector(), [0.1, 0.2, 0.3])


def test_they_print_as_they_are_made():
    R = RotationMatrix(ROTATIONS[1].as_matrix())
    assert eval(repr(R)) == R
    assert repr(RollPitchYaw(1, 2, 3)) == 'RollPitchYaw(roll=1.0, pitch=2.0, yaw=3.0)'


def test_rotations_and_angles_are_equal_exactly_or_nearly():
    R = RotationMatrix.MakeXRotation(0.3)
    near = RotationMatrix.MakeXRotation(0.3 + 1e-6)
    assert R.IsExactlyEqualTo(RotationMatrix(R))
    assert not R.IsExactlyEqualTo(near)
    assert R.IsNearlyEqualTo(near, tolerance=1e-6)
    assert not R.IsNearlyEqualTo(near, tolerance=1e-7)
    rpy = RollPitchYaw(0.1, 0.2, 0.3)
    assert rpy.IsNearlyEqualTo(RollPitchYaw(0.1, 0.2, 0.3 + 1e-6), tolerance=1.1e-6)
    assert not rpy.IsNearlyEqualTo(RollPitchYaw(0.1, 0.2, 0.3 + 2.0 * np.pi), tolerance=1e-6)
