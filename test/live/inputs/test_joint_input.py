"""Joint states to poses of a live scene, without ROS: names, bases, ages, limits, refusals."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live.live_scenes import Clock, live_scene

from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.inputs.pose_inputs import PoseInputs
from drake_geom_ros.live.scene.clocks import ALWAYS
from drake_geom_ros.live.scene.feeders import JOINTS, MESSAGES
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.trajectories.kinematics import Kinematics

BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
ARM = f"""<robot name="arm">
<link name="base">{BALL}</link><link name="upper">{BALL}</link><link name="hand">{BALL}</link>
<link name="left">{BALL}</link><link name="right">{BALL}</link><link name="mark">{BALL}</link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
  <origin xyz="0 0 1"/><axis xyz="0 0 1"/><limit lower="-1" upper="2" velocity="1"/></joint>
<joint name="wrist" type="continuous"><parent link="upper"/><child link="hand"/>
  <origin xyz="1 0 0" rpy="0 0.3 0"/><axis xyz="0 1 0"/></joint>
<joint name="finger" type="prismatic"><parent link="hand"/><child link="left"/>
  <axis xyz="1 0 0"/><limit lower="0" upper="0.1" velocity="1"/></joint>
<joint name="other" type="prismatic"><parent link="hand"/><child link="right"/>
  <axis xyz="1 0 0"/><mimic joint="finger" multiplier="-2" offset="0.01"/>
  <limit lower="-1" upper="1" velocity="1"/></joint>
<joint name="stick" type="fixed"><parent link="base"/><child link="mark"/>
  <origin xyz="0 1 0"/></joint>
</robot>"""
JOINTS_OF_ARM = ('shoulder', 'wrist', 'finger')
GAP = 1.0


@pytest.fixture
def clock():
    return Clock(1000.0)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / 'arm.urdf').write_text(ARM)
    return tmp_path


def scene_text(folder, *robots):
    lines = [f'- {{urdf: {folder}/arm.urdf, {robot}}}' for robot in robots]
    return 'robots:\n' + '\n'.join(lines)


def opened(text, clock, *, by_default=True):
    live = live_scene(text, clock)
    return live, JointInput(live.clocks, GAP, by_default=by_default)


def state(names, positions, stamp=0.0, velocities=()):
    seconds = math.floor(stamp)
    time = Plain(sec=seconds, nanosec=round((stamp - seconds) * 1e9))
    return Plain(
        header=Plain(stamp=time, frame_id=''),
        name=list(names),
        position=list(positions),
        velocity=list(velocities),
        effort=[],
    )


def pose(scene, frame):
    return scene.query.X_WF(scene.model.names.frame(frame)).GetAsMatrix4()


def waiting(scene):
    return {
        scene.model.names.frame_names[f].partition('::')[2] for f in scene.query.waiting_frames()
    }


def expected(q, X_WB=None):
    kinematics = Kinematics(read_scene(f'{ARM}\n', 'urdf').robots[0].tree)
    X_WLs = kinematics.link_transforms(q, None if X_WB is None else X_WB.GetAsMatrix4())
    return dict(zip(kinematics.link_names, X_WLs, strict=True))


def assert_stands(scene, q, X_WB=None, robot='arm'):
    for link, X_WL in expected(q, X_WB).items():
        np.testing.assert_allclose(pose(scene, f'{robot}::{link}'), X_WL, rtol=0, atol=1e-14)


AT = 'pose: {position: [1, 2, 3]}'
X_WB = RigidTransform([1.0, 2.0, 3.0])


def test_links_stand_where_kinematics_puts_them(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        # Any order; the mimic's own value and a stranger's count for nothing.
        names = ('finger', 'stranger', 'shoulder', 'other', 'wrist')
        assert joints.take(scene, state(names, (0.02, 9.0, 0.5, 7.0, -0.3), 1000.0), 0.0) == 4
        assert not waiting(scene)
        assert_stands(scene, [0.5, -0.3, 0.02], X_WB)


@given(st.permutations(range(3)), st.lists(st.floats(-3, 3), min_size=3, max_size=3))
def test_messages_that_carry_some_joints_add_up(tmp_path_factory, order, q):
    folder = tmp_path_factory.mktemp('arm')
    (folder / 'arm.urdf').write_text(ARM)
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), Clock(1000.0))
    with live.editing() as scene:
        for k in order:
            assert waiting(scene)
            joints.take(scene, state([f'arm::{JOINTS_OF_ARM[k]}'], [q[k]]), 0.0)
        assert not waiting(scene)
        assert_stands(scene, q, X_WB)


def test_what_depends_on_a_silent_joint_waits_and_is_named(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(['shoulder', 'finger'], [0.1, 0.0]), 0.0)
        assert waiting(scene) == {'hand', 'left', 'right'}
        (told,) = joints.troubles(scene, 1.0)
        assert "1 joint of 'arm' never had a value" in told
        assert 'wrist' in told


def test_without_a_base_nothing_is_posed_until_it_comes_and_then_all_is(folder, clock):
    live, joints = opened(scene_text(folder, 'name: arm'), clock)
    with live.editing() as scene:
        message = state(JOINTS_OF_ARM, (0.1, 0.2, 0.03), 1000.0)
        assert joints.take(scene, message, 0.0) == 0
        assert waiting(scene) == {'base', 'upper', 'hand', 'left', 'right', 'mark'}
        place(scene, 'base', X_WB)
        assert joints.follow(scene) == 5
        assert_stands(scene, [0.1, 0.2, 0.03], X_WB)
        # It moves along with its base, links that no joint moves too; and rests with it.
        place(scene, 'base', RigidTransform([5.0, 0.0, 0.0]))
        assert joints.follow(scene) == 5
        assert_stands(scene, [0.1, 0.2, 0.03], RigidTransform([5.0, 0.0, 0.0]))
        assert joints.follow(scene) == 0


def place(scene, frame, X_WF):
    frame = scene.model.names.frame(frame)
    stamp = Plain(sec=1000, nanosec=0)
    scene.poses.pose(
        FramePoseVector({frame: X_WF}), {frozenset([frame.get_value()]): ALWAYS}, stamp, MESSAGES
    )


def test_two_robots_of_one_kind_need_their_names(folder, clock):
    text = scene_text(folder, f'name: left, {AT}', f'name: right, {AT}')
    live, joints = opened(text, clock)
    with live.editing() as scene:
        with pytest.raises(RuntimeError, match="one of 2 robots: name it as 'left::shoulder'"):
            joints.take(scene, state(JOINTS_OF_ARM, (0, 0, 0)), 0.0)
        names = [f'{robot}::{joint}' for robot in ('left', 'right') for joint in JOINTS_OF_ARM]
        assert joints.take(scene, state(names, (0.1, 0.2, 0.0, 0.3, 0.4, 0.05)), 0.0) == 8
        assert_stands(scene, [0.1, 0.2, 0.0], X_WB, 'left')
        assert_stands(scene, [0.3, 0.4, 0.05], X_WB, 'right')


def test_a_robots_own_topic_drives_it_alone(folder, clock):
    mine = f'name: left, joint_states: /left/joint_states, {AT}'
    live, joints = opened(scene_text(folder, mine, f'name: right, {AT}'), clock)
    with live.editing() as scene:
        assert joints.topics(scene) == {'/left/joint_states'}
        message = state(JOINTS_OF_ARM, (0.1, 0.2, 0.0))
        assert joints.take(scene, message, 0.0, '/left/joint_states') == 4
        assert_stands(scene, [0.1, 0.2, 0.0], X_WB, 'left')
        assert not scene.query.is_placed(scene.model.names.frame('right::hand'))
        assert joints.take(scene, message, 0.0) == 4
        assert_stands(scene, [0.1, 0.2, 0.0], X_WB, 'right')
    live, joints = opened(scene_text(folder, mine, 'name: right'), clock, by_default=False)
    with live.editing() as scene:
        assert joints.topics(scene) == {'/left/joint_states'}
        with pytest.raises(RuntimeError, match='no robot of the scene listens'):
            joints.take(scene, message, 0.0)


@pytest.mark.parametrize(
    ('message', 'words'),
    [
        (state(['shoulder'], []), 'position holds 0 numbers for 1 name'),
        (state(['shoulder', 'wrist'], [1.0]), 'position holds 1 number'),
        (state([], []), 'it names no joints at all'),
        (state(['sholder'], [1.0]), "nearest: 'shoulder'"),
        (state(['x'] * 10_000, [0.0] * 10_000), 'no joint of a robot here'),
        (state(['shoulder', 'arm::shoulder'], [1.0, 1.0]), 'is named twice'),
        (state(['wrist', 'shoulder'], [0.7, math.nan]), "position of joint 'shoulder' is nan"),
        (state(['wrist'], [math.inf]), "position of joint 'wrist' is inf"),
        (state(['wrist'], [0.7], velocities=[1.0, 2.0]), 'velocity holds 2 numbers'),
        (state(['wrist'], [0.7], velocities=[math.inf]), "velocity of joint 'wrist' is inf"),
        (state(['wrist', 'finger'], [0.7, 1e303]), 'beyond'),
    ],
)
def test_a_wrong_message_is_refused_whole(folder, clock, message, words):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), 999.5), 0.0)
        ages = scene.poses.ages_by_name()
        with pytest.raises(RuntimeError, match=words):
            joints.take(scene, message, 0.0)
        assert_stands(scene, [0.1, 0.2, 0.0], X_WB)
        assert scene.poses.ages_by_name() == ages
        # Nothing of it is kept for later either.
        joints.take(scene, state(['finger'], [0.0], 1000.0), 0.0)
        assert_stands(scene, [0.1, 0.2, 0.0], X_WB)


def test_strangers_numbers_may_be_anything(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        names = (*JOINTS_OF_ARM, 'stranger')
        assert joints.take(scene, state(names, (0.1, 0.2, 0.0, math.nan)), 0.0) == 4


def test_messages_with_times_that_go_back_count_as_they_come(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        scene.poses.watch_motion(GAP)
        for stamp, q in ((1000.0, 0.1), (999.5, 0.2), (999.9, 0.3), (0.0, 0.4), (998.0, 0.5)):
            joints.take(scene, state(JOINTS_OF_ARM, (q, 0.0, 0.0), stamp), 0.0)
            assert_stands(scene, [q, 0.0, 0.0], X_WB)
        # The newest time of all does not make what came last younger than it says it is.
        assert scene.poses.ages_by_name()['arm::hand'] == 2.0


def test_efforts_alone_are_no_values(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        message = state(JOINTS_OF_ARM, ())
        message.effort = [1.0, 2.0, 3.0]
        with pytest.raises(RuntimeError, match='position holds 0 numbers for 3 names'):
            joints.take(scene, message, 0.0)
        assert waiting(scene) >= {'upper', 'hand'}


def test_a_link_is_as_old_as_its_oldest_joint(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), 1000.0), 0.0)
        clock.now += 3.0
        joints.take(scene, state(['shoulder'], [0.2], 1003.0), 0.0)
        ages = scene.poses.ages_by_name()
        assert ages['arm::upper'] == 0.0
        assert ages['arm::hand'] == ages['arm::left'] == ages['arm::right'] == 3.0
        assert ages['arm::base'] == ages['arm::mark'] == 0.0
        (told,) = joints.troubles(scene, 1.0)
        assert told == "2 joints of 'arm' are stale (older than 1 s): wrist, finger"


def test_velocities_that_are_nan_are_not_known_and_the_positions_count(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        unknown = [0.5, math.nan, math.nan]
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), 1000.0, unknown), 0.0)
        assert_stands(scene, [0.1, 0.2, 0.0], X_WB)
        values = scene.model.joints.robots['arm'].values
        assert values[0].speed == 0.5
        assert all(math.isnan(value.speed) for value in values[1:])
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.3, 0.0), 1000.5, unknown), 0.0)
        assert scene.model.joints.robots['arm'].values[1].speed == pytest.approx(0.2)


def test_a_stamp_that_is_sent_again_is_no_new_value(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        message = state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), 950.0)
        joints.take(scene, message, 0.0)
        assert scene.poses.ages_by_name()['arm::hand'] == 50.0
        clock.now += 20.0
        joints.take(scene, message, 0.0)
        assert scene.poses.ages_by_name()['arm::hand'] == 70.0


def test_values_with_stamps_of_another_clock_are_that_old_and_told(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), 939.0), 0.0)
        assert scene.poses.ages_by_name()['arm::hand'] == 61.0
        (told,) = scene.troubles()
        assert 'the poses of 4 frames bear stamps of another clock, up to 61.0 s before' in told
        assert 'arm::hand' in told
        hand = scene.model.names.frame('arm::hand').get_value()
        assert scene.poses.blind_frames(1000.0).foreign.keys() >= {hand}
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), 1003.0), 0.0)
        assert math.isinf(scene.poses.ages_by_name()['arm::hand'])
        (told,) = scene.troubles()
        assert 'up to 3.0 s after the time of the node, so they count as of unknown age' in told
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), 1000.0), 0.0)
        assert scene.troubles() == []


@pytest.mark.parametrize('by_steps', [False, True])
def test_links_of_a_base_that_is_posed_again_where_it_stands_are_as_new_as_it(
    folder, clock, by_steps
):
    live, joints = opened(scene_text(folder, 'name: arm'), clock)
    inputs = PoseInputs(joints=joints)
    with live.editing() as scene:
        for k in range(40):
            clock.now += 0.25
            stamp = Plain(sec=int(clock.now), nanosec=int(1e9 * (clock.now % 1.0)))
            place = (0.1 * k * by_steps, 0.0, 0.0)
            inputs.take_poses(scene, stamped_pose('base', place, stamp))
            inputs.take_joint_states(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), clock.now))
        assert max(scene.poses.ages_by_name().values()) == 0.0
        clock.now += 0.5
        inputs.take_joint_states(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), clock.now))
        ages = scene.poses.ages_by_name()
        assert ages['arm::mark'] == ages['arm::base'] == ages['arm::hand'] == 0.5


def stamped_pose(frame, place, stamp):
    return Plain(
        header=Plain(stamp=stamp, frame_id=''),
        source='arm',
        frame_names=[frame],
        frame_ids=[],
        poses=[*place, 0.0, 0.0, 0.0, 1.0],
    )


def test_a_jump_of_the_clock_makes_ages_unknown_until_values_come_anew(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), 1000.0), 0.0)
        live.clocks.begin_anew()
        joints.take(scene, state(['shoulder'], [0.1], 1000.0), 0.0)
        ages = scene.poses.ages_by_name()
        assert ages['arm::upper'] == 0.0
        assert math.isinf(ages['arm::hand'])
        joints.take(scene, state(['wrist', 'finger'], [0.2, 0.0], 1000.0), 0.0)
        assert scene.poses.ages_by_name()['arm::hand'] == 0.0


def test_a_joint_outside_its_limits_is_used_and_told(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, (2.5, 50.0, 0.05)), 0.0)
        assert_stands(scene, [2.5, 50.0, 0.05], X_WB)
        (told,) = joints.troubles(scene, 1.0)
        assert told == '1 joint is outside their limits: arm::shoulder [-1, 2]'


def test_a_robot_that_is_replaced_goes_on_with_what_was_heard(folder, clock):
    from drake_geom_ros.live.scene.prepared_scene import prepared

    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), 1000.0), 0.0)
        clock.now += 2.0
        text = scene_text(folder, 'name: arm, pose: {position: [7, 0, 0]}')
        stamp = scene.poses.ages.newest_stamp
        scene.replace(prepared(read_scene(text)))
        assert scene.poses.ages.newest_stamp is None
        assert 'hand' in waiting(scene)
        # The next message, of one joint, brings all of them.
        joints.take(scene, state(['shoulder'], [0.3], 1002.0), 0.0)
        assert_stands(scene, [0.3, 0.2, 0.0], RigidTransform([7.0, 0.0, 0.0]))
        assert scene.poses.ages_by_name()['arm::hand'] == 2.0
        assert stamp is not None


@pytest.mark.filterwarnings('ignore:.*mimics')
def test_a_robot_whose_joints_have_no_leader_is_left_alone_with_the_reason(tmp_path, clock):
    (tmp_path / 'arm.urdf').write_text(ARM.replace('mimic joint="finger"', 'mimic joint="thumb"'))
    live, joints = opened(scene_text(tmp_path, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        (told,) = joints.troubles(scene, 1.0)
        assert told.startswith("no joint values drive 'arm'")
        assert "'thumb'" in told


def test_tf_leaves_alone_what_joint_states_pose(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), 1000.0), 0.0)
        hand = scene.model.names.frame('hand').get_value()
        assert scene.poses.feeders.is_fed_by(JOINTS, hand)
        place(scene, 'hand', RigidTransform([0.0, 0.0, 9.0]))
        joints.take(scene, state(JOINTS_OF_ARM, (0.1, 0.2, 0.0), 1000.1), 0.0)
        place(scene, 'hand', RigidTransform([0.0, 0.0, 9.0]))
        (told,) = scene.troubles()
        assert '1 frame is posed by two of TF, ~/frame_poses and joint states in turn' in told


def test_speeds_of_joints_tell_how_links_move(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}'), clock)
    q, rates = np.array([0.4, -0.7, 0.03]), np.array([0.5, -1.0, 0.2])
    step = 1e-6
    before, after = expected(q - step * rates, X_WB), expected(q + step * rates, X_WB)
    with live.editing() as scene:
        scene.poses.watch_motion(GAP)
        joints.take(scene, state(JOINTS_OF_ARM, q, 1000.0, rates), 0.0)
        assert_twists(scene, before, after, step, 1e-8)
        # Without speeds those between the values of each joint count, whoever sends them.
        for k, shift in ((0, 0.25), (1, 0.5)):
            clock.now = 1000.0 + shift
            now = q[k] + shift * rates[k]
            joints.take(scene, state([JOINTS_OF_ARM[k]], [now], clock.now), 0.0)
        q_now = q + np.array([0.25, 0.5, 0.0]) * rates
        before, after = (expected(q_now + s * step * rates, X_WB) for s in (-1, 1))
        assert_twists(scene, before, after, step, 1e-6)


def assert_twists(scene, before, after, step, tolerance):
    twists = scene.poses.twists()
    for link in ('upper', 'hand', 'left', 'right'):
        V = twists[scene.model.names.frame(f'arm::{link}')]
        moved = (after[link] - before[link]) / (2.0 * step)
        np.testing.assert_allclose(V[3:], moved[:3, 3], rtol=0, atol=tolerance)
        spin = moved[:3, :3] @ ((after[link] + before[link]) / 2.0)[:3, :3].T
        np.testing.assert_allclose(
            V[:3], [spin[2, 1], spin[0, 2], spin[1, 0]], rtol=0, atol=tolerance
        )
    assert not twists[scene.model.names.frame('arm::mark')].any()


def test_a_base_that_moves_carries_the_speeds_along(folder, clock):
    live, joints = opened(scene_text(folder, 'name: arm'), clock)
    with live.editing() as scene:
        scene.poses.watch_motion(GAP)
        base = scene.model.names.frame('base')
        for k in range(2):
            clock.now = 1000.0 + 0.1 * k
            stamp = Plain(sec=1000, nanosec=k * 10**8)
            since = live.clocks.arrival().since(clock.now)
            scene.poses.pose(
                FramePoseVector({base: RigidTransform([0.3 * k, 0.0, 0.0])}),
                {frozenset([base.get_value()]): since},
                stamp,
                MESSAGES,
            )
        joints.take(scene, state(JOINTS_OF_ARM, (0, 0, 0), clock.now, (1.0, 0.0, 0.0)), 0.0)
        V = scene.poses.twists()[scene.model.names.frame('hand')]
        np.testing.assert_allclose(V, [0, 0, 1, 3, 1, 0], rtol=0, atol=1e-9)
