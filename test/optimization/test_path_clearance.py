"""Clearance of paths: below every state between way points, with derivatives, and provable."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.batch import check_path, check_trajectory
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.optimization import (
    ClampedCubicSpline,
    PathClearanceConstraint,
    path_clearance,
)
from drake_geom_ros.trajectories.joint_spline import JointSpline


def path_of(planar, seed, count=4, size=0.3):
    rng = np.random.default_rng(seed)
    joints = planar.joints
    steps = size * rng.normal(size=(count, 3)) * (joints.upper - joints.lower) / 4
    return np.clip(planar.states(1, seed) + np.cumsum(steps, axis=0), joints.lower, joints.upper)


def between(path, count):
    """Return states on the path, ``count`` for each edge."""
    times = np.linspace(0.0, len(path) - 1.0, count * (len(path) - 1) + 1)
    return np.column_stack([np.interp(times, np.arange(len(path)), c) for c in path.T])


@given(seed=st.integers(0, 2**31), pieces=st.integers(1, 6))
def test_no_state_on_the_way_is_nearer_than_the_bound(planar, seed, pieces):
    path = path_of(planar, seed)
    found = path_clearance(planar.checker, path, pieces)
    states = between(path, 60 * pieces)
    clearances, _ = planar.checker.clearance_and_gradient(states)
    each = clearances[:-1].reshape(len(path) - 1, pieces, 60)
    assert (found.lower_bound <= each.min(axis=2) + 1e-12).all()
    assert found.least == found.lower_bound.min()
    np.testing.assert_allclose(found.clearance, clearances[::60], rtol=0, atol=1e-9)


def test_more_pieces_come_closer(planar):
    path = path_of(planar, 5)
    clearances, _ = planar.checker.clearance_and_gradient(between(path, 2000))
    gaps = [clearances.min() - path_clearance(planar.checker, path, n).least for n in (1, 8, 64)]
    assert gaps[0] > gaps[1] > gaps[2] >= 0.0
    assert gaps[2] < 0.05 * gaps[0]


def test_gradients_are_central_differences(planar):
    step, compared = 1e-6, 0
    for seed in range(8):
        path = path_of(planar, seed)
        constraint = PathClearanceConstraint(planar.checker, len(path), 0.0, pieces=3)
        jacobian = constraint.Jacobian(path.ravel())
        for column in range(path.size):
            moved = [path.flatten(), path.flatten()]
            for sign, values in zip((1.0, -1.0), moved, strict=True):
                values[column] += sign * step
            if not all(inside(planar, values) for values in moved):
                continue
            ahead, behind = (constraint.Eval(values) for values in moved)
            middle = constraint.Eval(path.ravel())
            # Where another pair becomes the nearest or the fastest, there is a kink.
            smooth = np.abs(ahead - 2.0 * middle + behind) < 1e-3 * step
            slopes = (ahead - behind) / (2.0 * step)
            off = np.abs(slopes - jacobian[:, column])[smooth]
            assert off.max(initial=0.0) < 1e-5
            compared += int(smooth.sum())
    assert compared > 500


def inside(planar, values):
    points = values.reshape(-1, 3)
    return bool(((points >= planar.joints.lower) & (points <= planar.joints.upper)).all())


def test_a_path_that_satisfies_the_constraint_is_proved(planar):
    proved = 0
    for seed in range(60):
        path = path_of(planar, seed, size=0.1)
        constraint = PathClearanceConstraint(planar.checker, len(path), 0.02)
        if constraint.CheckSatisfied(path.ravel(), tol=0.0):
            proved += 1
            check = check_path(planar.scene_graph, planar.joints, path, min_distance=0.02 - 1e-9)
            assert check.outcome == 'clear'
    assert proved > 5


@pytest.mark.parametrize(
    ('path', 'words'),
    [
        (np.zeros((1, 3)), r'\(1, 3\)'),
        (np.zeros((2, 4)), r'\(2, 4\)'),
        ([[0, 0, 0], [9, 0, 0]], 'way point 1: arm::shoulder = 9 is outside'),
        ([[0, 0, 0], [np.nan, 0, 0]], 'finite'),
    ],
)
def test_paths_that_are_none_are_refused(planar, path, words):
    with pytest.raises(ArgumentError, match=words):
        path_clearance(planar.checker, path)


def test_bad_arguments_are_refused(planar):
    path = np.zeros((2, 3))
    for pieces in (0, 1.5):
        with pytest.raises(ArgumentError, match='pieces='):
            path_clearance(planar.checker, path, pieces)
    for arguments in ((1, 0.0), (2, np.nan), (2, 0.0, 0)):
        with pytest.raises(ArgumentError, match='way_points='):
            PathClearanceConstraint(planar.checker, *arguments)
    constraint = PathClearanceConstraint(planar.checker, 2, 0.0)
    with pytest.raises(ArgumentError, match=r'\(6,\)'):
        constraint.Eval(path)


# Splines through way points.


def spline_of(planar, seed, count=5):
    """Return times, and way points of which the spline stays within the limits."""
    rng = np.random.default_rng(seed)
    spline = ClampedCubicSpline(np.cumsum(rng.uniform(0.6, 1.0, count)))
    middle = 0.5 * (planar.joints.lower + planar.joints.upper)
    room = 0.2 * (planar.joints.upper - planar.joints.lower)
    return spline, middle + room * rng.uniform(-1.0, 1.0, (count, 3))


@given(seed=st.integers(0, 2**31), pieces=st.integers(1, 6))
def test_no_state_on_a_spline_is_nearer_than_the_bound(planar, seed, pieces):
    spline, path = spline_of(planar, seed)
    found = path_clearance(planar.checker, path, pieces, spline=spline)
    # The truth is that of the trajectory as a controller executes it.
    curve = JointSpline(spline.trajectory(path))
    states = spline.states(path, 60 * pieces)
    times = np.linspace(spline.times[:-1], spline.times[1:], 60 * pieces + 1)[:-1].T.ravel()
    np.testing.assert_allclose(
        states[:-1], [curve.value(time) for time in times], rtol=0, atol=1e-12
    )
    clearances, _ = planar.checker.clearance_and_gradient(states)
    each = clearances[:-1].reshape(len(path) - 1, pieces, 60)
    assert (found.lower_bound <= each.min(axis=2) + 1e-12).all()
    np.testing.assert_allclose(found.clearance, clearances[::60], rtol=0, atol=1e-9)


@given(seed=st.integers(0, 2**31))
def test_joints_travel_as_far_as_fine_steps_add_up_to(planar, seed):
    spline, path = spline_of(planar, seed)
    travel = spline.travel(path, 2)
    fine = np.abs(np.diff(spline.states(path, 4000), axis=0)).reshape(len(path) - 1, 2, 2000, 3)
    assert (travel.length >= fine.sum(axis=2) - 1e-12).all()
    np.testing.assert_allclose(travel.length, fine.sum(axis=2), rtol=0, atol=1e-5)


def test_gradients_of_splines_are_central_differences(planar):
    step, compared = 1e-6, 0
    for seed in range(8):
        spline, path = spline_of(planar, seed)
        constraint = PathClearanceConstraint(planar.checker, len(path), 0.0, 3, spline=spline)
        jacobian, middle = constraint.Jacobian(path.ravel()), constraint.Eval(path.ravel())
        for column in range(path.size):
            moved = [path.flatten(), path.flatten()]
            for sign, values in zip((1.0, -1.0), moved, strict=True):
                values[column] += sign * step
            ahead, behind = (constraint.Eval(values) for values in moved)
            # Where another pair becomes the nearest or the fastest, there is a kink.
            smooth = np.abs(ahead - 2.0 * middle + behind) < 1e-3 * step
            slopes = (ahead - behind) / (2.0 * step)
            off = np.abs(slopes - jacobian[:, column])[smooth]
            assert off.max(initial=0.0) < 1e-5
            compared += int(smooth.sum())
    assert compared > 500


def test_a_spline_that_satisfies_the_constraint_is_proved(planar):
    proved = 0
    for seed in range(40):
        spline, path = spline_of(planar, seed)
        path = path[0] + 0.1 * (path - path[0])
        constraint = PathClearanceConstraint(planar.checker, len(path), 0.02, spline=spline)
        if constraint.CheckSatisfied(path.ravel(), tol=0.0):
            proved += 1
            trajectory = spline.trajectory(path)
            check = check_trajectory(
                planar.scene_graph, planar.joints, trajectory, min_distance=0.02 - 1e-9
            )
            assert check.outcome == 'clear'
    assert proved > 5


def test_a_spline_that_overshoots_its_limits_is_refused(planar):
    spline = ClampedCubicSpline([0.0, 1.0, 2.0, 3.0])
    path = [[0, 0, 0], [2.9, 0, 0], [2.9, 0, 0], [0, 0, 0]]
    with pytest.raises(ArgumentError, match='between way points arm::shoulder goes from'):
        path_clearance(planar.checker, path, spline=spline)
    with pytest.raises(ArgumentError, match='4 times and path 2 way points'):
        path_clearance(planar.checker, path[:2], spline=spline)
    for times in ([0.0], [0.0, 0.0], [0.0, np.nan]):
        with pytest.raises(ArgumentError, match='grow'):
            ClampedCubicSpline(times)
