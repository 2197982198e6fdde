"""Splines of joints in a scene: against fine scans of their own polynomials, and closed forms."""

import math

import numpy as np
import pytest
from batch.conftest import cell_off_the_floor
from batch.test_path_edges import FAR, cart, row
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.batch import (
    Joints,
    PathChecker,
    cartesian_speed,
    check_path,
    check_trajectory,
    clearance_bounds,
    evaluate,
)
from drake_geom_ros.geometry import (
    ArgumentError,
    SceneGraph,
)
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.trajectories import JointSpline, JointTrajectory

SCAN = 400  # states a segment


@pytest.fixture(scope='module')
def cell():
    """Return the cell, in which the arm's base touches the floor and nobody counts it."""
    return cell_off_the_floor()


def trajectory_of(cell, seed, kind, points, step):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.05, 1.0, points))
    start = cell.states(1, seed)[0]
    shape = points, cell.joints.count
    positions = start + np.cumsum(rng.normal(0, step, shape), axis=0)
    velocities, accelerations = rng.normal(0, 3 * step, (2, *shape))
    return JointTrajectory(
        times,
        positions,
        None if kind == 'straight' else velocities,
        accelerations if kind == 'quintic' else None,
    )


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    kind=st.sampled_from(['cubic', 'quintic']),
    points=st.integers(2, 5),
    step=st.sampled_from([1e-3, 0.1, 0.5]),
    least=st.sampled_from([0.0, 0.02]),
)
def test_splines_against_a_fine_scan(cell, seed, kind, points, step, least):
    trajectory = trajectory_of(cell, seed, kind, points, step)
    check = check_trajectory(cell.scene_graph, cell.joints, trajectory, least, ignore_limits=True)
    spline = JointSpline(trajectory)
    parts = [np.linspace(a, b, SCAN) for a, b in zip(spline.times, spline.times[1:], strict=False)]
    times = np.concatenate(parts)
    states = np.array([spline.value(time) for time in times])
    found = evaluate(cell.scene_graph, states=states, joints=cell.joints, want='least')
    upper = found.distance + found.error_bound + 1e-12
    near = times[upper <= least]
    if check.outcome == 'clear':
        assert not len(near)
        assert least < check.lower_bound <= upper.min()
        assert check.times == (spline.times[-1],) * 2
        return
    assert not (near < check.last_free).any()
    if check.outcome == 'contact':
        assert check.times[1] - check.times[0] <= 1.001e-6
        assert check.distance + check.error_bound <= least
        seen = evaluate(
            cell.scene_graph,
            states=spline.value(check.time)[None],
            joints=cell.joints,
            want='least',
        )
        assert seen.distance[0] - seen.error_bound[0] <= least + 1e-9


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10**6), points=st.integers(1, 4))
def test_without_velocities_a_trajectory_is_a_path(cell, seed, points):
    trajectory = trajectory_of(cell, seed, 'straight', points, 0.3)
    spline = check_trajectory(cell.scene_graph, cell.joints, trajectory, ignore_limits=True)
    path = check_path(cell.scene_graph, cell.joints, trajectory.positions, ignore_limits=True)
    assert spline.outcome == path.outcome
    if path.outcome != 'clear':
        times, rows = np.asarray(trajectory.times), np.arange(points)
        # Either may end anywhere within its tolerance.
        assert spline.times[1] == pytest.approx(np.interp(path.times[1], rows, times), abs=3e-6)


def test_a_swing_between_two_equal_points_is_followed_and_not_its_chord(tmp_path):
    """The joint leaves 0 by v t (1 - t), to the angle v / 4, and meets a post at 1 rad."""
    _, joints = cart(tmp_path, 'fixed')
    post = f'[{math.cos(1.0)}, {math.sin(1.0)}, 0]'
    (tmp_path / 'scene.yaml').write_text(FAR.replace('[1000, 0, 0]', post))
    graph = SceneGraph()
    joints = Joints.of(load_scene(tmp_path / 'scene.yaml', graph))
    rows = np.array([row(joints), row(joints)])
    swings = [np.array([row(joints, turn=v), row(joints, turn=-v)]) for v in (8.0, 3.0)]
    wide, narrow = (JointTrajectory([0.0, 1.0], rows, swing) for swing in swings)
    assert check_path(graph, joints, rows).outcome == 'clear'
    assert check_trajectory(graph, joints, narrow).outcome == 'clear'
    check = check_trajectory(graph, joints, wide)
    # The balls touch while their centres on the circle of 1 m are 0.2 m apart.
    angle = 1.0 - 2.0 * math.asin(0.1)
    touching = 0.5 - math.sqrt(0.25 - angle / 8.0)
    assert check.outcome == 'contact'
    assert check.times[0] <= touching + 1e-9
    assert check.times[1] >= touching - 1e-9


def test_the_time_of_a_contact_is_that_of_the_cubic(tmp_path):
    """A base slides by 3 s^2 - 2 s^3 of 998.5 m towards a post; balls touch after 998.3 m."""
    graph, joints = cart(tmp_path, 'planar')
    slide = next(name for name in joints.names if name.endswith('base/x'))
    column = joints.names.index(slide)
    rows = np.zeros((2, joints.count))
    rows[1, column] = 998.5
    trajectory = JointTrajectory([0.0, 2.0], rows, np.zeros_like(rows))
    check = check_trajectory(graph, joints, trajectory, time_tolerance=1e-9, ignore_limits=True)
    assert check.outcome == 'contact'
    # The hand at 1.5 m from the base touches the post at 1000 m: x = 1000 - 0.2 - 1.5.
    s = float(check.times[1]) / 2.0
    x = 998.5 * (3 * s**2 - 2 * s**3)
    assert math.isclose(x, 998.3, abs_tol=1e-6)


def test_a_spline_that_overshoots_a_limit_is_refused_with_time_and_value(cell):
    joints = cell.joints
    column = int(np.argmax(np.isfinite(joints.upper)))
    rest = 0.5 * (joints.lower.clip(-3) + joints.upper.clip(max=3))
    rows = np.tile(rest, (2, 1))
    rows[:, column] = joints.upper[column] - 0.1
    velocities = np.zeros_like(rows)
    velocities[0, column], velocities[1, column] = 1.0, -1.0
    trajectory = JointTrajectory([0.0, 1.0], rows, velocities)
    with pytest.raises(ArgumentError, match=rf'{joints.names[column]} to .* at 0.5 s, between'):
        check_trajectory(cell.scene_graph, joints, trajectory)
    check_trajectory(cell.scene_graph, joints, trajectory, ignore_limits=True)


def within(cell, trajectory, seconds=math.inf, must_stop=lambda: False, **options):
    options = {'ignore_limits': True, 'ignore_start_contacts': True, **options}
    with PathChecker(cell.scene_graph, cell.joints, **options) as checker:
        return checker.check_spline_within(JointSpline(trajectory), seconds, must_stop)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), kind=st.sampled_from(['cubic', 'quintic']))
def test_part_by_part_the_answer_is_that_of_the_whole(cell, seed, kind):
    trajectory = trajectory_of(cell, seed, kind, 20, 0.05)
    options = {'ignore_limits': True, 'ignore_start_contacts': True}
    with PathChecker(cell.scene_graph, cell.joints, **options) as checker:
        whole = checker.check_spline(JointSpline(trajectory))
    parts = within(cell, trajectory)
    assert (parts.outcome, parts.times, parts.id_A) == (whole.outcome, whole.times, whole.id_A)
    assert parts.ignored == whole.ignored
    assert parts.lower_bound == whole.lower_bound


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), seconds=st.floats(1e-9, 0.01))
def test_what_a_time_allows_is_the_beginning_of_the_answer(cell, seed, seconds):
    trajectory = trajectory_of(cell, seed, 'cubic', 60, 0.02)
    whole, some = within(cell, trajectory), within(cell, trajectory, seconds)
    assert some.times[0] <= whole.times[0]
    if some.outcome != 'unknown':
        assert (some.outcome, some.times) == (whole.outcome, whole.times)
    elif whole.outcome != 'unknown':
        assert some.id_A is None or some.times[0] > 0.0
        assert some.times[1] == 59.0
    # And the checker goes on as if nothing had been stopped.
    assert within(cell, trajectory).times == whole.times


def test_it_stops_when_it_must(cell):
    with pytest.raises(InterruptedError):
        within(cell, trajectory_of(cell, 3, 'cubic', 60, 0.02), must_stop=lambda: True)


@settings(max_examples=15, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    kind=st.sampled_from(['straight', 'cubic', 'quintic']),
    intervals=st.integers(1, 12),
)
def test_clearances_are_below_those_of_a_fine_scan_and_near_them(cell, seed, kind, intervals):
    trajectory = trajectory_of(cell, seed, kind, 3, 0.1)
    found = clearance_bounds(cell.scene_graph, cell.joints, trajectory, intervals)
    assert len(found.times) == intervals + 1
    spline = JointSpline(trajectory)
    assert found.times[[0, -1]].tolist() == spline.times[[0, -1]].tolist()
    for begin, end, bound in zip(found.times, found.times[1:], found.clearances, strict=False):
        states = np.array([spline.value(time) for time in np.linspace(begin, end, SCAN)])
        scan = evaluate(cell.scene_graph, states=states, joints=cell.joints, want='least')
        least = (scan.distance + scan.error_bound).min()
        if bound == -math.inf:
            assert least < 1e-3
        else:
            assert 0.0 < bound <= least + 1e-12
            assert bound >= least - 2e-3


def test_intervals_must_be_some(cell):
    trajectory = trajectory_of(cell, 1, 'cubic', 3, 0.1)
    with pytest.raises(ArgumentError, match='intervals=0'):
        clearance_bounds(cell.scene_graph, cell.joints, trajectory, 0)


def points_of(cell, states):
    """Return points of all geometries that states move (N, n, 3): where their frames are."""
    return cell.joints.poses(states)[:, :, :3]


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), kind=st.sampled_from(['straight', 'cubic', 'quintic']))
def test_no_point_is_faster_than_the_cartesian_speed(cell, seed, kind):
    trajectory = trajectory_of(cell, seed, kind, 4, 0.2)
    bound = cartesian_speed(cell.scene_graph, cell.joints, trajectory)
    spline = JointSpline(trajectory)
    times = np.linspace(spline.times[0], spline.times[-1], 500)
    points = points_of(cell, np.array([spline.value(time) for time in times]))
    speeds = np.linalg.norm(np.diff(points, axis=0), axis=2) / np.diff(times)[:, None]
    assert speeds.max() <= bound.speed * (1.0 + 1e-9)
    assert bound.speed <= 20.0 * speeds.max()


def test_the_speed_of_a_turning_ball_is_that_of_its_farthest_point(tmp_path):
    (tmp_path / 'arm.urdf').write_text("""<robot name="arm"><link name="base"/>
<link name="tip"><collision><origin xyz="0.7 0 0"/><geometry><sphere radius="0.1"/></geometry>
</collision></link>
<joint name="turn" type="continuous"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
</joint></robot>""")
    scene_graph = SceneGraph()
    loaded = load_scene(
        f"""
sources: [cell]
robots: [{{name: arm, urdf: {tmp_path}/arm.urdf, pose: {{}}}}]
geometries:
- {{name: ball, source: cell, shape: {{type: sphere, radius: 0.1}}, pose: {{position: [9, 0, 0]}}}}
""",
        scene_graph,
    )
    joints = Joints.of(loaded)
    found = cartesian_speed(
        scene_graph, joints, JointTrajectory([0.0, 2.0, 3.0], [[0.0], [3.0], [3.5]])
    )
    assert found.speed == pytest.approx(1.5 * 0.8, rel=1e-9)
    assert loaded.name_of(found.geometry).startswith('arm::tip')
