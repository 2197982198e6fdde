import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.interpolate import CubicHermiteSpline

from drake_geom_ros.trajectories.interpolation import MonotoneCubic


@st.composite
def waypoints(draw):
    count = draw(st.integers(2, 7))
    gaps = draw(arrays(float, count, elements=st.floats(0.05, 3.0)))
    values = draw(arrays(float, (count, 2), elements=st.floats(-3.0, 3.0)))
    return np.cumsum(gaps), values


@given(waypoints())
def test_waypoints_are_met_exactly(points):
    times, values = points
    np.testing.assert_array_equal(MonotoneCubic(times, values).value(times), values)


@given(waypoints())
def test_curve_is_monotone_between_neighbours(points):
    times, values = points
    curve = MonotoneCubic(times, values)
    for k in range(len(times) - 1):
        y = curve.value(np.linspace(times[k], times[k + 1], 50))
        steps = np.diff(y, axis=0) * np.sign(values[k + 1] - values[k])
        assert (steps >= -1e-13).all()
        assert (y >= values[k : k + 2].min(axis=0)).all()
        assert (y <= values[k : k + 2].max(axis=0)).all()


def spline(curve):
    """Return SciPy's curve through the same waypoints with the same slopes, which is C1."""
    return CubicHermiteSpline(curve.times, curve.values, curve._slopes)


@given(waypoints())
def test_it_is_the_spline_of_its_slopes(points):
    times, values = points
    curve = MonotoneCubic(times, values)
    t = np.linspace(times[0], times[-1], 300)
    np.testing.assert_allclose(curve.value(t), spline(curve)(t), rtol=0.0, atol=1e-12)


@given(waypoints())
def test_curve_rests_at_both_ends_and_outside(points):
    times, values = points
    curve = MonotoneCubic(times, values)
    outside = [times[0] - 1.0, times[0], times[-1], times[-1] + 1.0]
    np.testing.assert_array_equal(curve._slopes[[0, -1]], 0.0)
    np.testing.assert_array_equal(curve.value(outside), values[[0, 0, -1, -1]])


@given(waypoints())
def test_max_speed_bounds_every_speed_and_is_reached(points):
    times, values = points
    curve = MonotoneCubic(times, values)
    fine = np.concatenate([np.linspace(a, b, 400) for a, b in itertools.pairwise(times)])
    seen = np.abs(spline(curve).derivative()(fine)).max(axis=0)
    top = curve.max_speed()
    assert (seen <= top * (1 + 1e-12)).all()
    np.testing.assert_allclose(seen, top, rtol=1e-3)


def test_equal_neighbours_keep_still():
    curve = MonotoneCubic([0.0, 1.0, 2.5, 3.0], [[0.0], [0.1], [0.1], [0.7]])
    np.testing.assert_array_equal(curve.value(np.linspace(1.0, 2.5, 97)), 0.1)


def test_shape_of_times_is_the_shape_of_the_answer():
    curve = MonotoneCubic([0.0, 1.0], [[0.0, 0.0, 1.0], [1.0, 2.0, 0.0]])
    assert curve.value(0.5).shape == (3,)
    assert curve.value(np.zeros((2, 4))).shape == (2, 4, 3)


@pytest.mark.parametrize(
    ('times', 'values', 'reason'),
    [
        ([0.0], [[1.0]], 'two or more'),
        ([0.0, 0.0], [[1.0], [2.0]], 'increase strictly'),
        ([0.0, 1.0], [[1.0]], 'shape'),
        ([0.0, 1.0], [[1.0], [np.nan]], 'finite'),
    ],
)
def test_what_is_no_curve_is_refused(times, values, reason):
    with pytest.raises(ValueError, match=reason):
        MonotoneCubic(times, values)
