import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drake_geom_ros.trajectories.pose_matrices import (
    inverse,
    matrices_of_poses,
    poses_of_matrices,
)

axes = arrays(float, 3, elements=st.floats(-1.0, 1.0)).filter(lambda v: np.linalg.norm(v) > 0.01)
angles = st.one_of(st.floats(-np.pi, np.pi), st.sampled_from([0.0, np.pi, 1e-9, np.pi - 1e-9]))
places = arrays(float, 3, elements=st.floats(-5.0, 5.0))


def _pose(axis, angle, place):
    q = np.append(np.sin(angle / 2) * axis / np.linalg.norm(axis), np.cos(angle / 2))
    return np.append(place, q)


@given(axes, angles, places, axes)
def test_matrix_turns_vectors_about_the_axis(axis, angle, place, v):
    """Rodrigues' formula written with vector products instead of matrices."""
    n = axis / np.linalg.norm(axis)
    turned = v * np.cos(angle) + np.cross(n, v) * np.sin(angle) + n * (n @ v) * (1 - np.cos(angle))
    X = matrices_of_poses(_pose(axis, angle, place))
    np.testing.assert_allclose(
        X @ np.append(v, 1.0), np.append(turned + place, 1.0), rtol=0, atol=1e-12
    )


@given(axes, angles, places)
def test_poses_survive_the_way_through_matrices(axis, angle, place):
    pose = _pose(axis, angle, place)
    back = poses_of_matrices(matrices_of_poses(pose))
    assert back[6] >= 0.0
    np.testing.assert_allclose(back[:3], pose[:3])
    assert abs(abs(back[3:] @ pose[3:]) - 1.0) < 1e-12


@given(axes, angles, places)
def test_inverse_undoes(axis, angle, place):
    X = matrices_of_poses(_pose(axis, angle, place))
    np.testing.assert_allclose(inverse(X) @ X, np.eye(4), rtol=0, atol=1e-12)


def test_batches_keep_their_shape():
    rng = np.random.default_rng(0)
    q = rng.normal(size=(3, 2, 4))
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    poses = np.concatenate([rng.normal(size=(3, 2, 3)), q], axis=-1)
    X = matrices_of_poses(poses)
    assert X.shape == (3, 2, 4, 4)
    np.testing.assert_allclose(X[2, 1], matrices_of_poses(poses[2, 1]))
    np.testing.assert_allclose(poses_of_matrices(X)[2, 1], poses_of_matrices(X[2, 1]))
