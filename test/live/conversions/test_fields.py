"""Poses with plain objects: no message class, no ROS."""

import array
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.live.conversions.fields import fill_floats, fill_pose, pose_from_message
from drake_geom_ros.math import RigidTransform, RollPitchYaw


def plain_pose():
    return Plain(
        position=Plain(x=0.0, y=0.0, z=0.0), orientation=Plain(x=0.0, y=0.0, z=0.0, w=1.0)
    )


@given(st.lists(st.floats(-3, 3), min_size=6, max_size=6))
def test_poses_there_and_back(numbers):
    X = RigidTransform(RollPitchYaw(*numbers[:3]), numbers[3:])
    message = plain_pose()
    fill_pose(message, X)
    assert pose_from_message(message).IsNearlyEqualTo(X, 1e-14)


def test_a_pose_that_is_none_is_refused():
    message = plain_pose()
    message.orientation.w = 0.5
    with pytest.raises(RuntimeError, match=r'norm 0\.5'):
        pose_from_message(message)


@pytest.mark.parametrize('count', [0, 1, 131_072, 300_001])
def test_a_float_field_is_filled_where_it_is(count):
    field, values = array.array('d', [7.0]), np.random.default_rng(0).normal(size=count)
    fill_floats(field, values)
    np.testing.assert_array_equal(field, values)
    fill_floats(field, np.array([[1.0, 2.0], [3.0, 4.0]])[:, ::-1])  # whatever its layout
    assert list(field) == [2.0, 1.0, 4.0, 3.0]
