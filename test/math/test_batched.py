"""Batched poses against SciPy's rotations, and the laws of a group."""

import numpy as np
import pytest
from oracles.poses import matrix_of, random_poses

from drake_geom_ros.math.batched import (
    are_poses,
    compose,
    matrices_from_poses,
    poses_from_matrices,
    quaternions_from_rotations,
    rotations_from_quaternions,
)
from drake_geom_ros.math.tolerances import QUATERNION_NORM

POSES = random_poses(300, seed=1)


def test_matrices_agree_with_scipy():
    Rs, ps = matrices_from_poses(POSES)
    truth = np.array([matrix_of(pose) for pose in POSES])
    np.testing.assert_allclose(Rs, truth[:, :3, :3], rtol=0, atol=1e-15)
    assert np.array_equal(ps, POSES[:, :3])


def test_there_and_back_up_to_the_sign_of_the_quaternion():
    back = poses_from_matrices(*matrices_from_poses(POSES))
    signs = np.where(POSES[:, 6:] < 0, -1.0, 1.0)
    # At w = 0 either sign is right, and rounding chooses.
    signs = np.where(
        np.abs(POSES[:, 6:]) < 1e-15, np.sign((POSES * back)[:, 3:].sum(1))[:, None], signs
    )
    np.testing.assert_allclose(back[:, 3:] * signs, POSES[:, 3:], rtol=0, atol=1e-15)
    assert (back[:, 6] >= 0).all()


def test_quaternions_are_unit_and_accurate_at_half_turns():
    for axis in np.eye(3):
        R = 2.0 * np.outer(axis, axis) - np.eye(3)
        q = quaternions_from_rotations(R[None])[0]
        assert np.array_equal(np.abs(q), [*axis, 0.0])


def test_rotations_are_orthonormal_even_from_float32():
    Rs, _ = matrices_from_poses(POSES.astype(np.float32))
    errors = np.abs(Rs @ Rs.transpose(0, 2, 1) - np.eye(3)).max()
    assert errors < 4e-15
    np.testing.assert_allclose(np.linalg.det(Rs), 1.0, rtol=0, atol=1e-14)


def test_compose_agrees_with_matrices():
    n = 100
    A, B = matrices_from_poses(POSES[:n]), matrices_from_poses(POSES[n : 2 * n])
    R_AC, p_AC = compose(*A, *B)
    for k in range(n):
        truth = matrix_of(POSES[k]) @ matrix_of(POSES[n + k])
        np.testing.assert_allclose(R_AC[k], truth[:3, :3], rtol=0, atol=1e-15)
        np.testing.assert_allclose(p_AC[k], truth[:3, 3], rtol=0, atol=1e-14)


def test_one_pose_composes_with_many():
    Rs, ps = matrices_from_poses(POSES)
    R, p = compose(Rs[0], ps[0], Rs, ps)
    for k in (0, 7, 299):
        R_k, p_k = compose(Rs[0], ps[0], Rs[k], ps[k])
        np.testing.assert_allclose(R[k], R_k, rtol=0, atol=1e-15)
        np.testing.assert_allclose(p[k], p_k, rtol=0, atol=1e-15)


def test_results_are_not_views_of_the_input():
    poses = POSES.copy()
    _, ps = matrices_from_poses(poses)
    poses[:] = 0.0
    assert np.array_equal(ps, POSES[:, :3])


def test_no_poses_are_fine():
    for nothing in ([], np.zeros((0, 7))):
        Rs, ps = matrices_from_poses(nothing)
        assert Rs.shape == (0, 3, 3)
        assert ps.shape == (0, 3)
        assert poses_from_matrices(Rs, ps).shape == (0, 7)


@pytest.mark.parametrize(
    ('poses', 'words'),
    [
        (np.zeros(7), r'shape \(7,\) is not \(n, 7\)'),
        (np.zeros((2, 6)), r'shape \(2, 6\)'),
        (np.zeros((1, 2, 7)), r'shape \(1, 2, 7\)'),
        ([['a'] * 7], 'not an array of numbers'),
        ([[0, 0, 0, 0, 0, 0, 1], [0, np.nan, 0, 0, 0, 0, 1]], r'poses\[1\].*not finite'),
        ([[0, 0, np.inf, 0, 0, 0, 1]], r'poses\[0\].*not finite'),
        ([[0, 0, 0, 0, 0, 0, 0]], r'poses\[0\].*norm 0;'),
        ([[0, 0, 0, 0, 0, 0, 1.002]], 'norm 1.002'),
        ([[1, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 1, 2, 3]], r'poses\[1\].*qx qy qz qw'),
    ],
)
def test_bad_poses_are_refused_by_row(poses, words):
    with pytest.raises(RuntimeError, match=words):
        matrices_from_poses(poses)


def test_the_norm_may_be_off_by_the_tolerance():
    for norm in (1 - 0.999 * QUATERNION_NORM, 1 + 0.999 * QUATERNION_NORM):
        R = rotations_from_quaternions([[0.6 * norm, 0, 0, 0.8 * norm]])
        np.testing.assert_allclose(
            R, rotations_from_quaternions([[0.6, 0, 0, 0.8]]), rtol=0, atol=1e-15
        )


def test_which_rows_are_poses():
    good = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0]
    rows = np.array([good] * 6)
    rows[1, 0], rows[2, 6], rows[3, 3], rows[4, 6] = np.nan, 1.1, np.inf, 1e200
    assert are_poses(rows).tolist() == [True, False, False, False, False, True]
    assert are_poses(np.zeros((0, 7))).tolist() == []
    for row, is_pose in zip(rows, are_poses(rows), strict=True):
        if is_pose:
            matrices_from_poses([row])
        else:
            with pytest.raises(RuntimeError):
                matrices_from_poses([row])
