"""Service calls that cannot be answered: refused with a reason, and the scene is as it was."""

import os
from pathlib import Path

import pytest
from drake_geom_msgs import msg, srv
from oracles.small_scene import TETRAHEDRON
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from ros.scene_calls import accepted, add_pair, poses, refused

from bench.ros.hostile import LONG_NAME, requests

pytestmark = pytest.mark.topics

SOURCE = 'meshes'


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


def test_a_scene_can_be_saved_whatever_its_properties_are(client):
    add_pair(client, 'saved')
    values = (
        ParameterValue(type=3, double_value=1.7e308),
        ParameterValue(type=4, string_value='a\0b\n- {'),
        ParameterValue(type=5, byte_array_value=[b'\x00', b'\xff']),
        ParameterValue(type=7, integer_array_value=[-(2**63), 2**63 - 1]),
        ParameterValue(type=8, double_array_value=[]),
        ParameterValue(type=9, string_array_value=['', '~', '1e3']),
    )
    named = zip(('', 'a.b', '#', '- x', '\n', ': {'), values, strict=True)
    role = msg.Role(role=2, properties=[msg.Property(name=n, value=v) for n, v in named])
    request = {'geometry': 'saved::a/ball', 'role': role}
    accepted(client.call(srv.AssignRole, 'assign_role', **request))
    text = accepted(client.call(srv.SaveScene, 'save_scene')).text
    accepted(client.call(srv.LoadScene, 'load_scene', text=text, replace=True))
    assert accepted(client.call(srv.SaveScene, 'save_scene')).text == text


@pytest.fixture(scope='module')
def meshes(shared_node, tmp_path_factory):
    """Return a folder of meshes that the node may open."""
    folder = tmp_path_factory.mktemp('meshes')
    shared_node.set(mesh_roots=[str(folder)])
    return folder


def register(client, uri):
    client.call(srv.RegisterSource, 'register_source', name=SOURCE)  # unless it is there
    shape = msg.Shape(type=msg.Shape.CONVEX, dimensions=[1.0], mesh_uri=str(uri))
    return client.call(
        srv.RegisterGeometry,
        'register_geometry',
        source=SOURCE,
        frame='world',
        name=str(uri),
        shape=shape,
        roles=[msg.Role(role=1)],
    )


def test_meshes_that_cannot_be_used(meshes, client):
    (meshes.parent / 'outside.obj').write_text(TETRAHEDRON)
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
        assert name in refused(register(client, meshes / name), word)
    refused(register(client, 'http://example.com/mesh.obj'), 'scheme')
    (meshes / 'good.obj').write_text(TETRAHEDRON)
    accepted(register(client, meshes / 'good.obj'))


@pytest.mark.skipif(os.geteuid() == 0, reason='root may read everything')
def test_a_mesh_that_may_not_be_read(meshes, client):
    (meshes / 'secret.obj').write_text(TETRAHEDRON)
    (meshes / 'secret.obj').chmod(0)
    refused(register(client, meshes / 'secret.obj'), 'secret.obj')


def test_a_mesh_that_cannot_be_read(meshes, client):
    """Not even by root: the first page of a process is not mapped, so reading it fails."""
    roots = Parameter('mesh_roots', value=[str(meshes), f'/proc/{os.getpid()}'])
    request = {'parameters': [roots.to_parameter_msg()]}
    (result,) = client.call(SetParameters, 'set_parameters', **request).results
    assert result.successful, result.reason
    (meshes / 'broken.obj').symlink_to(f'/proc/{os.getpid()}/mem')
    refused(register(client, meshes / 'broken.obj'), 'broken.obj', 'cannot be read')


def test_a_name_of_a_megabyte(client, node):
    """It is a name like any other; what is said of it is short."""
    accepted(client.call(srv.RegisterSource, 'register_source', name=LONG_NAME))
    frame = {'source': LONG_NAME, 'name': LONG_NAME}
    accepted(client.call(srv.RegisterFrame, 'register_frame', **frame))
    said = refused(client.call(srv.RegisterFrame, 'register_frame', **frame))
    assert len(said) < 2000
    said = refused(client.call(srv.GetPose, 'get_pose', frame=f'{LONG_NAME}::{LONG_NAME}'))
    assert said.startswith('The pose of ')
    assert len(said) < 2000
    said = refused(client.call(srv.GetPose, 'get_pose', frame='nobody'))
    assert len(said) < 2000
    publisher = client.publisher(msg.FramePoses, 'frame_poses')

    def told():
        publisher.publish(poses(['nobody'], [(0, 0, 0)]))
        return 'a message of frame_poses was refused' in node.output()

    client.wait_for(told, 'the refusal in the log')
    assert max(map(len, node.output().splitlines())) < 2000
