"""Distances over a recording are those of the poses in it, to the bit; what is not known shows."""

from pathlib import Path

import numpy as np
import pytest
from recordings import recorder

from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.geometry import ArgumentError, SceneGraph
from drake_geom_ros.recordings import (
    IncompleteRecordingError,
    RecordingError,
    Topics,
    clearance,
    states,
)
from drake_geom_ros.scene_files import load_scene

CELL = Path(__file__).parents[1] / 'batch' / 'cell.yaml'
URDF = CELL.with_name('arm.urdf').read_text()
BALLS = """
sources: [s]
frames: [{name: a, source: s}, {name: b, source: s}]
geometries:
- {name: floor, source: s, shape: {type: half_space}, pose: {position: [0, 0, -1]}}
- {name: ball, source: s, frame: a, shape: {type: sphere, radius: 0.1}}
- {name: box, source: s, frame: b, shape: {type: box, size: [0.2, 0.2, 0.2]}}
"""
HERE = (0, 0, 0, 0, 0, 0, 1)


@pytest.fixture
def balls(tmp_path):
    file = tmp_path / 'balls.yaml'
    file.write_text(BALLS)
    return file


CART = """<robot name="cart"><link name="base"/>
<link name="cart"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="slide" type="planar"><parent link="base"/><child link="cart"/></joint></robot>"""
CART_SCENE = """
robots: [{name: cart, urdf: cart.urdf, pose: {position: [0, 0, 0]}}]
geometries: [{name: post, shape: {type: box, size: [0.1, 0.2, 0.3]}}]
"""


def random_rows(count, frames, seed=0):
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(count, frames, 7))
    rows[..., 3:] /= np.linalg.norm(rows[..., 3:], axis=-1, keepdims=True)
    return rows


def directly(scene, names, rows, **asked):
    scene_graph = SceneGraph()
    loaded = load_scene(scene, scene_graph)
    frames = [loaded.frames['s', name] for name in names]
    return evaluate(scene_graph, frames, rows, **asked)


def same(found, expected):
    there = np.isfinite(expected.distance)
    for name in ('distance', 'error_bound', 'p_WCa', 'p_WCb'):
        np.testing.assert_array_equal(getattr(found, name)[there], getattr(expected, name)[there])
    assert found.distance[~there].tolist() == expected.distance[~there].tolist()
    assert found.name_A.tolist() == expected.name_A.tolist()
    assert found.name_B.tolist() == expected.name_B.tolist()


def poses(times, names, rows, topic='/node/frame_poses'):
    return [
        (t, topic, recorder.frame_poses(t, names, row)) for t, row in zip(times, rows, strict=True)
    ]


@pytest.mark.parametrize('sqlite', [False, True])
def test_poses_of_messages_are_answered_as_evaluate_answers_them(tmp_path, balls, sqlite):
    rows, times = random_rows(40, 2), 0.05 * np.arange(40)
    run = recorder.record(tmp_path / 'run', poses(times, 'ab', rows), sqlite=sqlite)
    found = clearance(run, balls)
    same(found['all'], directly(balls, 'ab', rows))
    np.testing.assert_allclose(found.times, times, rtol=0, atol=1e-9)
    assert not found.reservations()
    least = found.least()
    assert least.distance == found['all'].distance[np.argmin(found['all'].lower_bound)]
    capped = clearance(run, balls, max_distance=0.3)
    same(capped['all'], directly(balls, 'ab', rows, max_distance=0.3))
    assert np.isinf(capped['all'].distance).any()


def test_joint_values_are_answered_as_evaluate_answers_them(tmp_path):
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene(CELL, scene_graph))
    rng = np.random.default_rng(1)
    q = rng.uniform(joints.lower.clip(-3), joints.upper.clip(max=3), (30, joints.count))
    names = [name.rpartition('::')[2] for name in joints.names]
    messages = [
        (0.1 * k, '/joint_states', recorder.joint_state(0.1 * k, names, row))
        for k, row in enumerate(q)
    ]
    found = clearance(recorder.record(tmp_path / 'run', messages), CELL)
    same(found['all'], evaluate(scene_graph, states=q, joints=joints))
    assert not found.reservations()


def test_joints_of_several_values_are_followed(tmp_path):
    """A planar joint has three values, and links between its parts that are no frames."""
    (tmp_path / 'cart.urdf').write_text(CART)
    (tmp_path / 'cart.yaml').write_text(CART_SCENE)
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene(tmp_path / 'cart.yaml', scene_graph))
    q = np.random.default_rng(1).uniform(-1.0, 1.0, (20, joints.count))
    names = [name.rpartition('::')[2] for name in joints.names]
    messages = [
        (0.1 * k, '/joint_states', recorder.joint_state(0.1 * k, names, row))
        for k, row in enumerate(q)
    ]
    run = recorder.record(tmp_path / 'run', messages)
    found = clearance(run, tmp_path / 'cart.yaml')
    same(found['all'], evaluate(scene_graph, states=q, joints=joints))
    assert not found.reservations()


def test_transforms_are_followed_to_the_world(tmp_path, balls):
    moves, base = np.linspace(-1.0, 1.0, 21), ('world', 'base', (0.5, 0, 0, 0, 0, 0, 1))
    messages = [(0.0, '/tf_static', recorder.transforms(0.0, base))]
    for k, x in enumerate(moves):
        t = 0.1 + 0.1 * k
        edges = ('base', 'a', (x, 0, 0, 0, 0, 0, 1)), ('world', 'b', HERE)
        messages.append((t, '/tf', recorder.transforms(t, *edges)))
    found = clearance(recorder.record(tmp_path / 'run', messages), balls, between=['a:b'])['a:b']
    x = np.abs(0.5 + moves)  # a ball of 0.1 from the face of a box at 0.1
    np.testing.assert_allclose(found.distance[x > 0.2], (x - 0.2)[x > 0.2], rtol=0, atol=1e-12)
    assert set(found.name_A) == {'s::a/ball'}


def test_a_set_of_pairs_is_asked_alone(tmp_path, balls):
    rows = random_rows(20, 2, seed=3)
    run = recorder.record(tmp_path / 'run', poses(0.1 * np.arange(20), 'ab', rows))
    found = clearance(run, balls, between=['s::a:s::b', ('floor', 'a')])
    assert set(found['s::a:s::b'].name_B) == {'s::b/box'}
    assert set(found['floor:a'].name_A) == {'s::world/floor'}
    both = np.minimum(found['s::a:s::b'].distance, found['floor:a'].distance)
    assert clearance(run, balls, between=['*:a'])['*:a'].distance.tolist() == both.tolist()
    with pytest.raises(ArgumentError, match=r'nobody.*stands for no geometry'):
        clearance(run, balls, between=['a:nobody'])
    with pytest.raises(ArgumentError, match='two names'):
        clearance(run, balls, between=['a::b'])
    with pytest.raises(ArgumentError, match='no pair'):
        clearance(run, balls, between=['a:a'])
    for twice in (['a:b', ('a', 'b')], [('a:b', 'c'), ('a', 'b:c')]):
        with pytest.raises(ArgumentError, match='two sets of pairs of one name'):
            clearance(run, balls, between=twice)


def test_what_waits_is_never_free(tmp_path, balls):
    messages = poses(0.1 * np.arange(5), 'a', [(0, 0, 1, 0, 0, 0, 1)] * 5)
    messages += poses(0.5 + 0.1 * np.arange(3), 'ab', [[HERE, HERE]] * 3)
    found = clearance(recorder.record(tmp_path / 'run', messages), balls)
    each = found['all']
    assert each.left_out.tolist() == [2] * 5 + [0] * 3
    assert np.isnan(each.distance[:5]).all()
    np.testing.assert_allclose(each.known_distance[:5], 1.9)  # above the floor
    assert each.waiting_frames == ('s::b',)
    with pytest.raises(IncompleteRecordingError, match='s::b'):
        found.least()
    assert found.least(allow_incomplete=True).distance < 0.0
    between = clearance(tmp_path / 'run', balls, between=['a:b'])['a:b']
    assert np.isnan(between.known_distance[:5]).all()


def test_what_is_stale_and_what_is_silent_is_never_free(tmp_path, balls):
    times = [0.1, *(0.2 + 0.2 * np.arange(10)), 6.1]
    messages = poses([0.0], 'a', [HERE]) + poses(times, 'b', [HERE] * 12)
    messages = sorted([*messages, *poses([6.0], 'a', [HERE])], key=lambda entry: entry[0])
    found = clearance(recorder.record(tmp_path / 'run', messages), balls, between=['a:b'])
    each = found['a:b']
    assert each.is_stale.tolist() == [*(found.times[:-2] > 1.0), True, False]
    assert np.isnan(each.distance[each.is_stale]).all()
    assert [(gap.begin, gap.end) for gap in found.gaps] == [pytest.approx((2.0, 6.0))]
    with pytest.raises(IncompleteRecordingError, match='1 gap without data'):
        found.least()


def test_a_rate_takes_the_state_of_that_time(tmp_path, balls):
    rows = random_rows(11, 2, seed=5)
    run = recorder.record(tmp_path / 'run', poses(0.1 * np.arange(11), 'ab', rows))
    found = clearance(run, balls, rate=20.0)
    np.testing.assert_allclose(found.times, 0.05 * np.arange(21), rtol=0, atol=1e-9)
    every = directly(balls, 'ab', rows).distance
    assert found['all'].distance.tolist() == np.repeat(every, 2)[:21].tolist()
    with pytest.raises(ArgumentError, match='rate'):
        clearance(run, balls, rate=-1.0)


def test_a_robot_comes_from_the_recording(tmp_path):
    joints = 'turn', 'bend', 'roll', 'slide'
    messages = [(0.0, '/robot_description', recorder.text(URDF))]
    for k in range(5):
        t = 0.1 + 0.1 * k
        messages.append((t, '/joint_states', recorder.joint_state(t, joints, [0.1 * k] * 4)))
    with pytest.raises(RecordingError, match='nothing that was recorded poses'):
        clearance(recorder.record(tmp_path / 'run', messages))  # nobody says where its base is
    base = recorder.transforms(0.0, ('world', 'base', HERE))
    messages.insert(0, (0.0, '/tf_static', base))
    found = clearance(recorder.record(tmp_path / 'posed', messages))
    assert np.isfinite(found['all'].distance[1:]).all()
    no_text = recorder.record(tmp_path / 'without', messages[2:])
    with pytest.raises(RecordingError, match='no scene was given'):
        clearance(no_text)


def test_simulated_time_that_jumps_makes_poses_of_unknown_age(tmp_path, balls):
    messages = []
    for k, now in enumerate((100.0, 100.1, 100.2, 5.0, 5.1, 5.2)):
        who = 'a' if k == 3 else 'ab'
        message = recorder.frame_poses(0.0, who, [HERE] * len(who))
        message.header.stamp.sec = message.header.stamp.nanosec = 0
        messages += [(0.1 * k, '/clock', recorder.clock(now)), (0.1 * k + 0.01, '/p', message)]
    found = clearance(recorder.record(tmp_path / 'run', messages), balls, between=['a:b'])
    assert found['a:b'].is_stale.tolist() == [False, False, False, True, False, False]
    assert any('clock jumped' in trouble.words for trouble in found.troubles)


def test_what_is_wrong_is_told_by_name(tmp_path, balls):
    edges = ('map', 'a', HERE), ('world', 'b', HERE)
    unlinked = [(0.1 * k, '/tf', recorder.transforms(0.1 * k, *edges)) for k in range(5)]
    found = clearance(recorder.record(tmp_path / 'unlinked', unlinked), balls)
    assert any("chain ends in 'map'" in trouble.words for trouble in found.troubles)
    assert found['all'].waiting_frames == ('s::a',)
    some = 'turn', 'bend', 'roll'
    silent = [
        (0.1 * k, '/joint_states', recorder.joint_state(0.1 * k, some, [0] * 3)) for k in range(5)
    ]
    found = clearance(recorder.record(tmp_path / 'silent', silent), CELL)
    assert any('slide' in trouble.words for trouble in found.troubles)
    assert np.isnan(found['all'].distance).all()
    by_ids = [(0.0, '/p', recorder.frame_poses(0.0, (), [HERE], ids=[7]))]
    with pytest.raises(RecordingError, match='frame_names'):
        clearance(recorder.record(tmp_path / 'ids', by_ids), balls)


def test_topics_are_chosen_by_name(tmp_path, balls):
    rows = [[HERE, (x, 0, 0, 0, 0, 0, 1)] for x in (1.0, 2.0)]
    messages = poses([0.0], 'ab', rows[:1], '/one/poses') + poses([0.0], 'ab', rows[1:], '/two')
    run = recorder.record(tmp_path / 'run', messages)
    with pytest.raises(RecordingError, match='/one/poses and /two'):
        clearance(run, balls)
    found = clearance(run, balls, topics=Topics.of(['frame_poses=/two']), between=['a:b'])
    assert found['a:b'].distance[0] == pytest.approx(1.8)
    with pytest.raises(RecordingError, match='no topic'):
        clearance(run, balls, topics=Topics(frame_poses='/three'))
    with pytest.raises(RecordingError, match='is of the type'):
        clearance(run, balls, topics=Topics(tf='/one/poses'))
    with pytest.raises(RecordingError, match='NAME=TOPIC'):
        Topics.of(['poses=/p'])


def test_nothing_depends_on_where_a_block_ends(tmp_path, balls, monkeypatch):
    rows, times = random_rows(30, 2, seed=7), 0.1 * np.arange(30)
    messages = poses(times, 'a', rows[:, 0]) + poses(times + 0.05, 'b', rows[:, 1])
    messages.sort(key=lambda entry: entry[0])
    run = recorder.record(tmp_path / 'run', messages)
    found = clearance(run, balls)
    for most in (1, 3, 7):
        monkeypatch.setattr(states, '_MOST_STATES', most)
        small = clearance(run, balls, threads=1)
        np.testing.assert_array_equal(found['all'].distance, small['all'].distance)
        np.testing.assert_array_equal(found.travelled, small.travelled)
    expected = directly(balls, 'ab', rows).distance
    np.testing.assert_array_equal(found['all'].distance[1::2], expected)


def test_a_robot_that_stands_as_the_scene_file_says_is_of_unknown_age(tmp_path):
    values = 'configuration: {turn: 0.1, bend: 0.2, roll: 0, slide: 0}'
    scene = tmp_path / 'cell.yaml'
    scene.write_text(CELL.read_text().replace('urdf: arm.urdf', f'urdf: arm.urdf, {values}'))
    (tmp_path / 'arm.urdf').write_text(URDF)
    messages = poses(0.1 * np.arange(5), ['things::tray'], [(0.6, 0.1, 0.4, 0, 0, 0, 1)] * 5)
    found = clearance(recorder.record(tmp_path / 'run', messages), scene)
    assert np.isinf(found['all'].age).all()
    assert np.isnan(found['all'].distance).all()
    assert np.isfinite(found['all'].known_distance).all()
    assert any('turn' in trouble.words for trouble in found.troubles)
    with pytest.raises(IncompleteRecordingError, match='stale'):
        found.least()


def test_another_description_replaces_the_robot_while_it_is_played(tmp_path):
    joints, base = ('turn', 'bend', 'roll', 'slide'), ('world', 'base', HERE)
    larger = URDF.replace('radius="0.0', 'radius="0.1').replace('0.1 0.12 0.4', '0.2 0.2 0.4')
    messages = [
        (0.0, '/robot_description', recorder.text(URDF)),
        (0.0, '/tf_static', recorder.transforms(0.0, base)),
    ]
    for k in range(10):
        t = 0.1 + 0.1 * k
        messages.append((t, '/joint_states', recorder.joint_state(t, joints, [0.1 * k] * 4)))
    other = [(0.0, '/robot_description', recorder.text(larger)), *messages[1:]]
    changed = [*messages[:7], (0.55, '/robot_description', recorder.text(larger)), *messages[7:]]
    first, second, both = (
        clearance(recorder.record(tmp_path / name, each))['all']
        for name, each in (('a', messages), ('b', other), ('c', changed))
    )
    assert len(both.times) == len(first.times)
    assert both.distance[1:6].tolist() == first.distance[1:6].tolist()
    assert both.distance[6:].tolist() == second.distance[6:].tolist()
    assert (first.distance[6:] != second.distance[6:]).any()
