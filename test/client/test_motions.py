"""``check_motion`` by the client, on a real node."""

import math
import threading
import time
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from builtin_interfaces.msg import Duration
from drake_geom_msgs import msg
from geometry_msgs.msg import Transform
from live.inputs.test_joint_input import JOINTS_OF_ARM
from live.services.test_motions import BOUNDS, FIRST_TOUCH, NOW
from live.services.test_states import cell_in
from ros.harness import PATIENCE, start_node
from trajectory_msgs.msg import (
    JointTrajectory,
    MultiDOFJointTrajectory,
    MultiDOFJointTrajectoryPoint,
)

from drake_geom_ros.batch import Joints, check_path
from drake_geom_ros.client import RefusedError, SceneGraphClient, exclude_between
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import load_scene

pytestmark = pytest.mark.topics

NAMES = [f'arm::{name}' for name in JOINTS_OF_ARM]
BEFORE, BEHIND = RigidTransform([0, 2, 5.2]), RigidTransform([4, 2, 5.2])


@pytest.fixture(scope='module')
def scene_file(tmp_path_factory):
    folder = tmp_path_factory.mktemp('motions')
    path = folder / 'cell.yaml'
    there = ', '.join(f'{n}: {q}' for n, q in zip(JOINTS_OF_ARM, NOW, strict=True))
    more = 'adjacent_links: filtered', f'configuration: {{{there}}}'
    path.write_text(cell_in(folder, *more))
    return path


@pytest.fixture(scope='module')
def asked(scene_file):
    process = start_node(
        scene_file.parent / 'log', name='moved', scene_file=scene_file, use_joint_states=True
    )
    with SceneGraphClient('/moved', patience=PATIENCE) as client:
        yield client
    assert process.end() == 0, process.output()


@pytest.fixture(scope='module')
def check(scene_file):
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene(scene_file, scene_graph), NAMES)
    return lambda path, **fields: check_path(scene_graph, joints, path, **fields)


def test_a_ball_meets_a_post(asked):
    found = asked.check_motion({'free': BEHIND}, start={'free': BEFORE})
    assert found.outcome == 'contact'
    assert found.times[0] <= FIRST_TOUCH <= found.times[1] <= found.times[0] + 1e-6
    assert found.last_free == found.times[0]
    assert set(found.names) == {'cell::world/post', 'cell::free/ball'}
    assert math.isclose(found.p_WCa[0], 1.9, abs_tol=1e-5)
    with pytest.raises(TypeError, match='neither true nor false'):
        bool(found)


def test_a_robot_trajectory_moves_frames_too(asked):
    def point(X, seconds):
        transform = Transform()
        transform.translation.x, transform.translation.y, transform.translation.z = X.translation()
        time_from_start = Duration(sec=seconds)
        return MultiDOFJointTrajectoryPoint(
            transforms=[transform], time_from_start=time_from_start
        )

    points = [point(BEFORE, 0), point(BEHIND, 1)]
    several = MultiDOFJointTrajectory(joint_names=['free'], points=points)
    # As moveit_msgs/RobotTrajectory has it.
    message = Plain(joint_trajectory=JointTrajectory(), multi_dof_joint_trajectory=several)
    found = asked.check_motion(trajectory=message, allow_stale=True)
    assert found.outcome == 'contact'
    assert found.times[0] <= FIRST_TOUCH <= found.times[1] <= found.times[0] + 1e-6
    with pytest.raises(TypeError, match='it must be a JointTrajectory or a RobotTrajectory'):
        asked.check_motion(trajectory=several)
    with pytest.raises(ValueError, match='trajectory is given, and so is path'):
        asked.check_motion(trajectory=message, joint_names=NAMES, path=[(0.0, 0.0, 0.0)])


def test_paths_are_answered_as_offline(asked, check):
    outcomes = set()
    for path in np.random.default_rng(8).uniform(*BOUNDS, size=(30, 3, 3)):
        found = asked.check_motion(joint_names=NAMES, path=path, times=[0.0, 1.0, 2.0])
        expected = check(path)
        outcomes.add(found.outcome)
        assert found.outcome == expected.outcome
        assert np.allclose(found.times, expected.times, rtol=0, atol=1e-6)
        assert math.isclose(found.distance, expected.distance, abs_tol=1e-9)
        table = asked.scene()
        named = tuple(table[id].full_name if id else '' for id in found.ids)
        assert found.names == named
    assert outcomes >= {'clear', 'contact'}


def test_a_path_has_speeds_clearances_and_a_way_in_front(asked):
    way = {'joint_names': NAMES, 'path': [NOW, (0.9, 0.6, 0.1)], 'times': [0.0, 2.0]}
    found = asked.check_motion(**way, clearance_intervals=4, allow_stale=True)
    assert found.outcome == 'clear'
    assert found.clearance_times.tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert (found.clearances > 0.0).all()
    assert found.cartesian_speed > found.joint_speed * 1.0  # the hand is 1 m from the shoulder
    assert found.fastest_geometry.startswith('arm::')
    late = asked.check_motion(
        joint_names=NAMES,
        path=[(0.9, 0.6, 0.1), (0.8, 0.6, 0.1)],
        times=[0.0, 1.0],
        approach_time=1.5,
        clearance_intervals=1,
        allow_stale=True,
    )
    assert late.clearance_times.tolist() == [-1.5, 1.0]
    with pytest.raises(RefusedError, match='approach_time is -1'):
        asked.check_motion(**way, approach_time=-1.0)


def test_a_budget_that_is_spent_is_unknown(asked, check):
    rng = np.random.default_rng(9)
    paths = (rng.uniform(*BOUNDS, size=(2, 3)) for _ in range(1000))
    path = next(each for each in paths if check(each).evaluations > 3)
    found = asked.check_motion(joint_names=NAMES, path=path, max_evaluations=2)
    assert found.outcome == 'unknown'
    assert found.last_free < 1.0


def test_a_filter_that_holds_now_is_kept(asked):
    way = {'end': {'free': BEHIND}, 'start': {'free': BEFORE}}
    post, ball = (
        msg.GeometrySet(geometries=[name]) for name in ('cell::world/post', 'cell::free/ball')
    )
    declaration = msg.CollisionFilterDeclaration(statements=[exclude_between(post, ball)])
    held = asked.call('apply_transient_filter', declaration=declaration, owner='test', lease=60.0)
    assert asked.check_motion(**way).outcome == 'clear'
    asked.call('remove_filter', filter_id=held.filter_id)
    assert asked.check_motion(**way).outcome == 'contact'


def test_what_is_refused_is_told(asked):
    with pytest.raises(RefusedError, match='both empty'):
        asked.check_motion()
    with pytest.raises(RefusedError, match="no joint 'elbow'"):
        asked.check_motion(joint_names=['elbow'], path=[[0.0], [1.0]])
    with pytest.raises(RefusedError, match='point 0 of path: arm::shoulder = nan'):
        asked.check_motion(joint_names=NAMES, path=[[math.nan, 0, 0]] * 2)
    with pytest.raises(RefusedError, match='are both given'):
        asked.check_motion({'free': BEHIND}, joint_names=NAMES, path=[[0.0, 0, 0]])
    with pytest.raises(RefusedError, match="no frame 'nobody'"):
        asked.check_motion({'nobody': BEHIND})
    with pytest.raises(ValueError, match='times has the shape'):
        asked.check_motion(joint_names=NAMES, path=[[0.0, 0, 0]], times=[1.0, 2.0])


def test_a_frame_without_a_pose_makes_no_motion_clear(asked):
    asked.call('register_frame', source='cell', name='new')
    with pytest.raises(RefusedError, match='never had a pose'):
        asked.check_motion({'free': BEHIND}, start={'free': BEFORE})
    poses = {'new': RigidTransform([20, 20, 20])}
    found = asked.check_motion({'free': BEHIND}, start={'free': BEFORE, **poses})
    assert found.outcome == 'contact'
    asked.publish_poses(poses)
    asked.wait_for(lambda: 'cell::new' in asked.pose_ages(), 'the pose of the new frame')


def test_the_stream_goes_on_while_motions_are_checked(asked):
    """Poses that each wait for their cycle are many more than the checks that run meanwhile."""
    reports, checks, done = [], [], threading.Event()
    asked.node.create_subscription(msg.CycleReport, '/moved/cycle_report', reports.append, 100)
    long_path = np.random.default_rng(1).uniform(*BOUNDS, size=(20000, 3))

    def cycle_since(start):
        """Pose the ball now, and return whether there is a cycle of poses since a time [s]."""
        asked.publish_poses({'free': BEFORE})
        stamps = (report.header.stamp for report in reports[-100:])
        return any(t.sec + 1e-9 * t.nanosec >= start for t in stamps)

    def go_on():
        while not done.is_set():
            asked.check_motion(joint_names=NAMES, path=long_path, max_evaluations=1)
            checks.append(time.monotonic())

    thread = threading.Thread(target=go_on)
    thread.start()
    asked.wait_for(lambda: checks, 'a check')
    before = len(checks)
    for _ in range(100):
        start = time.time()
        asked.wait_for(lambda start=start: cycle_since(start), 'a cycle')
    meanwhile = len(checks) - before
    done.set()
    thread.join()
    assert meanwhile < 50, meanwhile
