"""The player in a process of its own: what it publishes, and how it ends."""

import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from drake_geom_msgs.msg import CollisionFilterDeclaration, CollisionFilterStatement, FramePoses
from ros.harness import LATCHED, ROOT, Client, Process
from std_srvs.srv import Trigger

from drake_geom_ros.scene_files import read_scene
from drake_geom_ros.trajectories.motion_file import load_motion

pytestmark = pytest.mark.topics

SCENE = ROOT / 'scenes' / 'two_pandas.yaml'
MOTION = """\
robots:
  left:
    joints: [panda_joint1]
    waypoints:
    - {at: 0.0, q: [0.0]}
    - {at: 2.0, q: [1.5]}
    - {at: 4.0, q: [0.0]}
grasps:
- {frame: objects::can, link: left::panda_hand, gripper: [left::panda_leftfinger],
   start: 0.5, end: 1.0}
"""
# The topics of the player that the first tests share, and of those that a test starts itself.
TOPIC, OWN_TOPIC = '/shared/frame_poses', '/own/frame_poses'


def _start(folder, **parameters):
    (folder / 'motion.yaml').write_text(MOTION)
    defaults = {'scene_file': SCENE, 'trajectory_file': folder / 'motion.yaml', 'topic': TOPIC}
    words = [
        word
        for name, value in {**defaults, **parameters}.items()
        for word in ('-p', f'{name}:={value}')
    ]
    return Process(folder / 'log', ROOT / 'scripts/pose_player', '--ros-args', *words)


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp('player')


@pytest.fixture(scope='module')
def player(folder):
    """Return a player that the first tests share."""
    process = _start(folder)
    yield process
    assert process.end() == 0, process.output()


@pytest.fixture
def start(tmp_path):
    """Return a function that starts players; what still runs after the test is ended."""
    started = []

    def start_one(**parameters):
        started.append(_start(tmp_path, **parameters))
        return started[-1]

    yield start_one
    for process in started:
        process.end()


@pytest.fixture
def client():
    client = Client('/pose_player')
    yield client
    client.close()


@pytest.fixture(scope='module')
def motion(player, folder):
    return load_motion(folder / 'motion.yaml', read_scene(SCENE))


@pytest.fixture(scope='module')
def way(motion):
    """Times of the way out, and where the left hand is at each."""
    times = np.arange(0.0, 2.0, 0.001)
    hand = motion.frame_names['left'].index('panda_hand')
    return times, motion.poses(times)['left'][:, hand, :3]


def _seconds(message):
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec


def _restart(client, messages):
    """Let the motion begin anew; return its first message, and keep none of before."""
    assert client.call(Trigger, 'restart').success
    begun = client.node.get_clock().now().nanoseconds * 1e-9
    # Messages of before the restart may still be on their way.
    client.wait_for(lambda: messages and _seconds(messages[-1]) > begun, 'a pose of the restart')
    messages[:] = [message for message in messages if _seconds(message) > begun]
    return messages[0]


def _phase(message, way):
    """The time of the motion at which the left hand is where a message says it is."""
    index = message.frame_names.index('left::panda_hand')
    times, places = way
    offsets = places - np.reshape(message.poses, (-1, 7))[index, :3]
    return times[np.argmin(np.linalg.norm(offsets, axis=1))]


def test_messages_hold_every_frame_of_one_moment(player, client, motion, way):
    messages = client.listen(FramePoses, TOPIC)
    client.wait_for(lambda: messages, 'a pose')
    first = _restart(client, messages)
    assert first.source == ''
    assert first.header.frame_id == 'world'
    assert len(first.frame_names) == len(set(first.frame_names)) == 36
    client.wait_for(lambda: _seconds(messages[-1]) - _seconds(first) > 1.0, 'a second of poses')
    out = [m for m in messages if _seconds(m) - _seconds(first) < 1.5]  # on the way out
    for message in out[:: len(out) // 5]:
        phase = _phase(message, way)
        expected = motion.poses(phase)
        names = [f'{s}::{n}' for s, frames in motion.frame_names.items() for n in frames]
        assert list(message.frame_names) == names
        flat = np.concatenate([expected[source] for source in motion.frame_names])
        rows = np.array(message.poses).reshape(-1, 7)
        # q and -q are one rotation.
        rows[:, 3:] *= np.where(np.sum(rows[:, 3:] * flat[:, 3:], axis=1) < 0.0, -1.0, 1.0)[
            :, None
        ]
        # Half a step of the phase's grid, 0.5 ms, at less than 2 m/s.
        np.testing.assert_allclose(rows, flat, rtol=0, atol=1.1e-3)


def test_the_motion_goes_with_the_stamps(player, client, way):
    messages = client.listen(FramePoses, TOPIC)
    client.wait_for(lambda: messages, 'a pose')
    first = _restart(client, messages)
    client.wait_for(lambda: _seconds(messages[-1]) - _seconds(first) > 1.5, '1.5 s of poses')
    late = [m for m in messages if 0.5 < _seconds(m) - _seconds(first) < 1.5]
    assert len(late) > 10
    start = _phase(late[0], way) - _seconds(late[0])
    for message in late:
        assert _phase(message, way) - _seconds(message) == pytest.approx(start, abs=5e-3)


def test_a_grasp_is_announced_while_it_holds(player, client):
    messages = client.listen(FramePoses, TOPIC)
    contacts = client.listen(CollisionFilterDeclaration, 'intended_contacts', LATCHED)
    client.wait_for(lambda: messages and contacts, 'poses and contacts')
    _restart(client, messages)
    contacts.clear()
    client.wait_for(lambda: contacts and contacts[-1].statements, 'the grasp')
    statement = contacts[-1].statements[0]
    assert statement.operation == CollisionFilterStatement.EXCLUDE_BETWEEN
    assert list(statement.set_a.frames) == ['objects::can']
    assert 'left::panda_leftfinger' in statement.set_b.frames
    client.wait_for(lambda: not contacts[-1].statements, 'the release')


def test_who_comes_late_is_told_of_the_contacts_too(player, client):
    contacts = client.listen(CollisionFilterDeclaration, 'intended_contacts', LATCHED)
    client.wait_for(lambda: contacts, 'the contacts of now')


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_cleanly(start, client, number):
    player = start(topic=OWN_TOPIC, rate=500.0)
    messages = client.listen(FramePoses, OWN_TOPIC)
    client.wait_for(lambda: messages, 'a pose')
    assert player.end(number) == 0, player.output()
    assert 'Traceback' not in player.output()


def test_it_comes_back_after_it_was_killed(start, client):
    messages = client.listen(FramePoses, OWN_TOPIC)
    player = start(topic=OWN_TOPIC)
    client.wait_for(lambda: messages, 'a pose')
    player.end(signal.SIGKILL)
    killed = time.time()
    player = start(topic=OWN_TOPIC)
    client.wait_for(lambda: _seconds(messages[-1]) > killed, 'a pose of the second player')
    assert player.end() == 0, player.output()


def test_without_loop_it_stays_at_the_end(start, tmp_path, client):
    table = 'time,frame,x,y,z,qx,qy,qz,qw\n'
    rows = '0,scene::ball,0,0,1,0,0,0,1\n0.5,scene::ball,0,0,2,0,0,0,1\n'
    (tmp_path / 'poses.csv').write_text(table + rows)
    files = {'scene_file': ROOT / 'scenes/minimal.yaml', 'trajectory_file': tmp_path / 'poses.csv'}
    player = start(topic=OWN_TOPIC, loop='false', **files)
    messages = client.listen(FramePoses, OWN_TOPIC)
    client.wait_for(lambda: messages and messages[-1].poses[2] == 2.0, 'the end of the motion')
    count = len(messages)
    client.wait_for(lambda: len(messages) > count + 10, 'more poses')
    assert messages[-1].poses.tolist() == [0, 0, 2, 0, 0, 0, 1]
    assert list(messages[-1].frame_names) == ['scene::ball']
    assert player.end() == 0, player.output()


def test_a_player_without_a_scene_says_how_to_give_one(tmp_path):
    player = Process(tmp_path / 'log', ROOT / 'scripts/pose_player')
    assert player.popen.wait(120.0) == 2
    assert 'drake_geom_ros: scene_file is empty' in player.output()
    assert '-p scene_file:=FILE' in player.output()


def test_a_topic_that_cannot_be_is_refused(start):
    player = start(topic='not a topic')
    assert player.popen.wait(120.0) == 2
    assert 'drake_geom_ros: Invalid topic name' in player.output()
    assert 'Traceback' not in player.output()


def test_a_file_that_cannot_be_played_is_refused(start):
    player = start(trajectory_file='/absent.yaml')
    assert player.popen.wait(120.0) == 2
    assert 'drake_geom_ros: /absent.yaml' in player.output()


def test_a_robot_that_is_not_installed_is_found_in_package_roots(tmp_path, start, client):
    (tmp_path / 'ws/stick').mkdir(parents=True)
    (tmp_path / 'ws/stick/stick.urdf').write_text('<robot name="stick"><link name="rod"/></robot>')
    scene = tmp_path / 'stick.yaml'
    scene.write_text('robots: [{name: stick, urdf: package://stick/stick.urdf}]\n')
    without = start(scene_file=scene, trajectory_file="''", topic=OWN_TOPIC)
    assert without.popen.wait(120.0) == 2
    assert "there is no package 'stick'" in without.output()
    start(
        scene_file=scene,
        trajectory_file="''",
        topic=OWN_TOPIC,
        package_roots=f'[{tmp_path / "ws"}]',
    )
    messages = client.listen(FramePoses, OWN_TOPIC)
    client.wait_for(lambda: messages, 'poses of the robot')
    assert list(messages[0].frame_names) == ['stick::rod']


def test_help_says_what_it_takes_and_starts_nothing():
    for asked in (['--help'], ['-h'], ['--ros-args', '--help']):
        done = subprocess.run(
            [sys.executable, '-m', 'drake_geom_ros.ros.pose_player', *asked],
            capture_output=True,
            text=True,
            timeout=800,
            check=False,
        )
        assert done.returncode == 0
        assert done.stderr == ''
        for name in ('scene_file', 'trajectory_file', 'topic', 'rate', 'tf', 'loop'):
            assert f'\n  {name} ' in done.stdout
    page = (ROOT / 'docs/motion_files.md').read_text()
    for line in done.stdout.split('\n'):
        if line.startswith('  '):
            assert f'| `{line.split()[0]}` |' in page
