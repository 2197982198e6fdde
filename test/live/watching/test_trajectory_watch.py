"""A trajectory that runs is judged again whenever the scene changes, and then alone."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from live.services.test_motions import answer, trajectory
from live.watching.watched_arm import BEGIN, FAR, STALE_AFTER, Cell, distance_to, joint_trajectory

from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    GeometryFrame,
    GeometryInstance,
    GeometrySet,
    ProximityProperties,
    Sphere,
)
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.scene.changes.removal import removal
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.trajectories import JointSpline, JointTrajectory

NOTHING, CLEAR, CONTACT, UNKNOWN = range(4)
ROWS = [(0.0, 0.0, 0.1), (0.8, 0.0, 0.1), (1.6, 0.0, 0.1)]  # a turn of the shoulder
TIMES = (0.0, 1.0, 2.0)
STILL = [(0.0, 0.0, 0.0)] * 3
IN_THE_WAY = (math.cos(1.2), math.sin(1.2), 1.0)  # of the hand at a shoulder of 1.2
SCAN = 2000
ROUNDING = 1e-9  # [s] of the scan


@pytest.fixture
def cell(tmp_path):
    cell = Cell(tmp_path)
    cell.push(FAR)
    cell.stand(ROWS[0])
    return cell


def turn(**fields):
    return joint_trajectory(ROWS, TIMES, STILL, **fields)


SPLINE = JointSpline(JointTrajectory(TIMES, ROWS, STILL))


def first_touch(spline, p_WB, begin=0.0, least=0.0):
    """Return the time [s] of the first state of a fine scan that is no farther, inf: none."""
    times = np.linspace(begin, spline.times[-1], SCAN)
    near = [t for t in times.tolist() if distance_to(p_WB, spline.value(t)) <= least]
    return near[0] if near else math.inf


def run_until(cell, elapsed, spline=SPLINE):
    """Let the arm follow, with the ball where it is."""
    cell.clock.now = BEGIN + elapsed
    cell.stand(spline.value(elapsed))


def test_a_ball_pushed_into_the_way_is_told_with_the_time_of_the_first_touch(cell):
    name = cell.begin(turn())
    told = cell.look()
    assert (told.names, list(told.outcome)) == ([name], [CLEAR])
    assert list(told.times) == [2.0, 2.0]
    assert told.trouble == ['']
    run_until(cell, 0.5)
    cell.push(IN_THE_WAY)
    told = cell.look()
    assert list(told.outcome) == [CONTACT]
    touch = first_touch(SPLINE, IN_THE_WAY, 0.5)
    assert told.times[0] <= touch <= told.times[1] + 2.0 / SCAN
    assert told.times[1] - told.times[0] <= 1e-6
    assert list(told.last_free) == [told.times[0]]
    assert list(told.now) == [0.5]
    assert 'cell::free/ball' in (*told.geometry_a, *told.geometry_b)
    assert len(cell.warnings) == 1
    assert 'contact of' in cell.warnings[0]
    # What is behind the arm is in nobody's way.
    run_until(cell, 1.9)
    cell.push((math.cos(0.2), math.sin(0.2), 1.0))
    told = cell.look()
    assert list(told.outcome) == [CLEAR]
    assert told.lower_bound[0] > 0.0


def test_it_is_what_check_motion_says_of_the_same_way(cell):
    cell.push(IN_THE_WAY)
    cell.begin(turn(), min_distance=0.03)
    told = cell.look()
    stated = {'velocities': [0.0] * 3}
    expected = answer(
        cell.live, path=trajectory(ROWS, TIMES, **stated), min_distance=0.03, profile='spline'
    )
    assert list(told.outcome) == [expected.outcome] == [CONTACT]
    np.testing.assert_allclose(told.times, expected.times, rtol=0, atol=2e-6)
    assert {*told.id_a, *told.id_b} == {expected.id_a, expected.id_b}
    assert math.isclose(told.distance[0], expected.distance, abs_tol=1e-5)


@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 10**6), least=st.sampled_from([0.0, 0.05]))
def test_nothing_is_clear_that_a_fine_scan_finds_near(tmp_path_factory, seed, least):
    rng = np.random.default_rng(seed)
    cell = Cell(tmp_path_factory.mktemp('arm'))
    rows = rng.uniform([-0.9, -2.0, 0.09], [1.9, 2.0, 0.1], size=(4, 3))
    speeds = rng.normal(0.0, 0.3, size=(4, 3))
    times = np.cumsum(rng.uniform(0.2, 0.6, size=4)) - 0.2
    times[0] = 0.0
    spline = JointSpline(JointTrajectory(times, rows, speeds))
    cell.push(FAR)
    cell.stand(rows[0])
    path = joint_trajectory(rows, times, speeds)
    cell.begin(path, min_distance=least, ignore_limits=True)
    for elapsed in np.sort(rng.uniform(0.0, times[-1], size=3)).tolist():
        run_until(cell, elapsed, spline)
        ball = rng.normal([0.5, 0.3, 1.0], 0.8)
        cell.push(ball)
        told = cell.look()
        touch = first_touch(spline, ball, elapsed, least)
        slack = 2.0 * times[-1] / SCAN
        if told.outcome[0] == CLEAR:
            assert touch == math.inf
            assert told.lower_bound[0] > least
        else:
            # The arm may meet itself: of the ball alone the scan knows.
            assert told.last_free[0] <= touch + ROUNDING
            if 'cell::free/ball' in (*told.geometry_a, *told.geometry_b):
                assert told.outcome[0] == CONTACT
                at = spline.value(told.times[1])
                assert distance_to(ball, at) <= least + 1e-5
                assert touch <= told.times[1] + slack or touch == math.inf


def test_nothing_is_computed_where_nothing_changed(cell):
    cell.begin(turn())
    cell.look()
    assert cell.watch.judgements == 1
    published = len(cell.topic.published)
    for elapsed in np.linspace(0.0, 1.5, 30).tolist():
        run_until(cell, elapsed)
        cell.push(FAR)  # again, where it is
        cell.look()
    assert cell.watch.judgements == 1
    assert len(cell.did) == 1
    assert len(cell.topic.published) == published


def register_ball(cell):
    with cell.live.editing() as scene:
        source = scene.model.names.source('cell')

        def add(graph, _):
            frame = graph.RegisterFrame(source, GeometryFrame('another'))
            body = GeometryInstance(RigidTransform(), Sphere(0.1), 'ball')
            body.set_proximity_properties(ProximityProperties())
            graph.RegisterGeometry(source, frame, body)
            return frame

        scene.make(Change(add))
        poses = {('cell', 'another'): RigidTransform([5.0, 5.0, 5.0])}
        scene.poses.put(poses)


def declare_filter(cell):
    with cell.live.editing() as scene:
        names = scene.model.names
        pair = GeometrySet([names.geometry('free/ball'), names.geometry('hand/collision_0')])
        manager = scene.model.scene_graph.collision_filter_manager()
        manager.Apply(CollisionFilterDeclaration().ExcludeWithin(pair))


def remove_ball(cell):
    with cell.live.editing() as scene:
        scene.make(removal(scene, scene.model.names.source('cell')))


@pytest.mark.parametrize(
    'change',
    [
        lambda cell: cell.push((8.0, 8.0, 8.0)),
        register_ball,
        declare_filter,
        remove_ball,
    ],
)
def test_each_change_of_the_scene_is_judged_once(cell, change):
    cell.begin(turn())
    cell.look()
    before = cell.watch.judgements
    change(cell)
    cell.look()
    cell.look()
    assert cell.watch.judgements == before + 1


def test_other_joints_of_the_robot_count(cell):
    rows, still = [row[:1] for row in ROWS], [row[:1] for row in STILL]
    cell.begin(joint_trajectory(rows, TIMES, still, names=['shoulder']))
    cell.look()
    before = cell.watch.judgements
    cell.stand([0.095], ['finger'])
    cell.look()
    assert cell.watch.judgements == before + 1
    cell.stand([0.095], ['finger'])
    cell.stand([0.0], ['shoulder'])
    cell.look()
    assert cell.watch.judgements == before + 1


def test_it_ends_by_itself_and_is_told_so_once(cell):
    cell.begin(turn(), name='way')
    cell.look()
    run_until(cell, 2.0)
    told = cell.look()
    assert (told.names, told.ended, list(told.outcome)) == (['way'], [True], [CLEAR])
    published = len(cell.topic.published)
    cell.look()
    assert len(cell.topic.published) == published
    with pytest.raises(RuntimeError, match=r"no trajectory 'way' is watched.*none"):
        cell.end('way')


def test_unwatched_it_is_gone(cell):
    cell.begin(turn(), name='way')
    cell.look()
    cell.end('way')
    assert cell.look().names == []


def test_stale_joints_and_stale_poses_are_told_and_never_clear(cell):
    cell.begin(turn())
    assert list(cell.look().outcome) == [CLEAR]
    cell.clock.now += 1.1 * STALE_AFTER
    told = cell.look()
    assert list(told.outcome) == [UNKNOWN]
    assert 'no value of now came of shoulder, wrist, finger' in told.trouble[0]
    assert list(told.lower_bound) == [-math.inf]
    assert told.last_free[0] == told.now[0]
    cell.stand(SPLINE.value(cell.clock.now - BEGIN))  # the ball is silent still
    told = cell.look()
    assert list(told.outcome) == [UNKNOWN]
    assert told.trouble == ['poses are stale: cell::free']
    cell.push(FAR)
    told = cell.look()
    assert (list(told.outcome), told.trouble) == ([CLEAR], [''])


def test_joints_that_leave_the_trajectory_are_told_and_never_clear(cell):
    cell.begin(turn(), deviation_tolerance=0.02)
    cell.clock.now += 0.4
    off = SPLINE.value(0.4) + np.array([0.03, 0.0, 0.0])
    cell.push(FAR)
    cell.stand(off)
    told = cell.look()
    assert list(told.outcome) == [UNKNOWN]
    assert told.deviates == [True]
    assert math.isclose(told.deviation[0], 0.03, abs_tol=1e-9)
    assert told.deviating_joint[0].endswith('shoulder')
    assert 'is farther from the trajectory' in told.trouble[0]
    cell.stand(SPLINE.value(0.4))
    assert list(cell.look().outcome) == [CLEAR]


def test_values_are_compared_at_the_time_of_their_stamps(cell):
    cell.begin(turn(), deviation_tolerance=1e-6)
    cell.clock.now += 1.0
    cell.push(FAR)
    cell.stand(SPLINE.value(0.75), at=BEGIN + 0.75)
    told = cell.look()
    assert list(told.outcome) == [CLEAR]
    assert told.deviates == [False]


def test_a_turn_more_of_a_continuous_joint_is_the_same_place(cell):
    cell.begin(turn())
    cell.stand([0.0, 2.0 * math.pi, 0.1])
    assert list(cell.look().outcome) == [CLEAR]


def test_a_robot_that_is_removed_ends_it_with_a_trouble(cell):
    cell.begin(turn())
    cell.look()
    with cell.live.editing() as scene:
        scene.make(removal(scene, scene.model.names.source('arm')))
    told = cell.look()
    assert (told.ended, list(told.outcome)) == ([True], [NOTHING])
    assert 'there is no joint' in told.trouble[0]


def test_a_jump_of_the_clock_ends_it_with_a_trouble(cell):
    cell.begin(turn())
    cell.look()
    cell.live.clocks.begin_anew()
    told = cell.look()
    assert (told.ended, list(told.outcome)) == ([True], [NOTHING])
    assert "the node's time jumped" in told.trouble[0]


def test_time_that_rests_is_no_progress(cell):
    """As simulated time does where it is paused."""
    cell.begin(turn())
    for _ in range(3):
        assert cell.look().ended == [False]
    assert cell.watch.judgements == 1


@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
@given(budget=st.floats(1e-9, 0.02), ball=st.sampled_from([FAR, IN_THE_WAY]))
def test_what_a_budget_proves_is_the_beginning_of_the_truth(tmp_path_factory, budget, ball):
    cell = Cell(tmp_path_factory.mktemp('arm'))
    cell.push(ball)
    cell.stand(ROWS[0])
    cell.begin(turn(), time_budget=budget)
    told = cell.look()
    assert told.last_free[0] <= first_touch(SPLINE, ball)
    if told.outcome[0] == UNKNOWN:
        assert 'time_budget' in told.trouble[0]
    else:
        assert told.outcome[0] == (CLEAR if ball == FAR else CONTACT)


def test_a_budget_that_is_used_up_says_so(cell):
    times = np.linspace(0.0, 2.0, 50)
    cell.begin(joint_trajectory([SPLINE.value(t) for t in times], times), time_budget=1e-9)
    told = cell.look()
    assert list(told.outcome) == [UNKNOWN]
    assert told.last_free[0] < 2.0
    assert told.trouble == ['the time_budget of 1e-09 s was not enough']


def test_it_may_begin_later_and_have_begun_before(cell):
    cell.begin(turn(stamp=BEGIN + 1.0), name='later')
    cell.stand(SPLINE.value(0.5))  # that of 'begun', which is another way for 'later'
    cell.begin(turn(stamp=BEGIN - 0.5), name='begun')
    told = cell.look()
    assert list(told.now) == [0.0, 0.5]
    assert told.deviates == [True, False]
    assert list(told.outcome) == [UNKNOWN, CLEAR]
    assert 'counts as standing' in told.trouble[1]


def test_a_first_point_that_comes_later_is_reached_from_where_the_joints_are(cell):
    aside = (math.cos(-0.5), math.sin(-0.5), 1.0)
    cell.push(aside)
    cell.stand((-0.9, 0.0, 0.1))
    cell.begin(joint_trajectory(ROWS, (1.0, 2.0, 3.0)))
    told = cell.look()
    assert list(told.outcome) == [CONTACT]
    assert 0.0 < told.times[0] < 1.0


def test_contacts_of_now_may_be_left_out(cell):
    cell.push((1.0, 0.0, 1.0))
    cell.begin(turn())
    assert list(cell.look().outcome) == [CONTACT]
    cell.begin(turn(), name='trajectory_1', ignore_start_contacts=True)
    assert list(cell.look().outcome) == [CLEAR]


def test_foreign_joints_are_named(cell):
    rows = [(*row, 0.0) for row in ROWS]
    path = joint_trajectory(rows, TIMES, names=['shoulder', 'wrist', 'finger', 'tail'])
    with pytest.raises(RuntimeError, match="no joint 'tail'"):
        cell.begin(path)
    cell.begin(path, ignore_foreign_joints=True)
    told = cell.look()
    assert list(told.outcome) == [CLEAR]
    assert told.trouble == ['left out, since no robot has them: tail']


@pytest.mark.parametrize(
    ('path', 'fields', 'words'),
    [
        (turn(), {'min_distance': -1.0}, 'min_distance is -1'),
        (turn(), {'time_budget': math.inf}, 'time_budget is inf'),
        (turn(), {'deviation_tolerance': -0.1}, 'deviation_tolerance is -0.1'),
        (turn(), {'accuracy': 'best'}, "accuracy='best'"),
        (turn(), {'profile': 'curve'}, "profile is 'curve'"),
        (turn(), {'name': 'x' * 1000}, 'name has 1000 characters'),
        (turn(stamp=BEGIN - 9.0), {}, 'the last point of path was reached 7.000 s ago'),
        (turn(stamp=BEGIN + 1e6), {}, 'the time of another clock'),
        (joint_trajectory(ROWS, (0, 0, 0)), {}, 'no point of path has a time_from_start'),
        (joint_trajectory(ROWS, (0, 2, 1)), {}, 'times must be'),
        (joint_trajectory([], ()), {}, 'no points'),
        (joint_trajectory([(0, 0, 0.1), (2.5, 0, 0.1)], (0, 1)), {}, 'outside its limits'),
        (joint_trajectory([(0, 0)], (1,), names=['shoulder', 'knee']), {}, "no joint 'knee'"),
    ],
)
def test_what_cannot_be_watched_is_refused_and_what_runs_goes_on(cell, path, fields, words):
    cell.begin(turn(), name='way')
    cell.look()
    with pytest.raises(RuntimeError, match=words):
        cell.begin(path, **{'name': 'way', **fields})
    told = cell.look()
    assert (told.names, told.ended) == (['way'], [False])
    assert cell.watch.judgements == 1


def test_without_a_clock_nothing_is_watched(cell):
    cell.clock.now = 0.0
    with pytest.raises(RuntimeError, match='use_sim_time'):
        cell.begin(turn())
