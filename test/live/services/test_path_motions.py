"""What ``check_motion`` says of a path beside its outcome, and what may be put in front of it."""

import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from live.inputs.test_joint_input import JOINTS_OF_ARM, state
from live.live_scenes import Clock, live_scene
from live.services.test_motions import answer, joint_values, trajectory
from live.watching.watched_arm import FAR, Cell, distance_to

from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.trajectories import JointSpline, JointTrajectory

CLEAR, CONTACT = 1, 2
ROWS = [(0.0, 0.0, 0.1), (0.8, 0.2, 0.1), (1.6, 0.0, 0.1)]
TIMES = (0.0, 1.0, 2.0)
STILL = {'velocities': [0.0] * 3}
SPLINE = JointSpline(JointTrajectory(TIMES, ROWS, [(0.0, 0.0, 0.0)] * 3))
AWAY = (-0.9, 0.0, 0.1)
BETWEEN = (math.cos(-0.5), math.sin(-0.5), 1.0)  # the hand passes on the way from there


@pytest.fixture
def cell(tmp_path):
    cell = Cell(tmp_path)
    cell.push(FAR)
    cell.stand(ROWS[0])
    return cell


def test_the_way_from_where_the_joints_are_is_put_in_front(cell):
    cell.stand(AWAY)
    path = trajectory(ROWS, TIMES, **STILL)
    with pytest.raises(RuntimeError, match='start_tolerance'):
        answer(cell.live, path=path)
    whole = answer(cell.live, path=path, start_now=True, approach_time=3.0)
    assert (whole.outcome, whole.times) == (CLEAR, [2.0, 2.0])
    cell.push(BETWEEN)
    found = answer(cell.live, path=path, start_now=True, approach_time=3.0)
    assert found.outcome == CONTACT
    assert -3.0 < found.times[0] <= found.times[1] < 0.0
    shoulder = AWAY[0] * -found.times[1] / 3.0  # straight from there to 0
    assert abs(distance_to(BETWEEN, (shoulder, 0.0, 0.1))) <= 1e-5
    straight = answer(cell.live, path=trajectory(ROWS, TIMES), start_now=True, approach_time=3.0)
    np.testing.assert_allclose(straight.times, found.times, rtol=0, atol=1e-5)


def test_the_way_may_begin_at_given_values(cell):
    path = trajectory(ROWS, TIMES, **STILL)
    values = dict(zip(JOINTS_OF_ARM, AWAY, strict=True))
    cell.push(BETWEEN)
    fields = {'start_now': True, 'approach_time': 3.0, 'start_joints': joint_values(**values)}
    found = answer(cell.live, path=path, **fields)
    assert found.outcome == CONTACT
    assert found.times[1] < 0.0


@pytest.mark.parametrize(
    ('times', 'fields', 'words'),
    [
        (TIMES, {'start_now': True}, 'approach_time is 0'),
        (TIMES, {'approach_time': 1.0}, 'start_now is False'),
        (TIMES, {'start_now': True, 'approach_time': math.inf}, 'approach_time is inf'),
        (TIMES, {'start_now': True, 'approach_time': -1.0}, 'approach_time is -1'),
        ((1.0, 2.0, 3.0), {'start_now': True, 'approach_time': 1.0}, 'begins where the joints'),
        (TIMES, {'clearance_intervals': 10_001}, 'at most 10000'),
    ],
)
def test_what_cannot_be_meant_is_refused(cell, times, fields, words):
    with pytest.raises(RuntimeError, match=words):
        answer(cell.live, path=trajectory(ROWS, times, **STILL), **fields)


def test_clearances_bound_the_truth_by_intervals(cell):
    ball = (1.2 * math.cos(0.6), 1.2 * math.sin(0.6), 1.35)
    cell.push(ball)
    found = answer(cell.live, path=trajectory(ROWS, TIMES, **STILL), clearance_intervals=8)
    assert np.allclose(found.clearance_times, np.linspace(0.0, 2.0, 9))
    assert len(found.clearances) == 8
    for k, bound in enumerate(found.clearances):
        times = np.linspace(*found.clearance_times[k : k + 2], 200)
        # Of the arm itself too: the scan knows the ball alone.
        assert bound <= min(distance_to(ball, SPLINE.value(t)) for t in times) + 1e-9
    cell.push((math.cos(0.6), math.sin(0.6), 1.0))
    hit = answer(cell.live, path=trajectory(ROWS, TIMES, **STILL), clearance_intervals=8)
    touched = int(hit.times[1] * 4.0)
    assert list(hit.clearances)[touched] == -math.inf
    assert min(list(hit.clearances)[:touched]) > 0.0


def test_the_fastest_geometry_is_named_with_its_speed(cell):
    found = answer(cell.live, path=trajectory([ROWS[0], (1.0, 0.0, 0.1)], (0.0, 2.0)))
    # The shoulder turns at 0.5 rad/s, and the hand's ball reaches 1.1 m from its axis.
    assert found.cartesian_speed >= 0.5 * 1.1
    assert found.cartesian_speed <= 0.5 * 1.6
    assert found.fastest_geometry.split('::')[0] == 'arm'


CART = """<robot name="cart"><link name="rail"/>
<link name="cart"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="drone"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="slide" type="planar"><parent link="rail"/><child link="cart"/><axis xyz="0 0 1"/>
</joint>
<joint name="fly" type="floating"><parent link="rail"/><child link="drone"/></joint></robot>"""
VALUES = [*(f'slide/{k}' for k in ('x', 'y', 'theta'))]
VALUES += [*(f'fly/{k}' for k in ('x', 'y', 'z', 'yaw', 'pitch', 'roll'))]
YARD = """
sources: [yard]
robots: [{{name: cart, urdf: {folder}/cart.urdf, pose: {{}}}}]
geometries:
- {{name: post, source: yard, shape: {{type: sphere, radius: 0.1}}, pose: {{position: [2, 0, 0]}}}}
"""


@pytest.fixture
def yard(tmp_path):
    (tmp_path / 'cart.urdf').write_text(CART)
    live = live_scene(YARD.format(folder=tmp_path), Clock(1000.0))
    joints = JointInput(live.clocks, 1.0, by_default=True)
    with live.editing() as scene:
        joints.take(scene, state(VALUES, [0.0, 0, 0, 0, 0, 5.0, 0, 0, 0]), 0.0)
    return live


def transform(x=0.0, y=0.0, z=0.0, roll=0.0, pitch=0.0, yaw=0.0):
    q = RigidTransform(RollPitchYaw(roll, pitch, yaw), np.zeros(3)).ToArray()[3:].tolist()
    rotation = dict(zip('xyzw', q, strict=True))
    return Plain(translation=Plain(x=x, y=y, z=z), rotation=Plain(**rotation))


def several(names, rows, times, frame='', **derivatives):
    points = []
    for transforms, time in zip(rows, times, strict=True):
        whole, part = divmod(round(1e9 * time), 10**9)
        given = {'velocities': [], 'accelerations': [], **derivatives}
        time_from_start = Plain(sec=whole, nanosec=part)
        points.append(Plain(transforms=transforms, time_from_start=time_from_start, **given))
    return Plain(header=Plain(frame_id=frame), joint_names=names, points=points)


def test_a_planar_joint_takes_its_link_where_the_transforms_say(yard):
    way = several(['slide'], [[transform()], [transform(4.0, yaw=3.0)]], (0.0, 4.0))
    found = answer(yard, multi_dof_path=way)
    assert found.outcome == CONTACT
    assert found.times[0] <= 1.8 <= found.times[1] <= found.times[0] + 1e-6
    aside = several(
        ['cart::slide'], [[transform()], [transform(0.0, 2.0)], [transform(4.0, 2.0)]], (0, 1, 3)
    )
    assert answer(yard, multi_dof_path=aside).outcome == CLEAR


def test_a_floating_joint_goes_beside_a_path(yard):
    names = ['slide/x', 'slide/y', 'slide/theta']
    away = trajectory([(0.0, 0.0, 0.0), (0.0, 4.0, 0.0)], (0.0, 4.0), names=names)
    turned = transform(4.0, roll=0.3, pitch=-0.4, yaw=3.0)
    fly = several(['fly'], [[transform(0.0, 0.0, 5.0)], [turned]], (0.0, 4.0))
    found = answer(yard, path=away, multi_dof_path=fly)
    x, z = (lambda t: t), (lambda t: 5.0 - 1.25 * t)
    times = np.linspace(0.0, 4.0, 4001)
    first = next((t for t in times if math.hypot(x(t) - 2.0, z(t)) <= 0.2), math.inf)
    assert first == math.inf
    assert found.outcome == CLEAR
    low = several(['fly'], [[transform(0.0, 0.0, 0.3)], [transform(4.0, 0.0, 0.0)]], (0.0, 4.0))
    assert answer(yard, path=away, multi_dof_path=low, min_distance=0.0).outcome == CONTACT
    other = several(['fly'], [[transform()], [turned]], (0.0, 3.0))
    with pytest.raises(RuntimeError, match='the same times'):
        answer(yard, path=away, multi_dof_path=other)


def test_turns_go_by_the_shorter_way(yard):
    yaws = (3.0, -3.0, 3.0)
    way = several(['slide'], [[transform(0.0, 3.0, yaw=yaw)] for yaw in yaws], (0.0, 1.0, 2.0))
    found = answer(yard, multi_dof_path=way)
    assert found.joint_speed == pytest.approx(2.0 * math.pi - 6.0, rel=1e-9)


@pytest.mark.parametrize(
    ('names', 'rows', 'words'),
    [
        (['roll'], [[transform()]], "'roll', which is 0 planar or floating"),
        (['world'], [[transform()]], "'world', which is the world"),
        (['drone'], [[transform()]], "'drone', a link that joints of 'cart' move"),
        (['slide', 'cart::slide'], [[transform()] * 2], 'names a joint twice'),
        (['slide'], [[]], 'has 0 transforms for 1 joints'),
        (['slide'], [[transform(z=0.1)]], 'out of its plane'),
        (['slide'], [[transform(roll=0.1)]], 'out of its plane'),
        (['slide'], [[transform(math.nan)]], 'point 0 of multi_dof_path'),
    ],
)
def test_what_no_joint_can_do_is_refused(yard, names, rows, words):
    with pytest.raises(RuntimeError, match=words):
        answer(yard, multi_dof_path=several(names, rows, range(len(rows))))


@pytest.mark.parametrize('name', ['velocities', 'accelerations'])
def test_derivatives_of_several_values_are_refused_unless_the_way_is_to_be_straight(yard, name):
    rows = [[transform(0.0, 2.0)], [transform(4.0, 2.0)]]
    way = several(['slide'], rows, (0.0, 4.0), **{name: [Plain()]})
    with pytest.raises(RuntimeError, match=f'point 0 of multi_dof_path has {name}'):
        answer(yard, multi_dof_path=way)
    straight = answer(yard, multi_dof_path=way, profile='points')
    assert straight.outcome == CLEAR
    bare = answer(yard, multi_dof_path=several(['slide'], rows, (0.0, 4.0)))
    assert straight.lower_bound == bare.lower_bound


ROVER = """<robot name="rover">
<link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="mast"/>
<link name="hand"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="up" type="fixed"><parent link="base"/><child link="mast"/><origin xyz="0 0 1"/>
</joint>
<joint name="turn" type="revolute"><parent link="mast"/><child link="hand"/><axis xyz="0 0 1"/>
<origin xyz="0 0 0.5"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""
SEMANTICS = """<robot name="rover"><virtual_joint name="floor" type="planar" child_link="base"
parent_frame="world"/></robot>"""
HALL = """
sources: [hall]
robots: [{{name: rover, urdf: {folder}/rover.urdf, srdf: {folder}/rover.srdf, pose: {{}}}}]
frames:
- {{name: tray, source: hall, pose: {{position: [0, 5, 0]}}}}
- {{name: mug, source: hall, parent: tray, pose: {{position: [0, 0, 0.5]}}}}
- {{name: table, source: hall, pose: {{position: [0, 9, 0]}}}}
geometries:
- {{name: tray, source: hall, frame: tray, shape: {{type: sphere, radius: 0.1}}}}
- {{name: mug, source: hall, frame: mug, shape: {{type: sphere, radius: 0.1}}}}
- {{name: post, source: hall, shape: {{type: sphere, radius: 0.1}},
    pose: {{position: [2, 0, 1.5]}}}}
"""


def hall_in(tmp_path):
    """Return a live scene of a rover whose joint was heard, a tray with a mug, and a post."""
    (tmp_path / 'rover.urdf').write_text(ROVER)
    (tmp_path / 'rover.srdf').write_text(SEMANTICS)
    live = live_scene(HALL.format(folder=tmp_path), Clock(1000.0))
    joints = JointInput(live.clocks, 1.0, by_default=True)
    with live.editing() as scene:
        joints.take(scene, state(['turn'], [0.0]), 0.0)
    return live


@pytest.fixture
def hall(tmp_path):
    return hall_in(tmp_path)


DRIVE = [[transform()], [transform(4.0)]]


def touches(found, time):
    return found.times[0] <= time <= found.times[1] <= found.times[0] + 2e-6


def test_a_frame_goes_with_all_that_hangs_on_it(hall):
    rows = [[transform(0.0, 5.0)], [transform(2.0, 0.0, 1.0)]]
    found = answer(hall, multi_dof_path=several(['tray'], rows, (0.0, 4.0)))
    # The mug, 0.5 m above, ends in the post; it comes along a straight way.
    length = math.sqrt(2.0**2 + 5.0**2 + 1.0**2)
    assert found.outcome == CONTACT
    assert touches(found, 4.0 * (1.0 - 0.2 / length))
    assert {found.geometry_a, found.geometry_b} == {'hall::mug/mug', 'hall::world/post'}
    assert found.fastest_joint == 'tray/y'
    back = answer(hall, multi_dof_path=several(['hall::tray'], rows[::-1], (0.0, 4.0)))
    assert back.outcome == CONTACT
    assert back.times[1] == 0.0


@pytest.mark.parametrize('name', ['base', 'rover::base', 'floor'])
def test_a_robot_goes_with_its_root_link(hall, name):
    found = answer(hall, multi_dof_path=several([name], DRIVE, (0.0, 4.0), frame='world'))
    assert found.outcome == CONTACT
    assert touches(found, 1.8)  # the hand stands 1.5 m above the base
    assert {found.geometry_a.split('/')[0], found.geometry_b.split('/')[0]} == {
        'rover::hand',
        'hall::world',
    }
    aside = [[transform()], [transform(4.0, 1.0, yaw=2.0)]]
    clear = answer(hall, multi_dof_path=several([name], aside, (0.0, 4.0)))
    assert clear.outcome == CLEAR


def test_a_base_and_a_joint_of_one_robot_move_together(tmp_path):
    rng = np.random.default_rng(5)
    text = ROVER.replace('<link name="mast"/>', '<link name="mast"/><link name="tip">{}</link>')
    ball = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
    joint = (
        '<joint name="out" type="fixed"><parent link="hand"/><child link="tip"/>'
        '<origin xyz="0.7 0 0"/></joint></robot>'
    )
    text = text.format(ball).replace('</robot>', joint)
    (tmp_path / 'rover.urdf').write_text(text)
    (tmp_path / 'rover.srdf').write_text(SEMANTICS)
    live = live_scene(HALL.format(folder=tmp_path), Clock(1000.0))
    outcomes = set()
    for _ in range(25):
        x, y, yaw, turn = rng.uniform([1.0, -1.0, -2.0, -2.0], [3.5, 1.0, 2.0, 2.0])
        base = several(['base'], [[transform()], [transform(x, y, yaw=yaw)]], (0.0, 2.0))
        path = trajectory([(0.0,), (turn,)], (0.0, 2.0), names=['turn'])
        found = answer(live, path=path, multi_dof_path=base)
        s = np.linspace(0.0, 1.0, 20_001)
        angle = s * (yaw + turn)
        tip = np.column_stack([s * x + 0.7 * np.cos(angle), s * y + 0.7 * np.sin(angle)])
        hand = np.column_stack([s * x, s * y])
        gaps = [np.linalg.norm(p - [2.0, 0.0], axis=1) - 0.2 for p in (tip, hand)]
        near = np.flatnonzero(np.minimum(*gaps) <= 0.0)
        outcomes.add(found.outcome)
        if found.outcome == CLEAR:
            assert not len(near)
        else:
            assert len(near)
            assert 2.0 * s[near[0]] == pytest.approx(found.times[1], abs=1e-3)
    assert outcomes == {CLEAR, CONTACT}


@pytest.mark.parametrize(
    ('name', 'frame', 'words'),
    [
        ('tray', 'base', "frame_id 'base'; .* 'tray' are those in its parent, world"),
        (
            'mug',
            'world',
            "frame_id 'world'; .* 'mug' are those in its parent, hall::tray",
        ),
    ],
)
def test_poses_of_frames_are_those_in_their_parents(hall, name, frame, words):
    with pytest.raises(RuntimeError, match=words):
        answer(hall, multi_dof_path=several([name], DRIVE, (0.0, 1.0), frame=frame))


def test_the_way_from_where_a_frame_is_now_is_put_in_front(hall):
    rows = [[transform(4.0, 5.0)], [transform(4.0, 6.0)]]
    path = several(['tray'], rows, (0.0, 1.0))
    found = answer(hall, multi_dof_path=path, start_now=True, approach_time=2.0)
    assert found.outcome == CLEAR
    assert found.cartesian_speed >= 2.0
    with pytest.raises(RuntimeError, match='start_tolerance'):
        answer(hall, multi_dof_path=path, start_tolerance=0.01)
    later = several(['tray'], rows, (2.0, 3.0))
    assert answer(hall, multi_dof_path=later).cartesian_speed >= 2.0


def test_what_is_welded_to_the_world_is_not_moved(hall):
    with hall.editing() as scene:
        frame = scene.model.names.frame('table')
        scene.model.filter_manager.WeldToWorld([frame])
    with pytest.raises(RuntimeError, match='hall::table is welded to the world'):
        answer(hall, multi_dof_path=several(['table'], DRIVE, (0.0, 1.0)))
