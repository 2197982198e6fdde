"""LaserScan messages to points, by the definitions of its fields and of REP 117."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.laser_scan import duration_of_scan, points_of_scan, unturned
from drake_geom_ros.math import RotationMatrix


def scan(ranges, **changes):
    told = {
        'ranges': ranges, 'range_min': 0.5, 'range_max': 4.0, 'angle_min': 0.0,
        'angle_increment': math.pi / 2, 'time_increment': 0.0,
    }  # fmt: skip
    return Plain(**{**told, **changes})


def test_points_lie_at_their_ranges_and_angles():
    points = points_of_scan(scan([1.0, 2.0, 3.0], angle_min=-math.pi / 2))
    np.testing.assert_allclose(points, [[0, -1, 0], [2, 0, 0], [0, 3, 0]], rtol=0, atol=1e-15)


@pytest.mark.parametrize('no_echo', [math.inf, math.nan, 0.0, 0.4, 4.1])
def test_what_is_no_range_is_no_point(no_echo):
    assert np.isfinite(points_of_scan(scan([1.0, no_echo]))[:, 0]).tolist() == [True, False]


def test_what_is_too_near_to_be_measured_is_where_measuring_begins():
    np.testing.assert_array_equal(points_of_scan(scan([-math.inf])), [[0.5, 0, 0]])


@pytest.mark.parametrize(
    ('field', 'value'),
    [
        ('range_min', -1.0),
        ('range_min', 5.0),
        ('range_min', math.nan),
        ('range_max', math.inf),
        ('angle_min', math.nan),
        ('angle_increment', math.inf),
    ],
)
def test_fields_that_are_no_numbers_are_refused(field, value):
    with pytest.raises(ArgumentError, match=field):
        points_of_scan(scan([1.0], **{field: value}))


def test_it_lasts_from_the_first_ray_to_the_last():
    assert duration_of_scan(scan([1.0] * 5, time_increment=0.25)) == 1.0
    assert duration_of_scan(scan([], time_increment=0.25)) == 0.0
    for wrong in (-0.1, math.nan, 3.0):
        with pytest.raises(ArgumentError, match='time_increment'):
            duration_of_scan(scan([1.0] * 5, time_increment=wrong))


angles = st.floats(-3.1, 3.1)


@given(
    axis=st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 0.1),
    angle=angles,
    shift=st.tuples(*[st.floats(-2, 2)] * 3),
)
def test_each_point_turns_by_its_part_of_the_way(axis, angle, shift):
    """The oracle turns each point by a rotation of its own."""
    axis = np.array(axis) / np.linalg.norm(axis)
    points = np.random.default_rng(0).uniform(-3, 3, (7, 3))

    def turned(part):
        K = np.cross(np.eye(3), -axis)  # K v = axis x v
        return np.eye(3) + math.sin(part) * K + (1 - math.cos(part)) * K @ K

    expected = [
        turned(angle * k / 6) @ point + np.array(shift) * k / 6 for k, point in enumerate(points)
    ]
    R = RotationMatrix(turned(angle)).matrix()
    np.testing.assert_allclose(unturned(points, R, np.array(shift)), expected, rtol=0, atol=1e-7)
