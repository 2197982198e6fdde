"""Robots that come by topic and are in the scene already, and several with topics of their own."""

import pytest
from live.inputs.test_joint_input import ARM, JOINTS_OF_ARM, state
from live.inputs.test_robot_description import urdf
from live.live_scenes import Clock, live_scene

from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.scene_files import SceneFileError, robot_topics_of_text

ZERO = (0.0, 0.0, 0.0)
TURNED = (0.5, 0.3, 0.05)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / 'arm.urdf').write_text(ARM)
    return tmp_path


def opened(folder, *robots):
    lines = [f'- {{urdf: {folder}/arm.urdf, pose: {{}}, {robot}}}' for robot in robots]
    live = live_scene('robots:\n' + '\n'.join(lines) + '\n', Clock(1000.0))
    return live, JointInput(live.clocks, 1.0, by_default=True)


def sources(live):
    with live.reading() as scene:
        inspector = scene.model.inspector
        names = {inspector.GetName(source) for source in inspector.GetAllSourceIds()}
    return names - {'SceneGraphInternal'}


def hand(live, robot):
    with live.reading() as scene:
        X = scene.query.X_WF(scene.model.names.frame(f'{robot}::hand'))
        return X.translation().tolist()


def test_the_robot_of_the_scene_file_is_followed_and_not_doubled(folder):
    live, joints = opened(folder, 'name: arm1')
    robot = RobotInput(live)
    done = robot.take(ARM)
    assert "this is 'arm1' of the scene" in done
    assert 'not added a second time' in done
    assert 'shapes differ' not in done
    assert sources(live) == {'arm1'}
    assert robot.take(ARM) == '', 'the same text again'
    with live.editing() as scene:  # they would be ambiguous
        joints.take(scene, state(JOINTS_OF_ARM, ZERO), 0.0)
        before = hand(live, 'arm1')
        joints.take(scene, state(JOINTS_OF_ARM, TURNED), 0.0)
    assert hand(live, 'arm1') != before
    assert 'is not read' in robot.take_semantics('<robot name="arm"/>')


@pytest.mark.parametrize(
    ('old', 'new'),
    [
        ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 1.0000000001"/>'),
        ('xyz="0 0 1" rpy', 'xyz="0 0 1.0000000001" rpy'),
        ('upper="2"', 'upper="2.5"'),
        ('<robot name="arm">', '<!-- by xacro -->\n<robot name="arm">'),
    ],
)
def test_rounding_limits_and_comments_make_no_other_robot(folder, old, new):
    live, _ = opened(folder, 'name: arm1')
    assert "this is 'arm1'" in RobotInput(live).take(ARM.replace(old, new))


def test_other_shapes_of_the_same_robot_are_reported(folder):
    live, _ = opened(folder, 'name: arm1')
    done = RobotInput(live).take(ARM.replace('radius="0.1"', 'radius="0.2"'))
    assert 'Its shapes differ, and those of the scene count' in done
    assert sources(live) == {'arm1'}


@pytest.mark.parametrize(
    ('old', 'new'),
    [
        ('<origin xyz="0 0 1"/>', '<origin xyz="0 0 1.1"/>'),
        ('"continuous"', '"fixed"'),
        ('multiplier="-2"', 'multiplier="-1"'),
        ('<link name="mark">', '<link name="more"/><link name="mark">'),
        ('name="wrist"', 'name="elbow"'),
    ],
)
def test_another_robot_is_added(folder, old, new):
    live, _ = opened(folder, 'name: arm1')
    text = ARM.replace(old, new)
    assert text != ARM
    assert 'added' in RobotInput(live).take(text)
    assert sources(live) == {'arm1', 'arm'}


def test_another_robot_of_a_taken_name_is_refused(folder):
    live, _ = opened(folder, 'name: arm')
    with pytest.raises(RuntimeError, match='with other links or joints'):
        RobotInput(live).take(ARM.replace('name="wrist"', 'name="elbow"'))


def test_of_two_in_the_scene_the_one_of_its_name_counts_or_none(folder):
    live, _ = opened(folder, 'name: arm', 'name: arm2')
    assert "this is 'arm'" in RobotInput(live).take(ARM)
    live, _ = opened(folder, 'name: arm1', 'name: arm2')
    with pytest.raises(RuntimeError, match='of arm1, arm2 of the scene'):
        RobotInput(live).take(ARM)
    assert sources(live) == {'arm1', 'arm2'}


def test_robots_without_joints_are_told_apart_by_their_shapes(tmp_path):
    (tmp_path / 'one.urdf').write_text(urdf('one', 'base'))
    live = live_scene(f'robots: [{{name: one, urdf: {tmp_path}/one.urdf}}]\n', Clock())
    assert "this is 'one'" in RobotInput(live).take(urdf('two', 'base'))
    assert 'added' in RobotInput(live).take(urdf('two', 'base', radius=0.2))


TWO = """
left: {namespace: /left, pose: {position: [0, 1, 0]}, padding: 0.01, frame_prefix: left/}
right: {topic: /right/robot_description, joint_states: /right/joint_states}
"""


def test_several_robots_of_one_urdf_have_names_topics_and_bases_of_their_own():
    live = live_scene('sources: [cell]\n', Clock(1000.0))
    joints = JointInput(live.clocks, 1.0, by_default=False)
    left, right = robot_topics_of_text(TWO, 'example')
    assert left.topics == ('/left/robot_description', '/left/robot_description_semantic')
    assert right.topics == ('/right/robot_description',)
    for topics in (left, right):
        assert 'added' in RobotInput(live, topics).take(ARM)
    assert sources(live) == {'cell', 'left', 'right'}
    with live.editing() as scene:
        assert joints.topics(scene) == {'/left/joint_states', '/right/joint_states'}
        joints.take(scene, state(JOINTS_OF_ARM, TURNED), 0.0, '/left/joint_states')
        assert scene.query.X_WF(scene.model.names.frame('left::base')).translation()[1] == 1.0
        inspector = scene.model.inspector
        (ball,) = inspector.GetGeometries(scene.model.names.frame('left::hand'))
        properties = inspector.GetProximityProperties(ball)
        assert properties.GetProperty('proximity', 'padding') == 0.01
        waiting = {scene.model.names.frame_names[f] for f in scene.query.waiting_frames()}
    assert hand(live, 'left')[1] > 1.0
    assert 'right::hand' in waiting, 'it has neither a base nor joints'
    assert {robot.name: robot.frame_prefix for robot in scene.model.robots} == {
        'left': 'left/',
        'right': '',
    }


@pytest.mark.parametrize('is_first', [True, False])
def test_the_order_in_which_topics_come_does_not_count(folder, is_first):
    live, _ = opened(folder, 'name: arm1')
    (topics,) = robot_topics_of_text('{arm2: {namespace: /two}}', 'example')
    inputs = [RobotInput(live), RobotInput(live, topics)]
    done = [robot.take(ARM) for robot in (inputs if is_first else inputs[::-1])]
    assert sources(live) == {'arm1', 'arm2'}
    assert sum("this is 'arm1'" in each for each in done) == 1


def test_a_named_robot_of_the_scene_file_gets_its_joint_topic(folder):
    live, joints = opened(folder, 'name: arm1', 'name: arm2')
    (topics,) = robot_topics_of_text('{arm2: {namespace: /two}}', 'example')
    done = RobotInput(live, topics).take(ARM)
    assert "this is 'arm2' of the scene" in done
    assert 'the joints of /two/joint_states' in done
    with live.editing() as scene:
        joints.take(scene, state(JOINTS_OF_ARM, ZERO), 0.0)  # those of arm1 alone by now
        joints.take(scene, state(JOINTS_OF_ARM, TURNED), 0.0, '/two/joint_states')
    assert hand(live, 'arm1') != hand(live, 'arm2')


def test_names_of_two_robots_are_refused_with_a_way_out(folder):
    live, joints = opened(folder, 'name: arm1', 'name: arm2')
    with live.editing() as scene, pytest.raises(RuntimeError, match='robot_descriptions'):
        joints.take(scene, state(JOINTS_OF_ARM, ZERO), 0.0)


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('{left: {}}', "'left' has no topic"),
        ('{left: {topic: /a}, right: {topic: /a}}', "'/a' describes 'left', too"),
        ('{left: {topic: /a, semantic_topic: /a}}', "'/a' describes 'left', too"),
        ('{left: {topc: /a}}', 'topc'),
        ('{left: {topic: /a, pose: {quaternion: [0, 0, 0, 2]}}}', 'example:1: .*uaternion'),
        ('[left]', 'a mapping'),
        ('{}', 'example:1'),
    ],
)
def test_what_names_no_robots_is_refused(text, words):
    with pytest.raises(SceneFileError, match=words):
        robot_topics_of_text(text, 'example')
