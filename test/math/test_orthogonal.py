"""What is almost a rotation is made one; what is one stays as it is, to the bit."""

import itertools

import numpy as np
import pytest
from oracles.poses import mp, nearest_rotation, random_poses
from scipy.spatial.transform import Rotation

from drake_geom_ros.math import RigidTransform, RollPitchYaw, RotationMatrix
from drake_geom_ros.math.tolerances import ALMOST_ROTATION, ORTHOGONAL

ROTATIONS = [Rotation.from_quat(pose[3:]).as_matrix() for pose in random_poses(60, seed=5)]


def defect(R):
    return np.abs(R @ R.T - np.eye(3)).max()


def off_by(rng, R, size):
    """Return a matrix whose columns are no longer unit and at right angles, by about ``size``."""
    E = rng.uniform(-1.0, 1.0, (3, 3))
    return R @ (np.eye(3) + 0.25 * size * (E + E.T))


@pytest.mark.parametrize('size', [1e-14, 1e-12, 1e-11, ALMOST_ROTATION / 3])
def test_the_rotation_next_to_a_matrix_is_taken(size):
    rng = np.random.default_rng(0)
    for R in ROTATIONS:
        given = off_by(rng, R, size)
        taken = RotationMatrix(given).matrix()
        assert defect(taken) <= ORTHOGONAL
        # By how far a matrix that is kept may be off, see geometry/_proximity/tolerances.py.
        nearest = nearest_rotation(given)
        error = mp.matrix(taken.tolist()) - nearest
        assert max(abs(e) for e in error) <= ORTHOGONAL


def test_a_pose_takes_it_too():
    given = off_by(np.random.default_rng(1), ROTATIONS[1], 1e-12)
    X = np.eye(4)
    X[:3, :3] = given
    for pose in (RigidTransform(X), RigidTransform(X[:3]), RigidTransform(RotationMatrix(given))):
        assert defect(pose.rotation().matrix()) <= ORTHOGONAL


def test_rotations_are_kept_to_the_bit():
    for rows in itertools.permutations(range(3)):
        R = np.eye(3)[list(rows)]
        R *= np.linalg.det(R)
        np.testing.assert_array_equal(RotationMatrix(R).matrix(), R)
    rng = np.random.default_rng(2)
    for R in ROTATIONS:
        np.testing.assert_array_equal(RotationMatrix(R).matrix(), R)
        taken = RotationMatrix(off_by(rng, R, 1e-11)).matrix()
        np.testing.assert_array_equal(RotationMatrix(taken).matrix(), taken)


def test_single_precision_is_refused():
    for R in ROTATIONS[1::3]:
        with pytest.raises(RuntimeError, match='not a rotation'):
            RotationMatrix(R.astype(np.float32))


def test_what_products_make_is_accepted():
    # A plain product of matrices drifts off; RotationMatrix and RigidTransform do not.
    step = RollPitchYaw(0.1, 0.2, 0.3).ToRotationMatrix()
    R = plain = step.matrix()
    X = product = RigidTransform(step, [1, 2, 3])
    inverse = X.inverse()
    for _ in range(300_000):
        plain = plain @ R
    assert 1e-12 < defect(plain) < ALMOST_ROTATION
    assert defect(RotationMatrix(plain).matrix()) <= ORTHOGONAL
    for k in range(30_000):
        step = step @ RotationMatrix._make(R)
        product = product @ X if k % 2 else inverse.InvertAndCompose(product)
        assert defect(step.matrix()) <= 2 * ORTHOGONAL
    assert defect(product.rotation().matrix()) <= 2 * ORTHOGONAL
    assert RotationMatrix(step.matrix()) == step
