"""Robots of a live scene that stand in a configuration, or on a frame of another robot."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.inputs.test_joint_input import (
    ARM,
    AT,
    GAP,
    JOINTS_OF_ARM,
    X_WB,
    assert_stands,
    expected,
    opened,
    place,
    pose,
    scene_text,
    state,
    waiting,
)
from live.live_scenes import Clock
from live.services.test_states import NO_POSES, answer

from drake_geom_ros.live.scene.changes.addition import exchange
from drake_geom_ros.live.scene.changes.removal import in_order_of_removal
from drake_geom_ros.live.services.queries import get_joint_positions
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files import read_scene, to_yaml

READY = 'configuration: {shoulder: 0.5, wrist: -0.3, finger: 0.02}'
Q_READY = (0.5, -0.3, 0.02)
CART = 'frames: [{name: cart, source: cell, pose: {position: [1, 2, 3]}}]'


@pytest.fixture
def clock():
    return Clock(1000.0)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / 'arm.urdf').write_text(ARM)
    return tmp_path


def joint_positions(live, *names):
    response = Plain(names=[], positions=[], velocities=[], ages=[], waiting=[])
    get_joint_positions(live, Plain(names=list(names)), response)
    return response


def test_a_robot_stands_as_its_file_says_and_its_age_is_unknown(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}, {READY}'), clock)
    with live.editing() as scene:
        assert not waiting(scene)
        assert_stands(scene, Q_READY, X_WB)
        ages = scene.poses.ages_by_name()
        assert math.isinf(ages['arm::hand'])
        assert ages['arm::mark'] == 0.0
        assert math.isinf(scene.moment().oldest_pose_age)
        (told,) = joints.troubles(scene, 1.0)
        assert told == (
            "nothing was heard of 3 joints of 'arm'; there the scene file counts: "
            'shoulder, wrist, finger; publish them on joint_states'
        )


def test_messages_of_some_joints_leave_the_others_as_the_file_says(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}, {READY}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(['shoulder'], [1.0], 1000.0), 0.0)
        assert_stands(scene, (1.0, *Q_READY[1:]), X_WB)
        ages = scene.poses.ages_by_name()
        assert ages['arm::upper'] == 0.0
        assert math.isinf(ages['arm::hand'])
        assert not scene.poses.unknown_ages().frames  # no clock jumped
        joints.take(scene, state(['wrist', 'finger'], [0.0, 0.0], 1000.0), 0.0)
        assert scene.poses.ages_by_name()['arm::hand'] == 0.0
        assert not joints.troubles(scene, 1.0)


def test_what_is_asked_of_some_joints_takes_the_others_from_the_file(folder, clock):
    live, _ = opened(scene_text(folder, f'name: arm, {AT}, {READY}'), clock)
    found = answer(live, np.zeros((1, 1)), names=['shoulder'], want='least')
    whole = answer(live, np.array([[0.0, *Q_READY[1:]]]), want='least')
    assert list(found.distance) == list(whole.distance)


def test_joints_tell_value_speed_age_and_what_waits(folder, clock):
    live, joints = opened(
        scene_text(folder, f'name: arm, {AT}, configuration: {{wrist: 0.4}}'), clock
    )
    with live.editing() as scene:
        joints.take(scene, state(['shoulder'], [1.0], 1000.0, [0.25]), 0.0)
    clock.now += 2.0
    found = joint_positions(live)
    assert found.names == [f'arm::{name}' for name in JOINTS_OF_ARM]
    np.testing.assert_array_equal(found.positions, [1.0, 0.4, math.nan])
    np.testing.assert_array_equal(found.velocities, [0.25, math.nan, math.nan])
    assert found.ages == [2.0, math.inf, math.inf]
    assert found.waiting == [False, False, True]
    assert joint_positions(live, 'wrist').positions == [0.4]
    live.clocks.begin_anew()
    assert joint_positions(live, 'shoulder').ages == [math.inf]
    with pytest.raises(RuntimeError, match="no joint 'elbow'"):
        joint_positions(live, 'elbow')


def test_a_saved_scene_stands_where_the_robot_is_now(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}, {READY}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(['shoulder'], [2.5], 1000.0), 0.0)  # beyond its limit
        text = to_yaml(scene.description())
    again, _ = opened(text, clock)
    with again.editing() as scene:
        assert scene.model.joints.robots['arm'].configuration() == {
            'shoulder': 2.5,
            'wrist': -0.3,
            'finger': 0.02,
        }
        assert_stands(scene, (2.5, *Q_READY[1:]), X_WB)
        assert to_yaml(scene.description()) == text


def mounted(folder, *, more=''):
    first = f'name: big, mounted_on: cart{more}'
    second = 'name: tool, mounted_on: big::left, pose: {position: [0, 0, 0.2]}'
    return f'{scene_text(folder, second, first)}\n{CART}'


NAMES = [f'{robot}::{joint}' for robot in ('big', 'tool') for joint in JOINTS_OF_ARM]
Q = (0.5, -0.3, 0.02, -0.4, 0.8, 0.05)


def assert_both_stand(scene, q, X_WC):
    assert_stands(scene, q[:3], X_WC, 'big')
    X_WM = RigidTransform(expected(q[:3], X_WC)['left']) @ RigidTransform([0, 0, 0.2])
    for link, X_WL in expected(q[3:], X_WM).items():
        np.testing.assert_allclose(pose(scene, f'tool::{link}'), X_WL, rtol=0, atol=1e-13)


def test_a_robot_moves_with_what_carries_it(folder, clock):
    live, joints = opened(mounted(folder), clock)
    with live.editing() as scene:
        joints.take(scene, state(NAMES, Q, 1000.0), 0.0)
        assert not waiting(scene)
        assert_both_stand(scene, Q, X_WB)
        # The carriers move, and nothing is heard of what they carry.
        place(scene, 'cart', RigidTransform([0, 0, 5]))
        joints.follow(scene)
        assert_both_stand(scene, Q, RigidTransform([0, 0, 5]))
        joints.take(scene, state(NAMES[:3], (0.1, 0.2, 0.03), 1000.1), 0.0)
        assert_both_stand(scene, (0.1, 0.2, 0.03, *Q[3:]), RigidTransform([0, 0, 5]))
        assert not scene.troubles()


def test_what_if_poses_and_joints_carry_robots_along(folder, clock):
    live, joints = opened(mounted(folder), clock)
    with live.editing() as scene:
        joints.take(scene, state(NAMES, Q, 1000.0), 0.0)
    moved = {'frame_names': ['cart'], 'poses': [0, 0, 5, 0, 0, 0, 1.0]}
    view = live.view(
        Plain(**{**vars(NO_POSES), **moved}), Plain(names=['big::shoulder'], positions=[1.0])
    )
    X_WM = RigidTransform(expected((1.0, *Q[1:3]), RigidTransform([0, 0, 5]))['left'])
    X_WLs = expected(Q[3:], X_WM @ RigidTransform([0, 0, 0.2]))
    for link in ('base', 'hand', 'right'):
        found = view.query.X_WF(view.names.frame(f'tool::{link}'))
        np.testing.assert_allclose(found.GetAsMatrix4(), X_WLs[link], rtol=0, atol=1e-13)


def test_states_of_a_carrier_move_what_it_carries(folder, clock):
    live, joints = opened(mounted(folder), clock)
    with live.editing() as scene:
        joints.take(scene, state(NAMES, Q, 1000.0), 0.0)
    rows = np.random.default_rng(2).uniform(-1, 2, (20, 1))
    found = answer(live, rows, names=['big::shoulder'], want='least', ignore_limits=True)
    for k, (value,) in enumerate(rows):
        what_if = Plain(names=['big::shoulder'], positions=[value])
        pairs = live.view(NO_POSES, what_if).query.ComputeSignedDistancePairwiseClosestPoints()
        assert found.distance[k] == pairs.distance.min()


def test_speeds_of_the_carriers_joints_reach_what_it_carries(folder, clock):
    live, joints = opened(mounted(folder), clock)
    rates, step = np.array([0.5, -1.0, 0.2, 0.3, -0.6, 0.1]), 1e-6
    with live.editing() as scene:
        scene.poses.watch_motion(GAP)
        joints.take(scene, state(NAMES, Q, 1000.0, rates), 0.0)
        twists = scene.poses.twists()
        ends = []
        for sign in (-1, 1):
            q = np.array(Q) + sign * step * rates
            X_WM = RigidTransform(expected(q[:3], X_WB)['left']) @ RigidTransform([0, 0, 0.2])
            ends.append(expected(q[3:], X_WM))
        for link in ('upper', 'hand', 'left', 'right'):
            moved = (ends[1][link] - ends[0][link]) / (2.0 * step)
            V = twists[scene.model.names.frame(f'tool::{link}')]
            np.testing.assert_allclose(V[3:], moved[:3, 3], rtol=0, atol=1e-8)
        # A later message of the carrier alone changes the twist of what it carries, too.
        joints.take(scene, state(NAMES[:3], Q[:3], 1000.0, (0.0, 0.0, 0.0)), 0.0)
        V = scene.poses.twists()[scene.model.names.frame('tool::base')]
        assert not V.any()


def test_a_carrier_is_replaced_with_what_it_carries_or_not_at_all(folder, clock):
    live, joints = opened(mounted(folder), clock)
    text = mounted(folder)
    with live.editing() as scene:
        joints.take(scene, state(NAMES, Q, 1000.0), 0.0)
        names = scene.model.names
        described = read_scene(text)
        with pytest.raises(RuntimeError, match="of 'tool' are mounted on its frames"):
            scene.make(exchange(scene, [names.source('big')], described))
        sources = in_order_of_removal(
            scene.model.inspector, map(names.source, ('cell', 'big', 'tool'))
        )
        assert [scene.model.inspector.GetName(s) for s in sources] == ['tool', 'big', 'cell']
        scene.make(exchange(scene, sources, described))
        joints.follow(scene)
        assert_both_stand(scene, Q, X_WB)


def test_a_mounted_robot_waits_for_its_carrier(folder, clock):
    text = mounted(folder).replace(', pose: {position: [1, 2, 3]}}]', '}]')
    live, joints = opened(text, clock)
    with live.editing() as scene:
        joints.take(scene, state(NAMES, Q, 1000.0), 0.0)
        assert waiting(scene) == {'cart'}
        assert not scene.query.is_placed(scene.model.names.frame('tool::hand'))
        place(scene, 'cart', X_WB)
        assert_both_stand(scene, Q, X_WB)


HELD = 'held_joints: {wrist: -0.3, finger: 0.02}'


def test_joints_that_nobody_publishes_are_held_and_never_stale(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}, {HELD}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(['shoulder'], [1.0], 1000.0), 0.0)
        assert_stands(scene, (1.0, -0.3, 0.02), X_WB)
        assert set(scene.poses.ages_by_name().values()) == {0.0}
        assert joints.troubles(scene, 1.0) == []
        clock.now += 0.5
        assert scene.poses.ages_by_name()['arm::hand'] == 0.5  # that of the shoulder


def test_a_robot_all_of_whose_joints_are_held_stands_for_ever(folder, clock):
    every = 'held_joints: {shoulder: 0.5, wrist: -0.3, finger: 0.02}'
    live, joints = opened(scene_text(folder, f'name: arm, {AT}, {every}'), clock)
    clock.now += 100.0
    with live.editing() as scene:
        assert_stands(scene, Q_READY, X_WB)
        assert set(scene.poses.ages_by_name().values()) == {0.0}
        assert scene.blind_frames(1.0).stale == set()
        assert joints.troubles(scene, 1.0) == []
    assert joint_positions(live).ages == [0.0] * 3


def test_a_held_joint_of_which_values_come_is_held_no_more_and_somebody_says_so(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}, {HELD}'), clock)
    with live.editing() as scene:
        joints.take(scene, state(['shoulder', 'wrist'], [1.0, 0.25], 1000.0), 0.0)
        assert_stands(scene, (1.0, 0.25, 0.02), X_WB)
        (told,) = joints.troubles(scene, 1.0)
        assert told.startswith("held_joints of 'arm' names wrist, of which values are published")
        clock.now += 2.0
        assert len(joints.troubles(scene, 1.0)) == 2  # and the joints are stale
        saved = read_scene(to_yaml(scene.description()))
    (robot,) = saved.robots
    assert robot.held_joints == ('finger',)
    assert robot.configuration == {'shoulder': 1.0, 'wrist': 0.25, 'finger': 0.02}


def test_what_a_scene_held_another_one_does_not(folder, clock):
    live, joints = opened(scene_text(folder, f'name: arm, {AT}, {HELD}'), clock)
    with live.editing() as scene:
        sources = in_order_of_removal(scene.model.inspector, [scene.model.names.source('arm')])
        scene.make(exchange(scene, sources, read_scene(scene_text(folder, f'name: arm, {AT}'))))
        joints.follow(scene)
        assert scene.model.joints.robots['arm'].without_value() == ['shoulder', 'wrist', 'finger']
