"""Processes die and come back while the others go on."""

import signal
import subprocess
import sys

import pytest
from drake_geom_msgs import msg, srv
from ros.harness import ROOT, Process, environment, start_node
from ros.scene_calls import accepted

pytestmark = pytest.mark.topics

SCENE = ROOT / 'scenes' / 'minimal.yaml'
LISTENER = """
import rclpy
from drake_geom_msgs.msg import SignedDistancePairs
rclpy.init()
node = rclpy.create_node('listener')
node.create_subscription(
    SignedDistancePairs, '/scene_graph/signed_distances', lambda m: print('heard', flush=True), 10
)
rclpy.spin(node)
"""


def start_player(log):
    arguments = ['--ros-args', '-p', f'scene_file:={SCENE}', '-p', 'rate:=50.0']
    return Process(log, ROOT / 'scripts/pose_player', *arguments, anew=True)


@pytest.fixture
def node(tmp_path):
    process = start_node(tmp_path / 'node', anew=True, scene_file=SCENE, max_distance=1.0)
    yield process
    process.end()


@pytest.fixture
def player(tmp_path):
    process = start_player(tmp_path / 'player')
    yield process
    process.end()


def wait_for_more(client, results):
    """Wait for results that are not there yet."""
    seen = len(results)
    client.wait_for(lambda: len(results) > seen + 5, 'more results')


def test_the_player_dies_and_comes_back(tmp_path, node, player, lone_client):
    results = lone_client.listen(msg.SignedDistancePairs, 'signed_distances')
    wait_for_more(lone_client, results)
    assert player.end(signal.SIGKILL) == -signal.SIGKILL
    # Without poses there are no cycles, but services go on and keep the last poses.
    pose = lone_client.call(srv.GetPose, 'get_pose', frame='ball').pose
    assert pose.pose.position.x == 0.5
    again = start_player(tmp_path / 'again')
    try:
        wait_for_more(lone_client, results)
    finally:
        assert again.end() == 0
    assert node.popen.poll() is None, node.output()


def test_a_listener_dies(tmp_path, node, player, lone_client):
    results = lone_client.listen(msg.SignedDistancePairs, 'signed_distances')
    listener = subprocess.Popen(
        [sys.executable, '-c', LISTENER], env=environment(), stdout=subprocess.PIPE, text=True
    )
    assert listener.stdout.readline() == 'heard\n'
    listener.kill()
    listener.wait()
    listener.stdout.close()
    wait_for_more(lone_client, results)
    assert node.popen.poll() is None, node.output()


def test_the_node_dies_and_comes_back(tmp_path, node, player, lone_client):
    results = lone_client.listen(msg.SignedDistancePairs, 'signed_distances')
    wait_for_more(lone_client, results)
    assert node.end(signal.SIGKILL) == -signal.SIGKILL
    again = start_node(tmp_path / 'again', anew=True, scene_file=SCENE, max_distance=1.0)
    try:
        wait_for_more(lone_client, results)
        state = accepted(lone_client.call(srv.GetFilters, 'get_filters'))
        assert not state.has_transient_history
    finally:
        assert again.end() == 0, again.output()
    assert player.popen.poll() is None, player.output()


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_node_cleanly(node, lone_client, number):
    accepted(lone_client.call(srv.HasCollisions, 'has_collisions'))
    assert node.end(number) == 0, node.output()
    assert 'Traceback' not in node.output()


def test_a_scene_file_that_is_none_leaves_the_node_unconfigured(tmp_path, lone_client):
    bad = tmp_path / 'bad.yaml'
    bad.write_text(SCENE.read_text().replace('radius: 0.1', 'radius: -0.1'))
    node = start_node(tmp_path / 'node', scene_file=bad)
    try:
        lone_client.wait_for(lambda: 'bad.yaml:7' in node.output(), 'the refusal in the log')
        assert 'radius' in node.output()
        assert node.popen.poll() is None
    finally:
        assert node.end() == 0
