"""The profile of Fast DDS: no shared memory, this machine only, and others still meet the node."""

from pathlib import Path

import pytest
from conventions.source_tree import ROOT
from drake_geom_msgs import srv
from ros.harness import start_node, without_shared_memory
from ros.scene_calls import accepted

pytestmark = pytest.mark.topics


def shared_memory(pid):
    """Return what of Fast DDS's shared memory a process has mapped."""
    lines = Path(f'/proc/{pid}/maps').read_text().splitlines()
    return [line for line in lines if '/dev/shm/fast' in line]


@pytest.fixture
def node(tmp_path, monkeypatch):
    without_shared_memory(monkeypatch)
    process = start_node(tmp_path / 'log', anew=True, scene_file=ROOT / 'scenes/minimal.yaml')
    # The client of the test is as other processes are.
    monkeypatch.undo()
    yield process
    assert process.end() == 0, process.output()


def test_a_node_with_the_profile_has_no_shared_memory_and_is_met(node, lone_client):
    accepted(lone_client.call(srv.HasCollisions, 'has_collisions'))
    accepted(lone_client.call(srv.SaveScene, 'save_scene'))
    assert shared_memory(node.popen.pid) == []
    assert 'XMLPARSER' not in node.output()
