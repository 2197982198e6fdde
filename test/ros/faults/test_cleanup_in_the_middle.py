"""A node that is cleaned up while it loads a scene: the late load is dropped, and told so."""

import os
from pathlib import Path

import pytest
from drake_geom_msgs import srv
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from ros.harness import ROOT, Process
from ros.scene_calls import accepted, refused

pytestmark = pytest.mark.topics

TEXT = 'sources: [late]\nframes: [{name: hand, source: late}]\n'


@pytest.fixture
def node(tmp_path, monkeypatch):
    paths = [str(Path(__file__).parent), os.environ.get('PYTHONPATH', '')]
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(paths))
    scene = ROOT / 'scenes' / 'minimal.yaml'
    arguments = ['--ros-args', '-r', '__ns:=/cleaned', '-p', f'scene_file:={scene}']
    process = Process(tmp_path / 'log', 'slow_node', *arguments)
    yield process
    assert process.end() == 0, process.output()


def change(client, *transitions):
    for number in transitions:
        answer = client.call(ChangeState, 'change_state', transition=Transition(id=number))
        assert answer.success, number


def test_the_load_is_dropped_and_the_caller_told(node, lone_client):
    client = lone_client
    client.server = '/cleaned/scene_graph'
    before = accepted(client.call(srv.SaveScene, 'save_scene')).text
    change(client, Transition.TRANSITION_DEACTIVATE)
    caller = client.node.create_client(srv.LoadScene, f'{client.server}/load_scene')
    client.wait_for(caller.service_is_ready, 'load_scene')
    late = caller.call_async(srv.LoadScene.Request(text=TEXT))
    client.wait_for(lambda: 'warming up' in node.output(), 'that the load was taken')
    change(client, Transition.TRANSITION_CLEANUP)
    client.wait_for(late.done, 'the answer to the load')
    refused(late.result(), 'closed')
    change(client, Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE)
    assert accepted(client.call(srv.SaveScene, 'save_scene')).text == before
    assert 'internal error' not in node.output()
