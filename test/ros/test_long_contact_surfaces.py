"""Surfaces of meshes so fine that they take minutes: the node goes on meanwhile, and ends."""

import numpy as np
import pytest
from drake_geom_msgs import msg, srv
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros.harness import PATIENCE, start_node
from ros.scene_calls import accepted, poses, refused

from drake_geom_ros.client import IncompleteError, SceneGraphClient
from drake_geom_ros.geometry.queries.contact_bodies import NoSurface
from drake_geom_ros.live.outputs.contact_topic import COMPUTED, GOES_ON

pytestmark = pytest.mark.topics

BALL = """
- {{name: g, source: s, frame: {frame}, shape: {{type: sphere, radius: 0.25}},
   roles: {{proximity: {{hydroelastic: {{compliance_type: compliant,
     hydroelastic_modulus: 1e6, resolution_hint: HINT}}}}}}}}"""
SCENE = f"""
sources: [s]
frames:
- {{name: a, source: s, pose: {{position: [0, 0, 0]}}}}
- {{name: b, source: s, pose: {{position: [5, 0, 0]}}}}
geometries:{BALL.format(frame='a')}{BALL.format(frame='b')}
"""
DEEP = [(0.0, 0.0, 0.0), (0.003, 0.002, 0.01)]  # where most of the tetrahedra meet
ASK = 'compute_contact_surfaces'


@pytest.fixture
def client(lone_client):
    """Return a client of the nodes of this file."""
    return lone_client


@pytest.fixture
def fine_node(tmp_path, request):
    """Start a node with two balls of the hint that the test has as a parameter."""
    (tmp_path / 'scene.yaml').write_text(SCENE.replace('HINT', str(request.param)))
    process = start_node(tmp_path / 'log', scene_file=tmp_path / 'scene.yaml')
    yield process
    assert process.end() == 0, process.output()


def cycle_of(client, publisher, heard, places, stamp):
    """Publish poses until a message of a cycle of theirs comes, and return it."""

    def came():
        publisher.publish(poses(['a', 'b'], places, 's', stamp=stamp))
        return [each for each in heard if each.header.stamp.sec == stamp]

    return client.wait_for(came, f'a message of cycle {stamp}')[-1]


@pytest.mark.parametrize('fine_node', [0.007], indirect=True)
def test_cycles_and_services_go_on_and_an_interrupt_ends_the_node(fine_node, client):
    publisher = client.publisher(msg.FramePoses, 'frame_poses', 10)
    surfaces = client.listen(msg.ContactSurfaces, 'contact_surfaces')
    reports = client.listen(msg.CycleReport, 'cycle_report')
    distances = client.listen(msg.SignedDistancePairs, 'signed_distances')
    assert list(cycle_of(client, publisher, surfaces, [DEEP[0], (5, 0, 0)], 1).id_a) == []

    def goes_on():
        publisher.publish(poses(['a', 'b'], DEEP, 's', stamp=2))
        return [
            each
            for each in reports
            if each.header.stamp.sec == 2
            and each.effect_reasons[each.effects.index(COMPUTED)] == GOES_ON
        ]

    client.wait_for(goes_on, 'a report of surfaces that take long')
    # Somebody asks a service for the same, which takes as long.
    asked = client.node.create_client(srv.ComputeContactSurfaces, f'{client.server}/{ASK}')
    client.wait_for(asked.service_is_ready, ASK)
    answer = asked.call_async(srv.ComputeContactSurfaces.Request())
    for stamp in (3, 4):
        assert len(cycle_of(client, publisher, distances, DEEP, stamp).id_a) == 1
        assert client.call(srv.HasCollisions, 'has_collisions').has_collisions
        accepted(client.call(srv.GetPose, 'get_pose', frame='s::b'))
        text = f'sources: [s{stamp}]\nframes: [{{name: f, source: s{stamp}, pose: {{}}}}]'
        accepted(client.call(srv.LoadScene, 'load_scene', text=text))
    assert not answer.done()
    assert {each.header.stamp.sec for each in surfaces} == {1}
    assert fine_node.end() == 0, fine_node.output()


@pytest.mark.parametrize('fine_node', [0.015], indirect=True)
def test_a_time_budget_leaves_pairs_out_and_names_them(fine_node, client):
    value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=0.02)
    entry = Parameter(name='time_budget', value=value)
    assert client.call(SetParameters, 'set_parameters', parameters=[entry]).results[0].successful
    publisher = client.publisher(msg.FramePoses, 'frame_poses', 10)
    surfaces = client.listen(msg.ContactSurfaces, 'contact_surfaces')
    message = cycle_of(client, publisher, surfaces, DEEP, 1)
    assert (message.participants, list(message.id_a)) == (2, [])
    assert list(message.point_pair_reason) == [NoSurface.OUT_OF_TIME]
    assert np.all(np.array(message.point_pair_depth) > 0.4)
    refused(client.call(srv.ComputeContactSurfaces, ASK), 'there was no time to compute one')
    answer = accepted(client.call(srv.ComputeContactSurfaces, ASK, with_fallback=True))
    assert list(answer.result.point_pair_reason) == [NoSurface.OUT_OF_TIME]
    with SceneGraphClient(patience=PATIENCE) as scene:
        found = scene.contact_surfaces(with_fallback=True, allow_incomplete=True)
        assert found.without_surface[0].reason == 'there was no time to compute their surface'
        with pytest.raises(IncompleteError, match='no time to compute the surfaces of 1 pair;'):
            scene.contact_surfaces(with_fallback=True)
