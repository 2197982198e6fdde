"""`python -m drake_geom_ros.ros.status` beside a real node."""

import json
import re
import signal

import pytest
from drake_geom_msgs import msg, srv
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros.harness import ROOT, Process, run_python, start_node
from ros.scene_calls import accepted, exclude

pytestmark = pytest.mark.topics

SCENE = """
sources: [arm, table]
frames:
- {name: hand, source: arm, pose: {position: [0, 0, 1]}}
- {name: tray, source: table}
geometries:
- {name: ball, source: arm, frame: hand, shape: {type: sphere, radius: 0.1}}
- {name: box, source: table, frame: tray, shape: {type: box, size: [0.1, 0.1, 0.1]}}
"""
STATUS = ('-m', 'drake_geom_ros.ros.status')


def status(*arguments):
    told = run_python(*STATUS, *arguments)
    return told.returncode, told.stdout, told.stderr


def test_a_running_node_is_told_whole(client):
    accepted(client.call(srv.LoadScene, 'load_scene', text=SCENE, replace=True))
    declaration = exclude('arm::hand/ball', 'table::tray/box')
    accepted(
        client.call(
            srv.ApplyTransientFilter,
            'apply_transient_filter',
            declaration=declaration,
            owner='planner',
            lease=60.0,
        )
    )
    code, out, errors = status('--json', '--timeout', '60')
    assert code == 0, errors
    told = json.loads(out)
    assert told['node'] == '/scene_graph'
    assert {s['name']: (s['frames'], s['geometries']) for s in told['sources']} == {
        'arm': (['hand'], 1),
        'table': (['tray'], 1),
    }
    assert told['waiting_frames'] == ['table::tray']
    assert told['filters']['owners'] == ['planner']
    assert 'planner, lease ends in ' in told['filters']['active']
    topics = {topic['name']: topic for topic in told['topics']}
    assert topics['/scene_graph/frame_poses']['published'] is False
    assert topics['/scene_graph/scene']['published'] is True
    code, out, errors = status('--timeout', '60')
    assert code == 0, errors
    assert 'waiting for a first pose: 1: table::tray' in out
    assert '  arm: 1 frame, 1 geometry: hand' in out


def test_what_its_process_of_sensors_hears_is_told_too(lone_client, tmp_path):
    node = start_node(tmp_path / 'log', name='seeing', obstacles='[points]')
    try:
        lone_client.wait_for(
            lambda: 'seeing_sensors' in lone_client.node.get_node_names(), 'its process of sensors'
        )

        def told():  # it listens after it was named, and a reading does not wait for it
            code, out, errors = status('--node', 'seeing', '--timeout', '60')
            assert code == 0, errors
            return re.search(r'in  /seeing/obstacles/points +0 others  nobody sends', out)

        lone_client.wait_for(told, 'a topic that it hears')
    finally:
        node.end()


def test_without_a_node_it_says_so_and_ends():
    code, out, errors = status('--node', '/nobody', '--timeout', '1')
    assert (code, out) == (1, '')
    assert 'no answer of /nobody in ROS domain' in errors
    assert 'waited 1 s for /nobody/scene' in errors


def test_a_scene_of_a_node_that_the_graph_does_not_know_is_no_status(client):
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    client.node.create_publisher(msg.Scene, '/unknown/scene', latched).publish(msg.Scene())
    code, out, errors = status('--node', '/unknown', '--timeout', '3')
    assert (code, out) == (1, '')
    assert 'waited 3 s for /unknown in the ROS graph' in errors


def test_watching_goes_on_until_it_is_interrupted(client, tmp_path):
    script, log = ROOT / 'scripts/status', tmp_path / 'watch.txt'
    watching = Process(log, script, '--watch', '--json', '--timeout', '60')
    client.wait_for(lambda: watching.output().count('\n{') > 1, 'three readings')
    assert watching.end(signal.SIGINT) == 130, watching.output()
    assert all(json.loads(line) for line in watching.output().splitlines())
