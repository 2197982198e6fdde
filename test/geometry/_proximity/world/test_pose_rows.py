"""Reading poses from an array: the same numbers as ``math.batched``, and what is refused."""

import numpy as np
import pytest
from oracles.poses import mp, rotation_of_quaternion

from drake_geom_ros.geometry._proximity.tolerances import ROTATION_TAKEN
from drake_geom_ros.geometry._proximity.world.pose_rows import (
    FRAME_POSES,
    KNOWN,
    POSE_WIDTH,
    READ,
    REFUSED,
    RISING,
    positions_of,
    read_poses,
    rotations_of,
)
from drake_geom_ros.math.batched import matrices_from_poses
from drake_geom_ros.math.tolerances import FARTHEST


def random_poses(n):
    rng = np.random.default_rng(n)
    poses = rng.normal(size=(n, 7))
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1)[:, None]
    poses[:, 3:] *= rng.uniform(1 - 5e-4, 1 + 5e-4, (n, 1))
    return poses


@pytest.mark.parametrize('n', [0, 1, 200])
def test_the_same_as_in_numpy(n):
    poses = random_poses(n)
    Xs = np.empty((n, POSE_WIDTH))
    assert read_poses(poses, Xs) == n
    expected_Rs, expected_ps = matrices_from_poses(poses)
    np.testing.assert_allclose(rotations_of(Xs), expected_Rs, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(positions_of(Xs), expected_ps)


def test_rotations_are_those_of_the_quaternions_normalised_exactly():
    poses = random_poses(300)
    poses[::3, 6] *= 1e-3  # about half a turn rounding costs most
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1)[:, None]
    Xs = np.empty((300, POSE_WIDTH))
    read_poses(poses, Xs)
    for R, pose in zip(rotations_of(Xs), poses, strict=True):
        error = mp.matrix(R.tolist()) - rotation_of_quaternion(pose[3:])
        assert mp.mnorm(error, 'f') <= ROTATION_TAKEN / 2


@pytest.mark.parametrize('value', [np.nan, np.inf, 1.1, 0.0])
@pytest.mark.parametrize('column', [3, 6])
def test_the_first_bad_row_is_named(value, column):
    poses = random_poses(9)
    poses[4:, 3:], poses[4:, column] = 0.0, value
    assert read_poses(poses, np.empty((9, POSE_WIDTH))) == 4


@pytest.mark.parametrize('column', [0, 1, 2])
@pytest.mark.parametrize('value', [-np.inf, np.nan, 2.0 * FARTHEST, -2.0 * FARTHEST])
def test_positions_must_be_finite_and_not_too_far(column, value):
    poses = random_poses(3)
    poses[1, column] = value
    assert read_poses(poses, np.empty((3, POSE_WIDTH))) == 1


@pytest.mark.parametrize(
    ('ids', 'rise'), [([], True), ([3, 5, 9], True), ([3, 3, 9], False), ([3, 9, 5], False)]
)
def test_ids_that_rise_are_told_from_others_beside_the_poses(ids, rise):
    n, poses = len(ids), random_poses(3)[: len(ids)]
    values, Xs, other = np.array(ids, np.int64), np.empty((n, POSE_WIDTH)), np.array([8])
    assert FRAME_POSES.call(values, other, poses, Xs) == (RISING if rise else READ)
    assert (positions_of(Xs) == poses[:, :3]).all()
    if n:
        poses[1, 6] = 5.0
        assert FRAME_POSES.call(values, other, poses, Xs) == REFUSED
        assert FRAME_POSES.call(values, values, poses, Xs) == REFUSED


def test_ids_that_are_known_are_told_from_others():
    poses, Xs = random_poses(3), np.empty((3, POSE_WIDTH))
    known = np.array([3, 5, 9])
    assert FRAME_POSES.call(known[::-1][::-1], known.copy(), poses, Xs) == KNOWN
    assert FRAME_POSES.call(known, known[:2].copy(), poses, Xs) == RISING
    assert FRAME_POSES.call(known, np.array([3, 5, 8]), poses, Xs) == RISING


@pytest.mark.parametrize('shape', [(2, 7), (4, 7), (3, 6), (3, 8)])
def test_another_number_or_width_of_poses_is_refused(shape):
    known, Xs = np.arange(3), np.empty((3, POSE_WIDTH))
    assert FRAME_POSES.call(known, known, np.ones(shape), Xs) == REFUSED


@pytest.mark.parametrize('shape', [(21,), (3, 7, 1)])
def test_another_number_of_dimensions_is_no_such_argument(shape):
    known, Xs = np.arange(3), np.empty((3, POSE_WIDTH))
    with pytest.raises(TypeError):
        FRAME_POSES.call(known, known, np.ones(shape), Xs)
