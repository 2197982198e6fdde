"""What is wrong with the tree of TF is told while it is wrong; without ROS."""

from live.inputs.tf_messages import at, message, take, transform
from live.live_scenes import live_scene

from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene.clocks import Clocks


def test_a_loop_is_told_while_it_is_there(scene, tf):
    loop = transform('a', 'tool', at(1)), transform('tool', 'a', at(1))
    take(tf, scene, message(*loop), static=False)
    assert tf.troubles(scene) == ["these TF frames form a loop: 'a', 'tool'"]
    take(tf, scene, message(transform('world', 'a', at(1))), static=False)
    assert tf.troubles(scene) == []


def test_two_parents_by_turns_are_told_and_a_frame_that_is_handed_over_is_none(scene, tf, clock):
    def send(parent):
        take(tf, scene, message(transform(parent, 'tool', at(1), clock.now)), static=False)
        clock.now += 0.1

    take(tf, scene, message(transform('world', 'left/base', at(1))), static=True)
    send('world')
    send('left/base')  # grasped
    clock.now += 2.0
    send('world')  # and put down
    assert tf.troubles(scene) == []
    send('left/base')
    told = "the TF frame 'tool' has two parents in turn: 'left/base' and 'world'. Stop one sender"
    assert tf.troubles(scene) == [told]
    send('left/base')
    assert tf.troubles(scene) == [told]
    clock.now += 6.0
    send('left/base')
    assert tf.troubles(scene) == []


def test_a_chain_that_ends_elsewhere_is_told_with_what_is_missing(scene, tf):
    chain = transform('base_link', 'odom', at(1)), transform('odom', 'tool', at(1))
    take(tf, scene, message(*chain), static=False)
    (told,) = tf.troubles(scene)
    assert told.startswith("1 frame from TF cannot be posed: 'tool'; the chain ends in")
    assert "the transform from the world frame 'world' to 'base_link'" in told
    assert 'world_frame:=base_link of a node' in told
    assert told.endswith('--world-frame base_link of a report')
    take(tf, scene, message(transform('world', 'base_link', at(1))), static=True)
    assert tf.troubles(scene) == []


def test_a_name_that_several_sources_have_is_told_with_both(scene, tf):
    take(tf, scene, message(transform('world', 'base', at(1))), static=False)
    (told,) = tf.troubles(scene)
    assert told.startswith("1 TF frame is not followed: 'base'; frames of the sources 'left' and")
    assert "robot_description_topic:=''" in told
    assert "'left/base'" in told
    take(tf, scene, message(transform('world', 'left/base', at(1))), static=False)
    assert tf.troubles(scene) == []


def test_a_tf_name_of_two_frames_poses_neither_and_is_told():
    text = """
    sources: [a, a/b, 'x::y']
    frames:
    - {name: b/c, source: a}
    - {name: c, source: a/b}
    - {name: d, source: 'x::y'}
    """
    with live_scene(text).editing() as scene:
        tf = TfInput(Clocks(lambda: 0.0))
        assert take(tf, scene, message(transform('world', 'a/b/c', at(1))), static=False) == 0
        (told,) = tf.troubles(scene)
        assert told == (
            "the TF frame 'a/b/c' is not followed: it stands for 'a::b/c' and 'a/b::c'. Rename one"
        )
        each = transform('world', 'c', at(2)), transform('world', 'x::y/d', at(3))
        assert take(tf, scene, message(*each), static=False) == 2
        assert scene.query.X_WF(scene.model.names.frame('a/b::c')).translation()[0] == 2
        assert scene.query.X_WF(scene.model.names.frame('x::y::d')).translation()[0] == 3
        assert not scene.query.is_placed(scene.model.names.frame('a::b/c'))
