"""Poses of AutoDiffXd: values of the float classes, derivatives by differences."""

import numpy as np
import pytest

from drake_geom_ros.autodiffutils import (
    AutoDiffXd,
    ExtractGradient,
    ExtractValue,
    InitializeAutoDiff,
)
from drake_geom_ros.math import (
    RigidTransform,
    RigidTransform_,
    RollPitchYaw,
    RollPitchYaw_,
    RotationMatrix,
    RotationMatrix_,
)

Pose, Rotation, Angles = (T[AutoDiffXd] for T in (RigidTransform_, RotationMatrix_, RollPitchYaw_))
AT = np.array([0.3, -0.4, 0.5, 1.0, 2.0, 3.0])
OTHER = RigidTransform(RollPitchYaw(0.1, 0.7, -0.2), [0.5, -1.0, 2.0])


def pose(X, R, rpy, numbers):
    return X(R(rpy(*numbers[:3])), numbers[3:])


CHAINS = {
    'a pose': lambda X: X,
    'its inverse': lambda X: X.inverse(),
    'composed': lambda X: X @ OTHER @ X,
    'composed with its inverse': lambda X: X.InvertAndCompose(OTHER),
    'of its matrix': lambda X: type(X)(X.GetAsMatrix4()),
    'set anew': lambda X: type(X)(X.rotation().transpose() @ X.rotation(), X.translation()),
}


@pytest.mark.parametrize('name', CHAINS)
def test_it_is_the_float_pose_and_how_that_changes(name):
    def of_floats(numbers):
        made = pose(RigidTransform, RotationMatrix, RollPitchYaw, numbers)
        return CHAINS[name](made).GetAsMatrix34()

    found = CHAINS[name](pose(Pose, Rotation, Angles, InitializeAutoDiff(AT)[:, 0]))
    matrix = found.GetAsMatrix34()
    np.testing.assert_allclose(ExtractValue(matrix), of_floats(AT), rtol=0, atol=1e-14)
    rates = ExtractGradient(matrix, 6)
    for k, step in enumerate(1e-6 * np.eye(6)):
        expected = (of_floats(AT + step) - of_floats(AT - step)) / 2e-6
        np.testing.assert_allclose(rates[:, k], expected.ravel(order='F'), rtol=0, atol=1e-9)


def test_points_are_moved():
    numbers = InitializeAutoDiff(AT)[:, 0]
    X = pose(Pose, Rotation, Angles, numbers)
    p = X @ [1.0, 0.0, 0.0]
    of_floats = pose(RigidTransform, RotationMatrix, RollPitchYaw, AT)
    np.testing.assert_allclose(
        ExtractValue(p)[:, 0], of_floats @ [1.0, 0.0, 0.0], rtol=0, atol=1e-15
    )
    np.testing.assert_allclose(ExtractGradient(p)[:, 3:], np.eye(3), rtol=0, atol=1e-15)
    assert (X @ np.ones((3, 4))).shape == (3, 4)
    assert (X.rotation() @ np.ones(3)).shape == (3,)


def test_quaternions_and_float_rotations_are_taken():
    half = InitializeAutoDiff([0.2])[0, 0]
    wxyz = np.array([np.cos(half), 0.0, 0.0, np.sin(half)], dtype=object)
    R, expected = Rotation(wxyz).matrix(), Rotation.MakeZRotation(2.0 * half).matrix()
    np.testing.assert_allclose(ExtractValue(R), ExtractValue(expected), rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        ExtractGradient(R, 1), ExtractGradient(expected, 1), rtol=0, atol=1e-15
    )
    np.testing.assert_array_equal(ExtractValue(Pose(OTHER).GetAsMatrix34()), OTHER.GetAsMatrix34())
    assert ExtractGradient(Pose.Identity().GetAsMatrix34()).shape == (12, 0)


@pytest.mark.parametrize('wrong', [np.diag([1.0, 1.0, -1.0]), 2.0 * np.eye(3), np.zeros((3, 3))])
def test_what_is_no_rotation_is_refused(wrong):
    with pytest.raises(RuntimeError, match='not a rotation'):
        Rotation(wrong)
    with pytest.raises(RuntimeError, match='three finite numbers'):
        Pose([1.0, np.nan, 0.0])


def test_templates_know_pydrakes_scalar_by_its_name():
    def called(name, module):
        return type(name, (), {'__module__': module})

    assert RigidTransform_[called('AutoDiffXd', 'pydrake.autodiffutils')] is Pose
    assert RigidTransform_[(AutoDiffXd,)] is Pose
    for stranger in (called('AutoDiffXd', 'elsewhere'), called('float', 'pydrake'), int, None):
        with pytest.raises(RuntimeError, match='there is RigidTransform_'):
            RigidTransform_[stranger]
