"""Range messages to points on the cap of a cone. No ROS."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live.inputs.sensing_node import cone

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.range_cone import points_of_range

UNIT = st.floats(0.0, 1.0)


@given(st.floats(0.1, 3.9), st.floats(0.0, math.pi), UNIT, UNIT)
def test_every_place_of_the_cap_is_near_a_point(distance, fov, part, turn):
    """A place of the cap has no larger angle to the x axis than half of the field of view."""
    spacing = 0.1
    points = points_of_range(cone(distance, field_of_view=fov), spacing)
    assert np.linalg.norm(points, axis=1) == pytest.approx(distance)
    assert (np.arccos(np.clip(points[:, 0] / distance, -1, 1)) <= 0.5 * fov + 1e-6).all()
    angle, around = part * 0.5 * fov, 2.0 * math.pi * turn
    across = distance * math.sin(angle)
    place = [distance * math.cos(angle), across * math.cos(around), across * math.sin(around)]
    assert np.linalg.norm(points - place, axis=1).min() <= spacing


def test_no_echo_has_no_points_and_what_is_too_near_is_at_the_least_range():
    assert points_of_range(cone(math.inf), 0.1).shape == (0, 3)
    near = points_of_range(cone(-math.inf), 0.1)
    assert np.linalg.norm(near, axis=1) == pytest.approx(0.05)


@pytest.mark.parametrize(
    ('distance', 'changes', 'told'),
    [
        (math.nan, {}, 'range is nan; it must be inf, -inf, or from min_range 0.05'),
        (4.1, {}, 'range is 4.1'),
        (0.01, {}, 'range is 0.01'),
        (1.0, {'min_range': 5.0}, 'min_range is 5'),
        (1.0, {'max_range': math.inf}, 'max_range is inf'),
        (1.0, {'field_of_view': 7.0}, 'field_of_view is 7.0; it must be from 0 to 2 pi'),
        (1.0, {'field_of_view': math.nan}, 'field_of_view is nan'),
    ],
)
def test_what_is_no_range_is_refused(distance, changes, told):
    with pytest.raises(ArgumentError, match=told):
        points_of_range(cone(distance, **changes), 0.1)


def test_too_many_points_are_refused():
    with pytest.raises(ArgumentError, match='choose a larger resolution'):
        points_of_range(cone(4.0, field_of_view=6.0), 0.002)
