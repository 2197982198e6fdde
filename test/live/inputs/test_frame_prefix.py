"""TF names with the frame_prefix of a robot_state_publisher; without ROS."""

import pytest
from live.inputs.tf_messages import at, message, position, transform
from live.live_scenes import Clock, live_scene

from drake_geom_ros.live.inputs.robot_description import RobotInput
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.scene_files import RobotOptions, read_scene, to_yaml

URDF = '<robot name="panda"><link name="base"/></robot>'


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def live(tmp_path, clock):
    (tmp_path / 'panda.urdf').write_text(URDF)
    text = ''.join(
        f'- {{name: {name}, urdf: {tmp_path}/panda.urdf, frame_prefix: {name}/}}\n'
        for name in ('left', 'right')
    )
    return live_scene(f'robots:\n{text}', clock)


def hear(tf, live, *transforms):
    tf.hear(message(*transforms), static=False)
    with live.editing() as scene:
        return tf.pose(scene)


def test_a_robot_follows_the_names_with_its_prefix_and_no_other(live):
    tf = TfInput(live.clocks)
    assert hear(tf, live, transform('world', 'base', at(9.0), 5.0)) == 0
    assert hear(tf, live, transform('world', 'left/base', at(1.0), 5.0)) == 1
    assert hear(tf, live, transform('world', 'right/base', at(2.0), 5.0)) == 1
    with live.reading() as scene:
        assert position(scene, 'left::base')[0] == 1.0
        assert position(scene, 'right::base')[0] == 2.0
        text = to_yaml(scene.description())
    assert [r.frame_prefix for r in read_scene(text).robots] == ['left/', 'right/']


def test_a_prefix_need_not_be_the_name_of_the_source(clock):
    live = live_scene('frames:\n- {name: cup}', clock)
    live.robot_options = RobotOptions(frame_prefix='a_')
    RobotInput(live).take(URDF)
    tf = TfInput(live.clocks)
    assert hear(tf, live, transform('world', 'base', at(9.0), 5.0)) == 0
    assert hear(tf, live, transform('world', 'a_base', at(1.0), 5.0)) == 1


def test_a_prefix_that_was_taken_away_keeps_nobody_from_the_plain_name(clock):
    """A name that TF once had counted for good, and the robot stood still."""
    live = live_scene('frames:\n- {name: base, source: panda}', clock)
    tf = TfInput(live.clocks)
    assert hear(tf, live, transform('world', 'panda/base', at(1.0), 5.0)) == 1
    clock.now += 0.5
    assert hear(tf, live, transform('world', 'base', at(2.0), 5.5)) == 0
    clock.now += 3.0
    assert hear(tf, live, transform('world', 'base', at(3.0), 8.5)) == 1
    with live.reading() as scene:
        assert position(scene, 'base')[0] == 3.0
    assert hear(tf, live, transform('world', 'panda/base', at(4.0), 9.0)) == 1
    with live.reading() as scene:
        assert position(scene, 'base')[0] == 4.0
