"""Origins of URDF elements: each way to say an orientation, and what cannot be one."""

import numpy as np
import pytest
from lxml import etree

from drake_geom_ros.math import RollPitchYaw
from drake_geom_ros.scene_files.urdf_poses import pose_of

QUARTER = RollPitchYaw(0.0, 0.0, np.pi / 2).ToRotationMatrix().matrix()


def pose(inside):
    return pose_of(etree.fromstring(f'<collision>{inside}</collision>'))


@pytest.mark.parametrize(
    'turn',
    [
        'rpy="0 0 1.5707963267948966"',
        'quat_xyzw="0 0 0.7071 0.7071"',
        'quat_xyzw="0 0 -0.70710678118654752 -0.70710678118654752"',
        'wxyz="0.7071 0 0 0.7071"',
    ],
)
def test_every_way_to_say_a_quarter_turn(turn):
    X = pose(f'<origin xyz="1 2 3" {turn}/>')
    np.testing.assert_array_equal(X.translation(), [1, 2, 3])
    np.testing.assert_allclose(X.rotation().matrix(), QUARTER, rtol=0, atol=1e-15)


def test_quaternions_in_either_order_are_the_same_rotation():
    q = np.array([0.1, -0.2, 0.3, 0.9]) / np.linalg.norm([0.1, -0.2, 0.3, 0.9])
    x, y, z, w = map(repr, q.tolist())
    one = pose(f'<origin quat_xyzw="{x} {y} {z} {w}"/>')
    assert pose(f'<origin wxyz="{w} {x} {y} {z}"/>').IsExactlyEqualTo(one)
    np.testing.assert_allclose(one.ToArray()[3:], q, rtol=0, atol=1e-15)


def test_no_origin_and_an_empty_one_are_the_identity():
    assert pose('').IsExactlyIdentity()
    assert pose('<origin/>').IsExactlyIdentity()


@pytest.mark.parametrize(
    ('origin', 'message'),
    [
        ('rpy="0 0 0" quat_xyzw="0 0 0 1"', 'rpy and quat_xyzw; give one orientation'),
        ('quat_xyzw="0 0 0 1" wxyz="1 0 0 0"', 'give one orientation'),
        ('quat_xyzw="0 0 0 2"', "quat_xyzw = '0 0 0 2' must be of unit length"),
        ('quat_xyzw="0 0 0 0"', 'unit length'),
        ('quat_xyzw="0 0 1"', 'must be 4 numbers'),
        ('wxyz="1 0 0 nan"', 'nan.; all numbers must be finite'),
        ('xyz="0,0,1"', "xyz = '0,0,1' must be 3 numbers"),
        ('xyz="0 0 1m"', 'must be 3 numbers'),
        ('xyz="0 0 1_0"', 'must be 3 numbers'),
        ('rpy="0 0 90deg"', 'must be 3 numbers'),
    ],
)
def test_what_is_no_pose_is_refused(origin, message):
    with pytest.raises(ValueError, match=message):
        pose(f'<origin {origin}/>')
