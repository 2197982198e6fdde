"""A recording of another scene than the one that is given, or of another robot, says so."""

import numpy as np
import pytest
from recordings import recorder
from recordings.test_clearance import BALLS, CELL, HERE, URDF, balls  # noqa: F401
from recordings.test_what_is_lost import still

from drake_geom_ros.command_line.exit_codes import NO
from drake_geom_ros.command_line.program import main
from drake_geom_ros.recordings import Topics, audit, clearance
from drake_geom_ros.recordings.recorded_poses import recorded_poses

TOPIC = '/node/scene'
BLOCK = """
- {name: block, source: s, shape: {type: box, size: [1, 1, 1]}, pose: {position: [9, 0, 0]}}
"""
PART = """
- {name: part, source: s, frame: c, shape: {type: sphere, radius: 0.02}}
"""
ATTACHED = BALLS.replace('{name: b, source: s}', '{name: b, source: s}, {name: c, source: s}')


def recorded(folder, *scenes, end=0.3):
    """Return a run in which a node published its scene, as texts say it, while balls rested."""
    messages = still(np.arange(0.0, 1.0, 0.1))
    for k, text in enumerate(scenes):
        file = folder.parent / f'{folder.name}_{k}.yaml'
        file.write_text(text)
        messages.append((0.05 + end * k, TOPIC, recorder.scene(file)))
    return recorder.record(folder, sorted(messages, key=lambda each: each[0]))


def test_the_same_scene_is_no_reservation(tmp_path, balls):  # noqa: F811
    run = recorded(tmp_path / 'run', BALLS)
    assert clearance(run, balls, between=['a:b']).reservations() == []


@pytest.mark.parametrize(
    ('text', 'told'),
    [
        (BALLS + BLOCK, 'shows what the scene that is played here lacks: s::world/block'),
        (ATTACHED + PART, 'shows what the scene that is played here lacks: s::c'),
        (
            BALLS.replace('radius: 0.1', 'radius: 0.11'),
            'shows another shape than the scene that is played here: s::a/ball',
        ),
        (
            BALLS.replace('[0, 0, -1]', '[0, 0, -1.001]'),
            'shows another pose in its frame than the scene that is played here: s::world/floor',
        ),
        (
            BALLS.replace('{name: b, source: s}', '{name: b, source: s, parent: a}'),
            'shows another parent than the scene that is played here: s::b',
        ),
        (
            '\n'.join(line for line in BALLS.splitlines() if 'floor' not in line),
            'lacks what the scene that is played here has: s::world/floor',
        ),
    ],
    ids=['a block', 'a part', 'a shape', 'a pose', 'a parent', 'nothing'],
)
def test_what_the_recorded_scene_has_otherwise_is_a_reservation(
    tmp_path,
    balls,  # noqa: F811
    capsys,
    text,
    told,
):
    run = recorded(tmp_path / 'run', text)
    assert clearance(run, balls, between=['a:b']).reservations() == [f'{TOPIC} {told}']
    asked = ['report', str(run), '--scene', str(balls), '--out', str(tmp_path / 'out')]
    assert main(asked) == NO
    assert f'not known: {TOPIC} {told}' in capsys.readouterr().out
    said = []
    recorded_poses(run, balls, 10.0, warn=said.append)
    assert said == [f'{TOPIC} {told}']
    assert main([*asked, '--topic', 'scene=']) == 0


def test_an_audit_tells_of_another_scene(tmp_path, balls):  # noqa: F811
    file = tmp_path / 'other.yaml'
    file.write_text(BALLS + BLOCK)
    distances = recorder.empty('drake_geom_msgs/msg/SignedDistancePairs')
    messages = [*still([0.0, 0.1]), (0.2, '/node/signed_distances', distances)]
    messages.append((0.3, TOPIC, recorder.scene(file)))
    run = recorder.record(tmp_path / 'run', messages)
    assert any('lacks: s::world/block' in words for words in audit(run, balls).reservations())


def test_what_a_node_has_not_yet_when_it_starts_is_no_difference(tmp_path, balls):  # noqa: F811
    before = '\n'.join(line for line in BALLS.splitlines() if 'ball' not in line)
    run = recorded(tmp_path / 'run', before, BALLS)
    assert clearance(run, balls, between=['a:b']).reservations() == []


def test_what_was_there_for_a_while_is_a_difference(tmp_path, balls):  # noqa: F811
    without = '\n'.join(line for line in BALLS.splitlines() if 'floor' not in line)
    run = recorded(tmp_path / 'run', BALLS, BALLS + BLOCK, without, BALLS)
    told = clearance(run, balls, between=['a:b']).reservations()
    assert told == [
        f'{TOPIC} shows what the scene that is played here lacks: s::world/block',
        f'{TOPIC} lacks what the scene that is played here has: s::world/floor',
    ]


def test_the_scene_of_the_node_whose_poses_are_used_counts(tmp_path, balls):  # noqa: F811
    other = tmp_path / 'other.yaml'
    other.write_text(BALLS + BLOCK)
    messages = still(np.arange(0.0, 1.0, 0.1))
    messages[1:1] = [
        (0.05, TOPIC, recorder.scene(balls)),
        (0.05, '/b/scene', recorder.scene(other)),
    ]
    run = recorder.record(tmp_path / 'run', messages)
    assert clearance(run, balls, between=['a:b']).reservations() == []
    told = clearance(run, balls, between=['a:b'], topics=Topics(scene='/b/scene')).reservations()
    assert told == ['/b/scene shows what the scene that is played here lacks: s::world/block']


def of_robot(*more):
    """Return messages of a robot and of the balls, the robot in reach of the ball."""
    joints = 'turn', 'bend', 'roll', 'slide'
    messages = [(0.0, '/robot_description', recorder.text(URDF)), *more]
    messages.append((0.0, '/tf_static', recorder.transforms(0.0, ('world', 'base', HERE))))
    for k in range(5):
        t = 0.1 * k
        messages.append((t, '/joint_states', recorder.joint_state(t, joints, [0.1 * k] * 4)))
        row = [HERE, (1.0, 0, 0, 0, 0, 0, 1)]
        messages.append((t, '/node/frame_poses', recorder.frame_poses(t, 'ab', row)))
    return messages


def test_a_recorded_robot_comes_beside_the_scene_that_is_given(tmp_path, balls, capsys):  # noqa: F811
    run = recorder.record(tmp_path / 'run', of_robot())
    found = clearance(run, balls)
    names = {*found['all'].name_A, *found['all'].name_B}
    assert any(name.startswith('arm::') for name in names)
    assert np.nanmin(found['all'].known_distance) < 0.0
    alone = clearance(run, balls, topics=Topics(robot_description=''))
    assert not any(name.startswith('arm::') for name in alone['all'].name_A)


def test_a_robot_that_the_scene_has_is_not_taken_twice(tmp_path):
    scene = tmp_path / 'cell.yaml'
    scene.write_text(CELL.read_text())
    (tmp_path / 'arm.urdf').write_text(URDF)
    joints = recorder.joint_state(0.0, ['turn', 'bend', 'roll', 'slide'], [0.0] * 4)
    poses = recorder.frame_poses(0.0, ['tray'], [HERE])
    messages = [(0.0, '/robot_description', recorder.text(URDF))]
    messages += [(0.0, '/joint_states', joints), (0.0, '/p', poses)]
    run = recorder.record(tmp_path / 'run', messages)
    states = clearance(run, scene, rate=1.0)
    assert states.refused == ()
    thicker = URDF.replace('radius="0.0', 'radius="0.01')
    assert thicker != URDF
    messages[0] = (0.0, '/robot_description', recorder.text(thicker))
    run = recorder.record(tmp_path / 'other', messages)
    (refused,) = clearance(run, scene, rate=1.0).refused
    assert refused.reason.startswith("the robot 'arm' of the scene that was given is another")
    assert 'arm::hand/' in refused.reason
    assert 'arm::lower/' not in refused.reason


CELL_OF_PARTS = """
frames: [{name: hand, source: s, pose: {}}, {name: part, source: s, pose: {position: [0, 1, 0]}}]
geometries:
- {name: hand, source: s, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: part, source: s, frame: part, shape: {type: sphere, radius: 0.1}}
- {name: post, source: s, shape: {type: sphere, radius: 0.1}, pose: {position: [9, 0, 0]}}
"""


def shown(file, **of_part):
    """Return the ``~/scene`` of a node, with other fields of the frame of the part."""
    message = recorder.scene(file)
    hand, part = (f for f in message.frames if f.name in ('hand', 'part'))
    if of_part:
        part.is_attached, part.parent_id = True, hand.id
        part.attached_pose.orientation.w = 1.0
        part.attached_pose.position.x = of_part.pop('x')
        for name, value in of_part.items():
            setattr(part, name, value)
    return message


def test_an_attachment_of_the_recorded_scene_is_made_and_undone(tmp_path):
    file = tmp_path / 'cell.yaml'
    file.write_text(CELL_OF_PARTS)
    held = {'x': 0.15, 'touch_links': ['s::hand/hand']}
    moves = [
        (t, '/node/frame_poses', recorder.frame_poses(t, ['hand'], [[t, 0, 0, 0, 0, 0, 1]]))
        for t in np.arange(0.0, 5.0).tolist()
    ]
    scenes = [(0.1, shown(file)), (1.5, shown(file, **held)), (3.5, shown(file))]
    messages = [*moves, *((t, TOPIC, message) for t, message in scenes)]
    run = recorder.record(tmp_path / 'run', sorted(messages, key=lambda each: each[0]))
    to_post = clearance(run, file, between=['part:post'])
    # Attached at 1.5 s, 0.15 m before the hand; at 3.5 s it stays where the hand had taken it.
    p_Wparts = np.array([[0, 1], [0, 1], [2.15, 0], [3.15, 0], [3.15, 0]])
    expected = np.linalg.norm(p_Wparts - [9, 0], axis=1) - 0.2
    np.testing.assert_allclose(to_post['part:post'].distance, expected, rtol=0, atol=1e-12)
    assert to_post.reservations() == []
    between = clearance(run, file, between=['part:hand'])
    # While the part is attached nothing is known of the excluded pair, and that is reported.
    gaps = np.hypot([0, 1, np.nan, np.nan, 0.85], [1, 1, 0, 0, 0]) - 0.2
    np.testing.assert_allclose(between['part:hand'].distance, gaps, rtol=0, atol=1e-12)
    (reservation,) = between.reservations()
    assert 'in 2 of 5 states queries report no pair of the set' in reservation


def test_an_attachment_to_what_the_scene_lacks_is_a_reservation(tmp_path, balls):  # noqa: F811
    file = tmp_path / 'cell.yaml'
    file.write_text(CELL_OF_PARTS)
    message = shown(file, x=0.15)
    for frame in message.frames:
        frame.name = {'hand': 'gripper', 'part': 'a'}.get(frame.name, frame.name)
    messages = [*still(np.arange(0.0, 1.0, 0.1)), (0.95, TOPIC, message)]
    run = recorder.record(tmp_path / 'run', messages)
    told = clearance(run, balls, between=['a:b']).reservations()
    assert f'{TOPIC} shows another parent than the scene that is played here: s::a' in told
