"""Splines of joints: the conditions that define them, in high precision, and bounds of them."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.trajectories import JointSpline, JointTrajectory
from drake_geom_ros.trajectories.joint_spline import EDGES

KINDS = ['straight', 'cubic', 'quintic']


def trajectory_of(seed, kind, points=4, joints=2):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.01, 2.0, points))
    q, v, a = rng.normal(0, 1, (3, points, joints))
    return JointTrajectory(
        times, q, None if kind == 'straight' else v, a if kind == 'quintic' else None
    )


def in_high_precision(trajectory, kind, edge, joint):
    """Return the polynomial in t - t0 that has the ends' values and derivatives."""
    count = {'straight': 1, 'cubic': 2, 'quintic': 3}[kind]
    ends = [trajectory.positions, trajectory.velocities, trajectory.accelerations][:count]
    span = mpmath.mpf(trajectory.times[edge + 1]) - mpmath.mpf(trajectory.times[edge])
    size = 2 * count
    matrix, right = mpmath.matrix(size), mpmath.matrix(size, 1)
    for order, values in enumerate(ends):
        for row, (time, point) in enumerate([(mpmath.mpf(0), edge), (span, edge + 1)]):
            for power in range(order, size):
                factor = mpmath.factorial(power) / mpmath.factorial(power - order)
                matrix[2 * order + row, power] = factor * time ** (power - order)
            right[2 * order + row] = mpmath.mpf(values[point, joint])
    return mpmath.lu_solve(matrix, right)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), kind=st.sampled_from(KINDS), part=st.floats(0, 1))
def test_values_are_those_of_the_polynomial_with_the_given_ends(seed, kind, part):
    trajectory = trajectory_of(seed, kind)
    spline = JointSpline(trajectory)
    with mpmath.workdps(40):
        for edge in range(3):
            begin, end = trajectory.times[edge : edge + 2]
            time = begin + part * (end - begin)
            for joint in range(2):
                powers = in_high_precision(trajectory, kind, edge, joint)
                since = mpmath.mpf(time) - mpmath.mpf(begin)
                truth = sum(powers[k] * since**k for k in range(len(powers)))
                assert abs(spline.value(time)[joint] - truth) < 1e-12


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10**6), kind=st.sampled_from(KINDS))
def test_bounds_contain_the_values_and_derivatives(seed, kind):
    spline = JointSpline(trajectory_of(seed, kind))
    rows, curves, _ = spline.path()
    s = np.linspace(0, 1, 101)
    for edge in range(3 * EDGES):
        for joint in range(2):
            powers = [rows[edge, joint], *curves[edge, :5, joint]]
            polynomial = np.polynomial.Polynomial(powers)
            speed, acceleration, size, _ = curves[edge, 5:, joint]
            for bound, order in ((size, 0), (speed, 1), (acceleration, 2)):
                truth = np.abs(polynomial.deriv(order)(s)).max() if order else np.abs(
                    polynomial(s)
                ).max()  # fmt: skip
                assert truth <= bound <= 1.5 * truth + 0.2 * np.abs(powers).sum() + 1e-12


def test_speeds_are_upper_bounds_in_seconds():
    still = [[0.0], [0.0]]
    spline = JointSpline(JointTrajectory([0.0, 2.0], [[0.0], [1.0]], still))
    assert 0.75 <= spline.speeds()[0] <= 0.76  # 1.5 times the mean


def test_a_spline_overshoots_between_points_that_are_within():
    trajectory = JointTrajectory([0.0, 1.0], [[0.9], [0.9]], [[1.0], [-1.0]])
    extreme = JointSpline(trajectory).beyond(np.array([-1.0]), np.array([1.0]))
    assert extreme.joint == 0
    assert extreme.time == pytest.approx(0.5)
    assert extreme.value == pytest.approx(1.15)
    assert JointSpline(trajectory).beyond(np.array([-1.0]), np.array([1.2])) is None


def test_points_without_velocities_make_straight_segments():
    velocities = [[1.0], [1.0], [np.nan]]
    spline = JointSpline(JointTrajectory([0, 1, 2], [[0.0], [0.0], [1.0]], velocities))
    assert spline.value(1.5) == 0.5
    assert spline.value(0.25) != 0.0


@pytest.mark.parametrize(
    ('changes', 'word'),
    [
        ({'times': [0.0, 0.0]}, 'grow'),
        ({'times': [0.0, np.nan]}, 'finite'),
        ({'times': [0.0]}, r'must be \(2,\)'),
        ({'positions': [[0.0], [np.inf]]}, 'finite'),
        ({'positions': [0.0, 1.0]}, 'must be'),
        ({'velocities': [[0.0, 0.0], [0.0, 0.0]]}, r'velocities \(2, 2\)'),
        ({'velocities': [[np.inf], [0.0]]}, 'velocities'),
    ],
)
def test_what_is_no_trajectory_is_refused(changes, word):
    good = {'times': [0.0, 1.0], 'positions': [[0.0], [1.0]], 'velocities': None}
    with pytest.raises(ArgumentError, match=word):
        JointSpline(JointTrajectory(**{**good, **changes}))


@pytest.mark.parametrize('kind', KINDS)
def test_the_edges_of_a_path_are_the_spline(kind):
    spline = JointSpline(trajectory_of(1, kind))
    rows, curves, _ = spline.path()
    times = np.interp(np.arange(3 * EDGES + 1) / EDGES, np.arange(4), spline.times)
    for edge in range(3 * EDGES):
        for part in (0.0, 0.3, 0.9):
            time = times[edge] + part * (times[edge + 1] - times[edge])
            value = rows[edge] + (part ** np.arange(1, 6)) @ curves[edge, :5]
            assert np.allclose(value, spline.value(time), rtol=0, atol=1e-13)


@pytest.mark.parametrize('kind', KINDS)
def test_a_part_is_the_spline_in_its_time(kind):
    spline = JointSpline(trajectory_of(2, kind))
    begin, end = np.interp([1.2, 1.7], np.arange(4), spline.times)
    part = spline.part(begin, end)
    for time in np.linspace(begin, end, 7):
        assert np.allclose(part.value(time), spline.value(time), rtol=0, atol=1e-12)
    assert len(part.path().rows) == EDGES + 1


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    kind=st.sampled_from(KINDS),
    share=st.floats(-0.2, 1, exclude_max=True),
)
def test_the_rest_is_the_spline_from_a_time_on(seed, kind, share):
    spline = JointSpline(trajectory_of(seed, kind))
    first, last = spline.times[[0, -1]]
    begin = min(first + share * (last - first), np.nextafter(last, -np.inf))
    rest = spline.rest(begin)
    assert rest.times[0] == max(begin, first)
    assert rest.times[-1] == last
    for time in np.linspace(rest.times[0], last, 9):
        assert np.allclose(rest.value(time), spline.value(time), rtol=0, atol=1e-9)
    with pytest.raises(ArgumentError, match='nothing is left'):
        spline.rest(last)


@pytest.mark.parametrize('kind', KINDS)
def test_a_spline_that_is_split_is_the_same(kind):
    spline = JointSpline(trajectory_of(4, kind))
    first, last = spline.times[[0, -1]]
    split = spline.split(np.linspace(first - 1.0, last + 1.0, 17))
    assert set(spline.times) < set(split.times)
    assert split.times[[0, -1]].tolist() == [first, last]
    for time in np.linspace(first, last, 33):
        assert np.allclose(split.value(time), spline.value(time), rtol=0, atol=1e-9)


@pytest.mark.parametrize('kind', KINDS)
def test_a_way_in_front_is_straight(kind):
    spline = JointSpline(trajectory_of(5, kind))
    first, last = spline.times[[0, -1]]
    begun = spline.begun_at(np.zeros(2), first - 2.0)
    assert np.allclose(begun.value(first - 0.5), 0.75 * spline.positions[0], rtol=0, atol=1e-12)
    for time in np.linspace(first, last, 9):
        assert np.allclose(begun.value(time), spline.value(time), rtol=0, atol=1e-12)
    with pytest.raises(ArgumentError, match='not before the first point'):
        spline.begun_at(np.zeros(2), first)


def test_splines_side_by_side_are_each_their_own():
    one, other = JointSpline(trajectory_of(6, 'cubic')), JointSpline(trajectory_of(7, 'quintic'))
    other.times = one.times
    both = one.beside(other)
    for time in np.linspace(one.times[0], one.times[-1], 9):
        assert both.value(time).tolist() == [*one.value(time), *other.value(time)]
    other.times = one.times + 1.0
    with pytest.raises(ArgumentError, match='at the same times'):
        one.beside(other)
