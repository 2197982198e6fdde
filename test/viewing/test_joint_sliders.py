"""Joints move links as forward kinematics says, and no farther than their limits."""

import numpy as np
import pytest
from viewing.scenes import local_scene

from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.trajectories.motion_file import load_motion
from drake_geom_ros.viewing.joint_sliders import JointSliders

URDF = """
<robot name="arm">
  <link name="base"/><link name="upper"/><link name="hand"/><link name="tip"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="upper"/><child link="hand"/>
    <origin xyz="1 0 0"/><axis xyz="1 0 0"/><limit lower="0.1" upper="0.5" effort="1"
    velocity="1"/></joint>
  <joint name="roll" type="continuous"><parent link="hand"/><child link="tip"/>
    <axis xyz="1 0 0"/></joint>
</robot>
"""


@pytest.fixture
def arm(tmp_path):
    (tmp_path / 'arm.urdf').write_text(URDF)
    text = f'robots: [{{name: r, urdf: {tmp_path}/arm.urdf, pose: {{position: [0, 0, 1]}}}}]\n'
    shown = local_scene(text)
    return shown, JointSliders(load_motion(None, read_scene(text)).robots, shown.frames)


def test_joints_have_their_limits(arm):
    _, joints = arm
    ranges = {joint.name: (joint.lower, joint.upper) for joint in joints.all()}
    assert ranges['shoulder'] == (-1.0, 2.0)
    assert ranges['slide'] == (0.1, 0.5)
    assert ranges['roll'] == pytest.approx((-2 * np.pi, 2 * np.pi))


def test_moving_a_joint_moves_its_links(arm):
    shown, joints = arm
    shoulder, slide, _ = joints.all()
    shown.pose(joints.move(shoulder, np.pi / 2))
    shown.pose(joints.move(slide, 0.3))
    np.testing.assert_allclose(
        shown.X_WF(('r', 'hand')).translation(), [0, 1.3, 1], rtol=0, atol=1e-12
    )
    assert joints.value(slide) == 0.3


@pytest.mark.parametrize(('asked', 'taken'), [(9.0, 2.0), (-9.0, -1.0), (np.inf, 2.0)])
def test_limits_are_kept_whatever_a_browser_sends(arm, asked, taken):
    _, joints = arm
    shoulder = joints.all()[0]
    joints.move(shoulder, asked)
    assert joints.value(shoulder) == taken
    with pytest.raises(ValueError, match='shoulder'):
        joints.move(shoulder, np.nan)
    assert joints.value(shoulder) == taken


def test_values_may_be_given_by_full_names_and_by_states_over_time():
    from batch.conftest import Cell

    from drake_geom_ros.scene_files import read_scene
    from drake_geom_ros.trajectories import load_motion

    cell = Cell()
    motion = load_motion(None, read_scene(cell.path))
    joints = JointSliders(
        motion.robots, {'::'.join(key): id for key, id in cell.loaded.frames.items()}
    )
    joints.take({'arm::bend': 0.5, 'arm::slide': 9.0})
    told = {joint.name: joints.value(joint) for joint in joints.all()}
    assert told['bend'] == 0.5
    assert told['slide'] == 9.0
    with pytest.raises(KeyError):
        joints.take({'arm::elbow': 0.0})
    joints.follow_states([{'arm::bend': 0.1}, {'arm::bend': 0.2}])
    for time, value in ((0.0, 0.1), (0.9, 0.1), (1.5, 0.2), (99.0, 0.2)):
        joints.follow(time)
        assert {joint.name: joints.value(joint) for joint in joints.all()}['bend'] == value
