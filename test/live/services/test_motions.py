"""``check_motion`` on a live scene, without ROS."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.inputs.test_joint_input import JOINTS_OF_ARM, state
from live.live_scenes import Clock, live_scene
from live.services.test_states import NO_POSES, cell_in

from drake_geom_ros.batch import Joints, PathChecker
from drake_geom_ros.geometry import (
    CollisionFilterDeclaration,
    GeometryFrame,
    GeometrySet,
    SceneGraph,
)
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.scene.change import Change
from drake_geom_ros.live.services.motions import OUTCOMES, check_motion
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.trajectories import JointSpline, JointTrajectory

CLEAR, CONTACT, UNKNOWN = 1, 2, 3
NAMES = [f'arm::{name}' for name in JOINTS_OF_ARM]
BOUNDS = [-1.0, -3.0, 0.08], [2.0, 3.0, 0.1]  # with less of it the fingers overlap
NOW = (1.0, 0.7, 0.1)  # of the joints
AT_POST = [2, 2, 5.2, 0, 0, 0, 1.0]  # above the arm
BEFORE_POST, BEHIND_POST = [0, 2, 5.2, 0, 0, 0, 1.0], [4, 2, 5.2, 0, 0, 0, 1.0]
FIRST_TOUCH = (2.0 - 0.1 - 0.1) / 4.0  # the ball of 0.1 meets the post of 0.2 by 0.2


@pytest.fixture
def text(tmp_path):
    return cell_in(tmp_path, 'adjacent_links: filtered')


@pytest.fixture
def live(text):
    """A scene in which the arm stands as no joint says, far from the ball."""
    live = live_scene(text, Clock(1000.0))
    joints = JointInput(live.clocks, 1.0, by_default=True)
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, NOW), 0.0)
    return live


@pytest.fixture
def checker(text):
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene(text, scene_graph), NAMES)
    return lambda **asked: PathChecker(scene_graph, joints, **asked)


def poses(**frames):
    rows = [number for pose in frames.values() for number in pose]
    return Plain(**{**vars(NO_POSES), 'frame_names': list(frames), 'poses': rows})


def trajectory(rows, times=None, names=JOINTS_OF_ARM, **fields):
    points = []
    for k, row in enumerate(rows):
        whole, part = divmod(round(1e9 * times[k]), 10**9) if times is not None else (0, 0)
        stated = {'velocities': [], 'accelerations': [], 'effort': [], **fields}
        points.append(
            Plain(positions=list(row), time_from_start=Plain(sec=whole, nanosec=part), **stated)
        )
    return Plain(joint_names=list(names), points=points)


NO_PATH = Plain(joint_names=[], points=[])


def joint_values(**values):
    return Plain(names=list(values), positions=list(values.values()))


def answer(live, **fields):
    given = {
        'start': NO_POSES,
        'end': NO_POSES,
        'start_joints': joint_values(),
        'path': NO_PATH,
        'min_distance': 0.0,
        'time_tolerance': 0.0,
        'interpolation': '',
        'max_evaluations': 0,
        'accuracy': '',
        'ignore_start_contacts': False,
        'ignore_limits': False,
        'profile': '',
        'start_tolerance': 0.0,
        'ignore_foreign_joints': False,
        'multi_dof_path': NO_PATH,
        'start_now': False,
        'approach_time': 0.0,
        'clearance_intervals': 0,
    }
    response = Plain(
        times=[0.0, 0.0],
        p_wca=Plain(),
        p_wcb=Plain(),
        geometry_a='',
        geometry_b='',
        id_a=0,
        id_b=0,
    )
    check_motion(live, Plain(**{**given, **fields}), response)
    return response


@pytest.mark.parametrize('interpolation', ['', 'slerp', 'screw'])
def test_a_ball_that_passes_through_a_post_meets_it_when_it_does(live, interpolation):
    found = answer(
        live,
        start=poses(free=BEFORE_POST),
        end=poses(free=BEHIND_POST),
        interpolation=interpolation,
    )
    assert found.outcome == CONTACT
    assert found.times[0] <= FIRST_TOUCH <= found.times[1] <= found.times[0] + 1e-6
    assert found.last_free == found.times[0]
    assert found.time == found.times[1]
    assert {found.geometry_a, found.geometry_b} == {'cell::world/post', 'cell::free/ball'}
    assert abs(found.distance) <= 1e-5
    assert math.isclose(found.p_wca.x, 1.9, abs_tol=1e-5)
    assert math.isclose(found.p_wcb.x, 1.9, abs_tol=1e-5)


def test_a_motion_begins_where_frames_are_now_and_moves_nothing(live):
    end = poses(free=AT_POST)
    before = answer(live, end=end)
    assert before.outcome == CONTACT
    assert answer(live, end=end).times == before.times
    # Beside the post, by more than the distance that is asked for, and by less.
    begin, end = ([x, 2.25, 5.2, 0, 0, 0, 1] for x in (0, 4))
    aside = {'start': poses(free=begin), 'end': poses(free=end)}
    found = answer(live, **aside, min_distance=0.04)
    assert found.outcome == CLEAR
    assert 0.04 < found.lower_bound <= 0.05
    assert found.times == [1.0, 1.0]
    assert answer(live, **aside, min_distance=0.06).outcome == CONTACT


def test_it_answers_what_the_core_answers(live, checker):
    rng = np.random.default_rng(3)
    kinds = set()
    asked = checker(min_distance=0.01)
    for _ in range(40):
        path = rng.uniform(*BOUNDS, size=(3, 3))
        expected = asked.check(path)
        # The tolerance is of a row, and there are two of them in a second.
        fields = {'min_distance': 0.01, 'time_tolerance': 0.5e-6}
        found = answer(live, path=trajectory(path), **fields)
        kinds.add(expected.outcome)
        assert found.outcome == OUTCOMES[expected.outcome]
        assert math.isclose(found.distance, expected.distance, abs_tol=1e-9)
        # The rows 0, 1 and 2 are the times 0, 0.5 and 1; both spans hold the first contact.
        assert found.times[0] <= 0.5 * expected.times[1]
        assert found.times[1] >= 0.5 * expected.times[0]
        if found.outcome == CLEAR:
            assert 0.01 < found.lower_bound <= found.distance + found.error_bound
    assert kinds >= {'clear', 'contact'}


def first_contact(checker, seed=3):
    """Return a path that touches, and what the core says of it."""
    rng = np.random.default_rng(seed)
    while True:
        path = rng.uniform(*BOUNDS, size=(3, 3))
        found = checker().check(path)
        if found.outcome == 'contact' and found.times[0] > 1.05:
            return path, found


def test_times_of_a_path_are_those_of_its_points(live, checker):
    path, expected = first_contact(checker)
    found = answer(live, path=trajectory(path, times=(0.0, 2.5, 12.5)), time_tolerance=1e-7)
    wanted = [2.5 + 10.0 * (t - 1.0) for t in expected.times]
    assert found.times[0] <= wanted[1]
    assert found.times[1] >= wanted[0]
    assert found.times[1] - found.times[0] <= 1e-7
    # What comes later is no matter of what came before.
    with_start = answer(
        live,
        path=trajectory(path[1:], times=(2.5, 12.5)),
        start_joints=joint_values(**dict(zip(JOINTS_OF_ARM, path[0], strict=True))),
        time_tolerance=1e-7,
    )
    assert vars(with_start) == {**vars(found), 'message': with_start.message}


def test_a_path_begins_where_the_joints_are(live, checker):
    for row in np.random.default_rng(5).uniform(*BOUNDS, size=(10, 3)):
        alone = answer(live, path=trajectory([row]))
        later = answer(live, path=trajectory([row], times=(1.0,)))
        both = answer(live, path=trajectory([NOW, row]))
        assert vars(alone) == vars(later) == vars(both)


def are_alike(one, other):
    """Tell whether two answers are the same but for the rounding of what stands still."""
    numbers = [[*each.times, each.distance, each.lower_bound] for each in (one, other)]
    same = (one.outcome, one.geometry_a) == (other.outcome, other.geometry_a)
    return same and np.allclose(*numbers, rtol=0, atol=1e-9)


def test_joints_that_are_not_named_stay(live, checker):
    rows = np.random.default_rng(7).uniform(*BOUNDS, size=(2, 3))
    rows[:, 1:] = NOW[1:]
    one = answer(live, path=trajectory(rows[:, :1], names=['arm::shoulder']))
    assert are_alike(one, answer(live, path=trajectory(rows)))
    rows[:, 1] = -0.4
    one = answer(
        live,
        path=trajectory(rows[:, :1], names=['shoulder']),
        start_joints=joint_values(wrist=-0.4),
    )
    assert are_alike(one, answer(live, path=trajectory(rows)))


def test_a_budget_that_is_spent_is_unknown(live, checker):
    path, _ = first_contact(checker)
    found = answer(live, path=trajectory(path), max_evaluations=1)
    assert found.outcome == UNKNOWN
    assert found.last_free < 1.0
    assert found.evaluations <= 1


def test_filters_hold(live):
    way = {'start': poses(free=BEFORE_POST), 'end': poses(free=BEHIND_POST)}
    with live.editing() as scene:
        names = scene.model.names
        manager = scene.model.scene_graph.collision_filter_manager()
        post, ball = (names.geometry(name) for name in ('world/post', 'free/ball'))
        manager.Apply(CollisionFilterDeclaration().ExcludeWithin(GeometrySet([post, ball])))
    assert answer(live, **way).outcome == CLEAR


def test_contacts_at_the_start_are_told_or_left_out(live):
    way = {'start': poses(free=AT_POST), 'end': poses(free=BEHIND_POST)}
    found = answer(live, **way)
    assert (found.outcome, found.times) == (CONTACT, [0.0, 0.0])
    left_out = answer(live, **way, ignore_start_contacts=True)
    assert (left_out.outcome, left_out.ignored) == (CLEAR, 1)


@pytest.mark.parametrize(
    ('fields', 'words'),
    [
        ({}, 'end and path are both empty'),
        ({'end': poses(free=AT_POST), 'path': trajectory([[0, 0, 0]])}, 'are both given'),
        ({'end': poses(nobody=AT_POST)}, "no frame 'nobody'"),
        ({'end': poses(free=[math.nan] * 7)}, 'pose'),
        ({'end': poses(free=AT_POST), 'start': poses(nobody=AT_POST)}, "no frame 'nobody'"),
        ({'end': poses(free=AT_POST), 'min_distance': math.nan}, 'min_distance'),
        ({'end': poses(free=AT_POST), 'min_distance': -1.0}, 'min_distance'),
        ({'end': poses(free=AT_POST), 'time_tolerance': math.nan}, 'time_tolerance is nan'),
        ({'end': poses(free=AT_POST), 'time_tolerance': -1.0}, 'time_tolerance is -1'),
        ({'end': poses(free=AT_POST), 'interpolation': 'spline'}, "interpolation='spline'"),
        ({'end': poses(free=AT_POST), 'accuracy': 'good'}, "accuracy='good'"),
        ({'end': poses(free=AT_POST), 'ignore_limits': True}, 'ignore_limits is of a motion of j'),
        ({'path': trajectory([[0, 0, 0]]), 'interpolation': 'screw'}, 'it is of a motion of fr'),
        ({'path': trajectory([], names=['wrist'])}, 'no points'),
        ({'path': trajectory([[0.0]], names=['elbow'])}, "no joint 'elbow'"),
        ({'path': trajectory([[0.0, 0.0]], names=['wrist', 'wrist'])}, 'named twice'),
        ({'path': trajectory([[0.0, 0.0]])}, 'point 0 of path has 2 positions for 3 joints'),
        ({'path': trajectory([[0, 0, 0], [0, math.nan, 0]])}, 'point 1 of path: wrist = nan'),
        (
            {'path': trajectory([[0, 0, 0]], velocities=[1, 1, 1])},
            'no time_from_start: a spline needs times',
        ),
        (
            {'path': trajectory([NOW, NOW], times=(0, 1), velocities=[1, 1])},
            'point 0 of path has 2 velocities for 3 joints',
        ),
        (
            {'path': trajectory([NOW, NOW], times=(0, 1), accelerations=[1, 1, 1])},
            'accelerations and no velocities',
        ),
        (
            {'path': trajectory([NOW, NOW], times=(0, 1), velocities=[math.inf, 1, 1])},
            'they must be finite',
        ),
        ({'path': trajectory([NOW, NOW]), 'profile': 'cubic'}, "profile is 'cubic'"),
        ({'path': trajectory([NOW, NOW]), 'profile': 'spline'}, 'a spline needs times'),
        ({'path': trajectory([NOW, NOW]), 'start_tolerance': -1.0}, 'start_tolerance is -1'),
        ({'path': trajectory([NOW, NOW]), 'start_tolerance': math.nan}, 'start_tolerance is nan'),
        (
            {'path': trajectory([[1.0, 0.72, 0.1], NOW], times=(0, 1), velocities=[0, 0, 0])},
            r'path begins with wrist = 0.72, and the joint is at 0.7 now',
        ),
        (
            {'path': trajectory([[1.0, 0.701, 0.1], NOW]), 'start_tolerance': 1e-4},
            r'path begins with wrist = 0.701',
        ),
        (
            {'path': trajectory([[0.0]], names=['elbow']), 'ignore_foreign_joints': True},
            'path is of elbow, none of which is a joint of the scene',
        ),
        ({'end': poses(free=AT_POST), 'profile': 'spline'}, 'profile is of a motion of joints'),
        ({'path': trajectory([[0, 0, 0]] * 2, times=(1.0, 1.0))}, 'point 1 of path has the time'),
        ({'path': trajectory([[0, 0, 0]] * 2, times=(1.0, 0.0))}, 'point 1 of path has the time'),
        ({'path': trajectory([[5.0, 0, 0]] * 2)}, 'shoulder = 5; it is outside its limits'),
        (
            {'path': trajectory([[0, 0, 0]] * 2), 'start_joints': joint_values(wrist=0.3)},
            'start_joints give wrist a value',
        ),
        (
            {'path': trajectory([[0.0]], names=['wrist']), 'start': poses(hand=AT_POST)},
            'joints move arm::hand, and poses pose them',
        ),
        (
            {'path': trajectory([[0.0]], names=['wrist']), 'start_joints': joint_values(elbow=1)},
            "no joint 'elbow'",
        ),
    ],
)
def test_what_cannot_be_meant_is_refused(live, fields, words):
    with pytest.raises(RuntimeError, match=words):
        answer(live, **fields)


def test_limits_may_be_passed_where_that_is_asked_for(live):
    path = trajectory([[2.5, 0, 0], [2.6, 0, 0]])
    assert answer(live, path=path, ignore_limits=True).outcome in (CLEAR, CONTACT)


def test_joints_of_which_nothing_was_heard_are_named(text):
    live = live_scene(text, Clock(1000.0))
    with pytest.raises(RuntimeError, match=r'nobody knows where .*wrist'):
        answer(live, path=trajectory([[0, 0, 0]], times=(1.0,)))
    with pytest.raises(RuntimeError, match='nothing was heard of the joints arm::wrist'):
        answer(live, path=trajectory([[0.0], [0.1]], names=['shoulder']))
    assert answer(live, path=trajectory([[0, 0, 0.1], [0.1, 0, 0.1]])).outcome


def test_a_frame_without_a_pose_makes_no_motion_clear(live):
    with live.editing() as scene:
        scene.make(
            Change(
                lambda graph, _: graph.RegisterFrame(
                    scene.model.names.source('cell'), GeometryFrame('new')
                )
            )
        )
    for fields in ({'end': poses(free=AT_POST)}, {'path': trajectory([[0, 0, 0]])}):
        with pytest.raises(RuntimeError, match='never had a pose'):
            answer(live, **fields)


def test_a_spline_is_what_the_core_says_of_it(live, checker):
    rng = np.random.default_rng(9)
    kinds = set()
    asked = checker(min_distance=0.01, time_tolerance=1e-6 / 3.0)
    for k in range(30):
        rows = np.vstack((NOW, rng.uniform(*BOUNDS, size=(2, 3))))
        times, still = np.array([0.0, 2.0, 5.0]), [0.0] * 3
        spline = JointSpline(JointTrajectory(times, rows, np.zeros_like(rows)))
        derivatives = {'velocities': still, 'accelerations': still if k % 2 else []}
        if k % 2:
            spline = JointSpline(JointTrajectory(times, rows, 0.0 * rows, 0.0 * rows))
        expected = asked.check_spline(spline)
        found = answer(live, path=trajectory(rows, times, **derivatives), min_distance=0.01)
        kinds.add(expected.outcome)
        assert found.outcome == OUTCOMES[expected.outcome]
        assert found.lower_bound == expected.lower_bound
        inner = np.interp(expected.times, np.arange(3), times)
        assert np.allclose(found.times, inner, rtol=0, atol=1e-12)
        speeds = spline.speeds()
        assert found.joint_speed == speeds.max()
        assert found.fastest_joint == JOINTS_OF_ARM[int(np.argmax(speeds))]
    assert kinds >= {'clear', 'contact'}


def test_a_spline_begins_where_the_joints_are(live):
    row, still = [1.2, 0.6, 0.1], {'velocities': [0, 0, 0]}
    later = answer(live, path=trajectory([row], times=(1.0,), **still))
    both = answer(live, path=trajectory([NOW, row], times=(0.0, 1.0), **still))
    assert 'nobody knows how fast' in later.message
    assert {**vars(later), 'message': ''} == {**vars(both), 'message': ''}
    assert later.joint_speed == pytest.approx(1.5 * 0.2)


def test_a_spline_begins_with_the_speed_of_now(live):
    speeds = [0.5, 0.0, 0.0]
    with live.editing() as scene:
        message = state(JOINTS_OF_ARM, NOW, velocities=speeds)
        JointInput(live.clocks, 1.0, by_default=True).take(scene, message, 0.0)
    row, still = [1.2, 0.6, 0.1], {'velocities': [0, 0, 0]}
    later = answer(live, path=trajectory([row], times=(1.0,), **still))
    path = trajectory([NOW, row], times=(0.0, 1.0), **still)
    path.points[0].velocities = speeds
    both = answer(live, path=path)
    assert vars(later) == vars(both)
    assert 'move now' not in later.message


def test_points_go_straight_where_that_is_said(live):
    rows, times = [NOW, [1.2, 0.6, 0.1]], (0.0, 1.0)
    plain = answer(live, path=trajectory(rows, times))
    with_velocities = trajectory(rows, times, velocities=[3.0, 0, 0])
    assert vars(answer(live, path=with_velocities, profile='points')) == vars(plain)
    assert plain.joint_speed == pytest.approx(0.2)


def test_joints_of_other_robots_are_left_out_where_that_is_asked_for(live):
    still = {'velocities': [0.0] * 3}
    rows = [NOW, [1.2, 0.6, 0.1]]
    own = answer(live, path=trajectory(rows, (0.0, 1.0), **still))
    names = [JOINTS_OF_ARM[0], 'gripper', *JOINTS_OF_ARM[1:]]
    more = [[row[0], 9.9, *row[1:]] for row in rows]
    path = trajectory(more, (0.0, 1.0), names, velocities=[0.0] * 4)
    with pytest.raises(RuntimeError, match="no joint 'gripper'"):
        answer(live, path=path)
    found = answer(live, path=path, ignore_foreign_joints=True)
    assert found.foreign_joints == ['gripper']
    assert {**vars(found), 'foreign_joints': []} == vars(own)


def test_where_nobody_knows_the_start_of_a_spline_the_answer_says_so(text):
    live = live_scene(text, Clock(1000.0))
    path = trajectory([[0, 0, 0.1], [0.1, 0, 0.1]], (0.0, 1.0), velocities=[0, 0, 0])
    assert 'whether the path begins there was not judged' in answer(live, path=path).message
