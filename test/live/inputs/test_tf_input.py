"""TF to poses of a live scene, without ROS: names, chains, gaps, time that goes back."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.inputs.tf_messages import TEXT, at, message, position, take, transform
from live.live_scenes import live_scene

from drake_geom_ros.geometry import FramePoseVector
from drake_geom_ros.live.inputs import tf_input
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.live.scene.changes.addition import addition
from drake_geom_ros.live.scene.clocks import ALWAYS, Clocks
from drake_geom_ros.live.scene.feeders import MESSAGES
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import read_scene

NO_STAMP = Plain(sec=0, nanosec=0)


def test_a_frame_takes_the_transform_of_its_name(scene, tf):
    assert take(tf, scene, message(transform('world', 'tool', at(1))), static=False) == 1
    assert position(scene, 'tool') == [1, 0, 0]


def test_a_name_that_two_sources_have_needs_the_source(scene, tf):
    assert take(tf, scene, message(transform('world', 'base', at(1))), static=False) == 0
    assert take(tf, scene, message(transform('world', 'right/base', at(2))), static=False) == 1
    assert position(scene, 'right::base') == [2, 0, 0]
    assert not scene.query.is_placed(scene.model.names.frame('left::base'))


def test_a_chain_is_followed_to_the_world_in_any_order_of_arrival(scene, tf):
    X_AB = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3).ToRotationMatrix(), [1.0, 2.0, 3.0])
    assert take(tf, scene, message(transform('/odom', 'tool', X_AB)), static=False) == 0
    assert take(tf, scene, message(transform('map', 'odom', X_AB)), static=True) == 0
    assert take(tf, scene, message(transform('world', 'map', X_AB)), static=True) == 1
    X_WF = scene.query.X_WF(scene.model.names.frame('tool'))
    expected = (X_AB @ X_AB @ X_AB).GetAsMatrix4()
    np.testing.assert_allclose(X_WF.GetAsMatrix4(), expected, rtol=0, atol=1e-14)


def test_a_nested_frame_is_posed_in_its_parent(scene, tf):
    both = transform('world', 'left/base', at(1)), transform('left/base', 'hand', at(2))
    assert take(tf, scene, message(*both), static=False) == 2
    assert position(scene, 'hand') == [3, 0, 0]
    assert scene.query.X_PF(scene.model.names.frame('hand')).translation().tolist() == [2, 0, 0]
    # The parent moves alone: both must follow, and the hand goes with it.
    assert take(tf, scene, message(transform('world', 'left/base', at(5))), static=False) == 2
    assert position(scene, 'hand') == [7, 0, 0]
    # TF knows the hand in the world, and nothing of its base, which stays.
    text = TEXT.replace('base, source: left', 'base, source: left, pose: {}')
    with live_scene(text).editing() as fresh:
        tf = TfInput(Clocks(lambda: 0.0))
        take(tf, fresh, message(transform('world', 'hand', at(4))), static=False)
        assert position(fresh, 'hand') == [4, 0, 0]


def test_what_hangs_on_a_frame_that_waits_waits_with_it(scene, tf):
    """In the world TF knows the hand; in its base, of which nobody knows where it is, nobody."""
    base, hand = scene.model.names.frame('left::base'), scene.model.names.frame('hand')
    assert take(tf, scene, message(transform('world', 'hand', at(4))), static=True) == 0
    assert take(tf, scene, message(transform('world', 'tool', at(1))), static=False) == 1
    assert {base, hand} <= set(scene.query.waiting_frames())
    # The base gets its pose elsewhere; with whatever TF brings next the hand follows.
    scene.poses.pose(
        FramePoseVector({base: at(1)}), {frozenset([base.get_value()]): ALWAYS}, NO_STAMP, MESSAGES
    )
    assert take(tf, scene, message(transform('world', 'tool', at(2))), static=False) == 2
    assert position(scene, 'hand') == [4, 0, 0]
    assert scene.query.X_PF(hand).translation().tolist() == [3, 0, 0]


def test_the_stamp_is_that_of_the_newest_transform_wherever_it_stands(scene, tf):
    both = transform('world', 'tool', at(1), 20.0), transform('world', 'left/base', at(1), 10.0)
    take(tf, scene, message(*both), static=False)
    assert scene.moment().newest_stamp.sec == 20
    take(tf, scene, message(transform('world', 'left/base', at(1), 15.0)), static=False)
    assert scene.moment().newest_stamp.sec == 20


def test_a_loop_of_frames_leads_nowhere(scene, tf):
    loop = transform('a', 'tool', at(1)), transform('tool', 'a', at(1))
    assert take(tf, scene, message(*loop), static=False) == 0
    assert take(tf, scene, message(transform('world', 'a', at(1))), static=False) == 1
    assert position(scene, 'tool') == [2, 0, 0]


def test_a_gap_makes_poses_stale_not_wrong(scene, tf, clock):
    take(
        tf,
        scene,
        message(transform('world', 'cart', at(1)), transform('cart', 'tool', at(1))),
        static=False,
    )
    clock.now += 3.0
    # One link of the chain goes on, the other is silent: the pose is as old as the silent one.
    take(tf, scene, message(transform('cart', 'tool', at(2))), static=False)
    assert position(scene, 'tool') == [3, 0, 0]
    assert scene.poses.ages_by_name()['right::tool'] == pytest.approx(3.0)
    take(tf, scene, message(transform('world', 'cart', at(1))), static=False)
    assert scene.poses.ages_by_name()['right::tool'] == 0.0


def test_a_chain_over_a_jump_of_the_clock_has_no_age_until_all_of_it_is_new(
    live, scene, tf, clock
):
    links = transform('world', 'cart', at(1), 999.5), transform('cart', 'tool', at(1), 999.0)
    take(tf, scene, message(transform('world', 'left/base', at(0))), static=True)
    take(tf, scene, message(*links), static=False)
    assert scene.poses.ages_by_name()['right::tool'] == pytest.approx(1.0)
    clock.now = 999.75
    live.clocks.begin_anew()
    take(tf, scene, message(transform('cart', 'tool', at(2), 999.25)), static=False)
    ages = scene.poses.ages_by_name()
    assert math.isinf(ages['right::tool'])
    assert ages['left::base'] == 0.0
    take(tf, scene, message(transform('world', 'cart', at(1), 999.5)), static=False)
    assert scene.poses.ages_by_name()['right::tool'] == pytest.approx(0.5)


def test_what_is_static_does_not_grow_old(scene, tf, clock):
    take(tf, scene, message(transform('world', 'tool', at(1))), static=True)
    clock.now += 1e6
    assert scene.poses.ages_by_name()['right::tool'] == 0.0
    assert math.isinf(scene.poses.ages_by_name()['left::hand'])


def test_messages_that_came_together_pose_once_and_each_is_as_old_as_it_is(scene, tf, clock):
    cart = message(transform('world', 'cart', at(1), 999.25))
    tool = message(transform('cart', 'tool', at(1), 999.75))
    newer = message(transform('cart', 'tool', at(2), 999.9))
    assert take(tf, scene, cart, tool, newer, static=False) == 1
    assert position(scene, 'tool') == [3, 0, 0]
    assert scene.poses.ages_by_name()['right::tool'] == 0.75
    assert tf.pose(scene) == 0


def test_a_transform_without_a_stamp_is_as_old_as_its_message(scene, tf):
    tf.hear(message(transform('world', 'tool', at(1))), static=False, waited=0.5)
    tf.pose(scene)
    assert scene.poses.ages_by_name()['right::tool'] == 0.5


def test_a_transform_whose_old_stamp_is_repeated_is_not_new_again(scene, tf, clock):
    repeated = message(transform('world', 'tool', at(1), 999.5))
    for second in range(90):
        take(tf, scene, repeated, static=False)
        assert scene.poses.ages_by_name()['right::tool'] == pytest.approx(0.5 + second)
        clock.now += 1.0
    take(tf, scene, message(transform('world', 'tool', at(1), 1089.75)), static=False)
    assert scene.poses.ages_by_name()['right::tool'] == pytest.approx(0.25)


def test_a_late_transform_is_ignored(scene, tf):
    take(tf, scene, message(transform('world', 'tool', at(1), stamp=10.5)), static=False)
    assert (
        take(tf, scene, message(transform('world', 'tool', at(2), stamp=10.2)), static=False) == 0
    )
    assert position(scene, 'tool') == [1, 0, 0]


def test_of_two_transforms_of_a_frame_in_a_message_the_newer_one_counts(scene, tf):
    both = transform('world', 'tool', at(1), 10.5), transform('world', 'tool', at(2), 10.2)
    assert take(tf, scene, message(*both), static=False) == 1
    assert position(scene, 'tool') == [1, 0, 0]


def test_what_is_static_leaves_the_stamp_of_what_moves(scene, tf):
    take(tf, scene, message(transform('world', 'map', at(1), 3.0)), static=True)
    take(tf, scene, message(transform('map', 'tool', at(1), 50.0)), static=False)
    take(tf, scene, message(transform('world', 'map', at(2), 4.0)), static=True)
    assert position(scene, 'tool') == [3, 0, 0]
    assert scene.moment().newest_stamp.sec == 50


def test_more_frames_than_are_kept_are_refused(scene, tf, monkeypatch):
    monkeypatch.setattr(tf_input, '_MOST_FRAMES', 3)
    three = [transform('world', f'link{k}', at(k)) for k in range(3)]
    take(tf, scene, message(*three), static=False)
    take(tf, scene, message(*three), static=False)  # nothing new
    # Refused whole: neither is the frame known, nor has time gone back.
    with pytest.raises(RuntimeError, match='make 4 TF frames; at most 3'):
        take(tf, scene, message(transform('world', 'tool', at(1))), static=False)
    assert not scene.query.is_placed(scene.model.names.frame('right::tool'))


def test_time_that_goes_back_forgets_what_moved(scene, tf):
    take(tf, scene, message(transform('world', 'map', at(1))), static=True)
    chain = transform('map', 'cart', at(1), 50.0), transform('cart', 'tool', at(1), 50.0)
    take(tf, scene, message(*chain), static=False)
    # The bag begins anew: the old cart must not carry the new tool.
    assert take(tf, scene, message(transform('cart', 'tool', at(7), 3.0)), static=False) == 0
    assert position(scene, 'tool') == [3, 0, 0]
    assert take(tf, scene, message(transform('map', 'cart', at(0), 3.0)), static=False) == 1
    assert position(scene, 'tool') == [8, 0, 0]


def test_a_changed_scene_is_posed_by_what_is_known(scene, tf):
    take(tf, scene, message(transform('world', 'late', at(3))), static=True)
    scene.make(addition(read_scene('frames:\n- {name: late}')))
    assert tf.follow(scene) == 1
    assert position(scene, 'late') == [3, 0, 0]
    assert tf.follow(scene) == 0


@pytest.mark.parametrize(
    ('bad', 'words'),
    [
        (transform('world', '', at(1)), 'names must be given'),
        (transform('tool', 'tool', at(1)), 'differ'),
        (transform('world', 'tool', at(-1e300)), "'tool' in 'world' has a coordinate beyond"),
        (transform('world', 'tool', None), 'norm'),
        (transform('world', 'tool', None), 'finite'),
    ],
)
def test_a_bad_transform_is_left_out_and_named(scene, tf, bad, words):
    if words == 'norm':
        bad.transform.rotation.w = 2.0
    if words == 'finite':
        bad.transform.translation.x = math.nan
    good = transform('world', 'left/base', at(1))
    refusal = tf.hear(message(good, bad), static=False)
    assert tf.pose(scene) == 1
    assert refusal.transforms == 1
    assert refusal.reason.startswith('1 of 2 transforms were left out: ')
    assert words in refusal.reason
    assert repr(bad.child_frame_id) in refusal.reason
    assert position(scene, 'left::base') == [1, 0, 0]
    assert not scene.query.is_placed(scene.model.names.frame('right::tool'))


def test_of_many_bad_transforms_a_few_are_named(scene, tf):
    bad = [transform('world', f'bad{k}', at(1)) for k in range(7)]
    for entry in bad:
        entry.transform.translation.x = math.nan
    refusal = tf.hear(message(transform('world', 'tool', at(1)), *bad), static=True)
    assert refusal.transforms == 7
    assert refusal.reason.count('not finite') == 5
    assert refusal.reason.endswith(' and 2 more')
    assert tf.pose(scene) == 1


def test_what_was_let_go_stays_until_tf_speaks_of_it_again(scene, tf, clock):
    def move(x):
        moved = transform('world', 'gripper', at(x), clock.now - 10.0 + x)
        take(tf, scene, message(moved), static=False)

    take(tf, scene, message(transform('gripper', 'tool', at(1))), static=True)
    move(1)
    assert position(scene, 'tool') == [2, 0, 0]
    tool = scene.model.names.frame('tool')
    scene.poses.pose(
        FramePoseVector({tool: at(9)}), {frozenset([tool.get_value()]): ALWAYS}, NO_STAMP, MESSAGES
    )
    move(3)
    assert position(scene, 'tool') == [9, 0, 0]
    scene.make(addition(read_scene('frames:\n- {name: late}')))
    tf.follow(scene)
    assert position(scene, 'tool') == [9, 0, 0]
    clock.now += 2.0
    take(tf, scene, message(transform('gripper', 'tool', at(2))), static=True)
    assert position(scene, 'tool') == [5, 0, 0]
    assert scene.troubles() == []


def test_the_world_may_have_another_name(clock, tf):
    with live_scene(TEXT, clock, 'map').editing() as scene:
        assert take(tf, scene, message(transform('world', 'tool', at(1))), static=False) == 0
        assert take(tf, scene, message(transform('map', 'tool', at(2))), static=False) == 1


STANDING = TEXT.replace('base, source: left', 'base, source: left, pose: {position: [0, 0, 2]}')
STANDING = STANDING.replace(', parent: base', '')


def frame_poses(name, *xyz):
    return Plain(
        header=Plain(frame_id='', stamp=Plain(sec=0, nanosec=0)),
        source='left',
        frame_names=[name],
        frame_ids=[],
        poses=[*map(float, xyz), 0.0, 0.0, 0.0, 1.0],
    )


def test_what_hangs_on_a_frame_that_the_scene_file_poses_stands_on_it(clock):
    live = live_scene(STANDING, clock)
    tf = TfInput(live.clocks)
    with live.editing() as scene:
        chain = message(transform('left/base', 'left/hand', at(1.0), 1000.0))
        assert take(tf, scene, chain, static=False) == 1
        assert position(scene, 'hand') == [1, 0, 2]
        assert not tf.troubles(scene)
        assert scene.poses.ages_by_name()['left::hand'] == 0.0
        # TF may have the base itself later: then that counts.
        tf.hear(message(transform('world', 'left/base', at(5.0))), static=True)
        assert tf.pose(scene) == 2
        assert position(scene, 'hand') == [6, 0, 0]


def test_what_hangs_on_a_frame_that_messages_pose_follows_it_and_is_as_old(clock):
    live = live_scene(STANDING, clock)
    tf = TfInput(live.clocks)
    with live.editing() as scene:
        take(tf, scene, message(transform('left/base', 'left/hand', at(1.0))), static=True)
        assert tf.follow(scene) == 0
        scene.poses.take(frame_poses('base', 0, 3, 0))
        assert tf.follow(scene) == 1
        assert position(scene, 'hand') == [1, 3, 0]
        assert tf.follow(scene) == 0
        clock.now += 3.0
        assert scene.poses.ages_by_name()['left::hand'] == 3.0


def test_what_tf_posed_before_is_no_place_to_stand_on(scene, tf):
    """Its own transform is forgotten when time goes back: where it is now nobody says."""
    take(tf, scene, message(transform('world', 'left/base', at(1.0), 50.0)), static=False)
    take(tf, scene, message(transform('left/base', 'left/hand', at(1.0), 50.0)), static=False)
    later = message(transform('left/base', 'left/hand', at(2.0), 1.0))
    assert take(tf, scene, later, static=False) == 0
    assert position(scene, 'hand') == [2, 0, 0]
    assert any("chain ends in 'left/base'" in told for told in tf.troubles(scene))
