"""Two senders of one joint, frame or transform are noticed; without ROS."""

import numpy as np
import pytest
from live.inputs.test_joint_input import ARM, JOINTS_OF_ARM, scene_text, state
from live.live_scenes import Clock, live_scene
from ros.scene_calls import poses

from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.inputs.pose_inputs import PoseInputs

AT, ELSEWHERE = (0.0, 0.0, 0.05), (1.0, 1.5, 0.05)
DRIVER, LEFTOVER = 'driver', 'leftover'


class Heard:
    """An arm that hears joint values, at moments that the test sets."""

    def __init__(self, folder):
        (folder / 'arm.urdf').write_text(ARM)
        self.clock = Clock(1000.0)
        self.live = live_scene(scene_text(folder, 'name: arm'), self.clock)
        self.inputs = PoseInputs(joints=JointInput(self.live.clocks, 1.0, by_default=True))

    def hear(self, values, sender='', seconds=0.01, names=JOINTS_OF_ARM):
        self.clock.now += seconds
        with self.live.editing() as scene:
            message = state(names, values, self.clock.now)
            self.inputs.take_joint_states(scene, message, sender=sender)

    def contested(self):
        with self.live.reading() as scene:
            labels = {f.get_value(): label[1] for f, label in scene.model.names.labels.items()}
            return {labels[value] for value in scene.poses.contested_frames()}

    def troubles(self):
        with self.live.reading() as scene:
            return [told for told in scene.troubles() if 'two senders' in told]


@pytest.fixture
def arm(tmp_path):
    return Heard(tmp_path)


def test_two_publishers_of_a_joint_in_turn_are_told_and_its_links_contested(arm):
    for _ in range(3):
        arm.hear(AT, DRIVER)
        arm.hear(AT, DRIVER)
        assert arm.contested() == set() or arm.troubles()
        arm.hear(AT, LEFTOVER)  # the same values, by chance
    assert arm.contested() == {'upper', 'hand', 'left', 'right'}
    (told,) = arm.troubles()
    assert told.startswith('3 joints are sent by two senders in turn')
    assert 'arm::shoulder' in told
    assert 'joint_states' in told
    for _ in range(100):
        arm.hear(AT, DRIVER, seconds=0.1)
    assert arm.contested() == set()
    assert arm.troubles() == []


def test_a_publisher_that_takes_over_and_two_of_different_joints_are_no_trouble(arm):
    for sender in (DRIVER, LEFTOVER):
        for _ in range(10):
            arm.hear(AT, sender, seconds=0.2)
    arm.clock.now += 1.0
    for _ in range(10):
        arm.hear(AT[:2], LEFTOVER, names=JOINTS_OF_ARM[:2])
        arm.hear(AT[2:], DRIVER, names=JOINTS_OF_ARM[2:])
    assert arm.contested() == set()


def test_without_identities_joints_that_jump_to_and_fro_have_two_senders(arm):
    for k in range(40):
        arm.hear(ELSEWHERE if k % 10 == 0 else AT)
    assert arm.contested() == {'upper', 'hand', 'left', 'right'}
    (told,) = arm.troubles()
    assert told.startswith('2 joints are sent')  # the finger did not move


def test_without_identities_lists_of_different_names_are_of_different_senders(arm):
    for _ in range(3):
        arm.hear(AT)
        arm.hear(AT[:1], names=JOINTS_OF_ARM[:1])
    assert arm.contested() == {'upper', 'hand', 'left', 'right'}


def test_motion_noise_and_one_glitch_are_of_one_sender(arm):
    rng = np.random.default_rng(1)
    for k in range(500):
        swing = 0.5 * np.sin(0.05 * k)
        arm.hear((swing, 3.0 * swing, 0.05 + rng.normal(0.0, 1e-4)))
    arm.hear(ELSEWHERE)
    arm.hear(AT)
    assert arm.contested() == set()


def test_values_that_jump_at_random_are_of_one_sender(arm):
    rng = np.random.default_rng(2)
    for _ in range(100):
        arm.hear(rng.uniform((-1, -3, 0), (2, 3, 0.1)), seconds=0.2)
        assert arm.contested() == set()


def test_two_publishers_that_pose_a_frame_by_messages_are_told(arm):
    for k in range(4):
        arm.clock.now += 0.01
        with arm.live.editing() as scene:
            message = poses(['base'], [(0.1 * k, 0, 0)], source='arm')
            arm.inputs.take_poses(scene, message, sender=(DRIVER, LEFTOVER)[k % 2])
    assert arm.contested() == {'base'}
    assert arm.troubles()[0].startswith('1 frame pose is sent by two senders in turn')
