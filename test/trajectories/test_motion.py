import numpy as np
import pytest
from oracles import panda

from drake_geom_ros.trajectories.interpolation import MonotoneCubic
from drake_geom_ros.trajectories.kinematics import Kinematics
from drake_geom_ros.trajectories.motion import Grasp, Motion, RobotMotion
from drake_geom_ros.trajectories.pose_matrices import (
    inverse,
    matrices_of_poses,
    poses_of_matrices,
)
from drake_geom_ros.trajectories.timed_poses import TimedPoses

CAN = np.array([0.5, 0.1, 0.2, 0.0, 0.0, np.sin(0.3), np.cos(0.3)])


@pytest.fixture(scope='module')
def robot():
    arm = Kinematics(str(panda.URDF))
    rng = np.random.default_rng(3)
    q = rng.uniform(0.4 * arm.lower + 0.6 * arm.upper, arm.upper, (4, len(arm.lower)))
    X_WB = matrices_of_poses([-0.5, 0.2, 0.1, 0, 0, 0, 1])
    return RobotMotion(arm, X_WB, MonotoneCubic([0.0, 1.0, 2.0, 3.0], q))


CAN_FRAME = ('objects', 'can')
BALL = ('objects', 'ball')


def _grasp(start, end, frame=CAN_FRAME, link=('left', 'panda_hand')):
    return Grasp(frame, link, (('left', 'panda_leftfinger'),), start, end)


def _motion(robot, *grasps, more=()):
    return Motion({'left': robot}, {CAN_FRAME: TimedPoses([0.0], [CAN]), **dict(more)}, grasps)


def _hand(robot, t):
    return robot.link_transforms(t)[..., robot.kinematics.link_names.index('panda_hand'), :, :]


def test_links_are_those_of_forward_kinematics(robot):
    motion = _motion(robot)
    expected = panda.link_transforms(robot.joint_values.value(1.3))
    for name, pose in zip(motion.frame_names['left'], motion.poses(1.3)['left'], strict=True):
        if name in expected:
            np.testing.assert_allclose(
                matrices_of_poses(pose), robot.X_WB @ expected[name], rtol=0, atol=1e-12
            )


def test_a_link_called_world_is_not_posed(tmp_path):
    urdf = tmp_path / 'r.urdf'
    urdf.write_text(
        '<robot name="r"><link name="world"/><link name="a"/><joint name="j" type="fixed">'
        '<parent link="world"/><child link="a"/><origin xyz="1 2 3"/></joint></robot>'
    )
    still = MonotoneCubic([0.0, 1.0], np.zeros((2, 0)))
    motion = Motion({'r': RobotMotion(Kinematics(str(urdf)), np.eye(4), still)}, {})
    assert motion.frame_names == {'r': ['a']}
    np.testing.assert_array_equal(motion.poses(0.0)['r'], [[1, 2, 3, 0, 0, 0, 1]])


def test_a_grasped_frame_keeps_its_pose_in_the_hand(robot):
    motion = _motion(robot, _grasp(0.5, 1.5))
    in_hand = [
        inverse(_hand(robot, t)) @ matrices_of_poses(motion.poses(t)['objects'][0])
        for t in (0.5, 0.9, 1.2, 1.5)
    ]
    np.testing.assert_allclose(in_hand, [in_hand[0]] * 4, rtol=0, atol=1e-12)


def test_a_frame_rests_before_and_after_and_never_jumps(robot):
    motion = _motion(robot, _grasp(0.5, 1.5), _grasp(2.0, 2.5))
    np.testing.assert_allclose(motion.poses([0.0, 0.3])['objects'][:, 0], [CAN, CAN])
    put_down = motion.poses([1.5, 1.7, 2.0])['objects'][:, 0]
    np.testing.assert_allclose(put_down, [put_down[0]] * 3, rtol=0, atol=1e-12)
    assert np.linalg.norm(put_down[0] - CAN) > 0.01
    for t in (0.5, 1.5, 2.0, 2.5):
        before, after = motion.poses([t - 1e-7, t + 1e-7])['objects'][:, 0]
        np.testing.assert_allclose(before, after, rtol=0, atol=1e-5)


def test_the_second_grasp_takes_the_frame_from_where_the_first_left_it(robot):
    motion = _motion(robot, _grasp(2.0, 2.5), _grasp(0.5, 1.5))
    X_WC = matrices_of_poses(CAN)
    for start, end in ((0.5, 1.5), (2.0, 2.5)):
        X_WC = _hand(robot, end) @ inverse(_hand(robot, start)) @ X_WC
    np.testing.assert_allclose(
        motion.poses(9.0)['objects'][0], poses_of_matrices(X_WC), rtol=0, atol=1e-12
    )


def test_many_times_are_each_time(robot):
    motion = _motion(robot, _grasp(0.5, 1.5))
    times = np.array([[0.1, 0.7], [1.6, 2.9]])
    together = motion.poses(times)
    assert together['left'].shape == (2, 2, 13, 7)
    assert together['objects'].shape == (2, 2, 1, 7)
    for index in np.ndindex(2, 2):
        for source, poses in motion.poses(times[index]).items():
            np.testing.assert_allclose(together[source][index], poses, rtol=0, atol=1e-14)


def test_held_names_the_grasp_from_its_start_until_before_its_end(robot):
    motion = _motion(robot, _grasp(0.5, 1.5))
    assert [len(motion.held(t)) for t in (0.4, 0.5, 1.4, 1.5)] == [0, 1, 1, 0]
    assert motion.held(0.5)[0].frame == CAN_FRAME


def test_timed_frames_move_and_the_longest_part_is_the_duration(robot):
    moves = TimedPoses([0.0, 5.0], [CAN, np.add(CAN, [1, 0, 0, 0, 0, 0, 0])])
    motion = _motion(robot, more={BALL: moves, ('lamp', 'lamp'): TimedPoses([0.0], [CAN])})
    assert motion.frame_names['objects'] == ['can', 'ball']
    assert motion.frame_names['lamp'] == ['lamp']
    assert motion.duration == 5.0
    np.testing.assert_allclose(motion.poses(5.0)['objects'][1, 0], CAN[0] + 1.0)


@pytest.mark.parametrize(
    ('grasps', 'reason'),
    [
        (
            [_grasp(0.0, 1.0, frame=('objects', 'cup'))],
            "'objects::cup' is no free frame.*objects::can",
        ),
        ([_grasp(0.0, 1.0, link=('left', 'hook'))], "'left::hook' is no link"),
        ([_grasp(1.0, 1.0)], 'end after its start'),
        ([_grasp(0.0, 1.0), _grasp(0.9, 2.0)], 'at 1.0 s or later'),
        ([_grasp(-1.0, 1.0)], 'at 0.0 s or later'),
        ([_grasp(0.0, 1.0, frame=BALL)], 'timed poses as well'),
    ],
)
def test_impossible_grasps_are_refused(robot, grasps, reason):
    ball = TimedPoses([0.0, 1.0], [CAN, CAN])
    with pytest.raises(ValueError, match=reason):
        _motion(robot, *grasps, more={BALL: ball})


def test_a_free_frame_is_of_a_source_without_robot(robot):
    with pytest.raises(ValueError, match="'left::can': its source is a robot"):
        _motion(robot, more={('left', 'can'): TimedPoses([0.0], [CAN])})


def test_names_with_colons_are_those_of_their_sources(robot):
    """Of `left::b` and `c`, of no robot, and of `left` and `b::c`, which is one's."""
    there = np.add(CAN, [1, 0, 0, 0, 0, 0, 0])
    frames = {('x', 'b::c'): CAN, ('x::b', 'c'): there, ('left::b', 'c'): CAN}
    motion = _motion(robot, more={f: TimedPoses([0.0], [pose]) for f, pose in frames.items()})
    assert motion.frame_names['x'] == ['b::c']
    assert motion.frame_names['x::b'] == motion.frame_names['left::b'] == ['c']
    np.testing.assert_allclose(motion.poses(0.0)['x'][0], CAN)
    np.testing.assert_allclose(motion.poses(0.0)['x::b'][0], there)
