"""Service calls that cannot be answered: refused with a reason, and the scene is as it was."""

import os
from pathlib import Path

import pytest
from drake_geom_msgs import msg, srv
from ros.harness import start_node
from ros.scene_calls import accepted, add_pair, refused

from bench.ros.hostile import requests

OBJ = 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n'


def test_impossible_requests(client):
    add_pair(client, 'victim')
    before = accepted(client.call(srv.SaveScene, 'save_scene')).text
    for service, kind, fields, word in requests('victim', 'a', 'victim::a/ball'):
        answer = client.call(kind, service, **fields)
        assert not answer.success, service
        assert word in answer.message, service
        assert len(answer.message) < 2000, service
    assert accepted(client.call(srv.SaveScene, 'save_scene')).text == before
    assert not Path('/tmp/drake_geom_ros_was_here').exists()


@pytest.fixture
def meshes(tmp_path, lone_client):
    """Return a folder of meshes that a node may open."""
    folder = tmp_path / 'meshes'
    folder.mkdir()
    node = start_node(tmp_path / 'log', namespace='/meshes', mesh_roots=f'["{folder}"]')
    lone_client.server = '/meshes/scene_graph'
    accepted(lone_client.call(srv.RegisterSource, 'register_source', name='s'))
    yield folder
    assert node.end() == 0, node.output()


def register(client, uri):
    shape = msg.Shape(type=msg.Shape.CONVEX, dimensions=[1.0], mesh_uri=str(uri))
    return client.call(
        srv.RegisterGeometry,
        'register_geometry',
        source='s',
        frame='world',
        name='mesh',
        shape=shape,
        roles=[msg.Role(role=1)],
    )


def test_meshes_that_cannot_be_used(meshes, lone_client, tmp_path):
    (tmp_path / 'outside.obj').write_text(OBJ)
    (meshes / 'text.obj').write_text('no mesh\n')
    (meshes / 'folder.obj').mkdir()
    os.mkfifo(meshes / 'pipe.obj')
    with open(meshes / 'huge.obj', 'w') as huge:
        huge.truncate(2**40)  # takes no space on the disk
    for name, word in (
        ('missing.obj', 'no file'),
        ('text.obj', 'faces'),
        ('folder.obj', 'no file'),
        ('pipe.obj', 'no file'),
        ('huge.obj', 'bytes'),
        ('../outside.obj', 'mesh_roots'),
    ):
        assert name in refused(register(lone_client, meshes / name), word)
    refused(register(lone_client, 'http://example.com/mesh.obj'), 'scheme')
    (meshes / 'good.obj').write_text(OBJ)
    accepted(register(lone_client, meshes / 'good.obj'))


@pytest.mark.skipif(os.geteuid() == 0, reason='root may read everything')
def test_a_mesh_that_may_not_be_read(meshes, lone_client):
    (meshes / 'secret.obj').write_text(OBJ)
    (meshes / 'secret.obj').chmod(0)
    refused(register(lone_client, meshes / 'secret.obj'), 'secret.obj')
