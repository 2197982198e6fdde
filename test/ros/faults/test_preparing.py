"""While a change of the scene is prepared, which may take long, leases of filters end in time."""

import os
from pathlib import Path

import pytest
from drake_geom_msgs import msg, srv
from ros.harness import ROOT, Process
from ros.scene_calls import accepted

pytestmark = pytest.mark.topics

LEASE = 1.0  # [s]


@pytest.fixture
def node(tmp_path, monkeypatch):
    paths = [str(Path(__file__).parent), os.environ.get('PYTHONPATH', '')]
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join(paths))
    scene = ROOT / 'scenes' / 'minimal.yaml'
    arguments = ['--ros-args', '-r', '__ns:=/preparing', '-p', f'scene_file:={scene}']
    process = Process(tmp_path / 'log', 'preparing_node', *arguments)
    yield process
    assert process.end() == 0, process.output()


def test_a_lease_ends_while_a_removal_is_prepared(node, lone_client):
    client = lone_client
    client.server = '/preparing/scene_graph'
    sets = msg.GeometrySet(frames=['ball']), msg.GeometrySet(geometries=['world/floor'])
    statement = msg.CollisionFilterStatement(operation=2, set_a=sets[0], set_b=sets[1])
    declaration = msg.CollisionFilterDeclaration(statements=[statement])
    kind = srv.ApplyTransientFilter
    accepted(client.call(kind, 'apply_transient_filter', declaration=declaration, lease=LEASE))
    # It is answered only once the lease has ended.
    accepted(client.call(srv.RemoveGeometry, 'remove_geometry', geometry='world/post'))
    client.wait_for(lambda: 'the lease of transient filter' in node.output(), 'the log')
