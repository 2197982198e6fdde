"""Answers that are too large are refused in words, and how large they are is what DDS sends."""

import pytest
from drake_geom_msgs import srv
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.serialization import serialize_message
from ros.scene_calls import accepted, refused

from drake_geom_ros.live.conversions import results

pytestmark = pytest.mark.topics

COUNT = 60
PAIRS = COUNT * (COUNT - 1) // 2
HEADERS = 200  # [bytes] of a message beside its rows


@pytest.fixture(scope='module')
def node(shared_node):
    """Return the node with spheres in a heap: each overlaps each."""
    lines = ['sources: [s]', 'frames:']
    lines += [
        f'- {{name: f{k}, source: s, pose: {{position: [0.001, {k}e-3, 0]}}}}'
        for k in range(COUNT)
    ]
    lines += ['geometries:']
    sphere = '{type: sphere, radius: 0.1}'
    lines += [f'- {{name: g, source: s, frame: f{k}, shape: {sphere}}}' for k in range(COUNT)]
    shared_node.load('\n'.join(lines))
    return shared_node.process


def allow(client, megabytes):
    value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=megabytes)
    parameters = [Parameter(name='max_answer_size', value=value)]
    (result,) = client.call(SetParameters, 'set_parameters', parameters=parameters).results
    assert result.successful, result.reason


def size(message):
    return len(serialize_message(message))


def test_what_is_too_large_is_refused_and_says_what_to_do(client):
    asked = srv.ComputeSignedDistancePairwise, 'compute_signed_distance_pairwise'
    allow(client, 0.1)
    answer = client.call(*asked)
    words = f'{PAIRS} rows', '0.2 MB', 'max_answer_size', '0.1 MB', 'max_distance'
    refused(answer, *words)
    assert size(answer.result) < HEADERS
    asked_points = srv.ComputeSignedDistanceToPoint, 'compute_signed_distance_to_point'
    points = {'points': [0.0] * 3 * COUNT}
    refused(client.call(*asked_points, **points), f'{COUNT * COUNT} rows', 'threshold')
    asked_depths = srv.ComputePointPairPenetration, 'compute_point_pair_penetration'
    refused(client.call(*asked_depths), f'{PAIRS} rows', 'filter')
    allow(client, 0.02)
    refused(client.call(srv.FindCollisionCandidates, 'find_collision_candidates'), 'filter')
    allow(client, 64.0)
    assert size(accepted(client.call(*asked)).result) > 1e5
    accepted(client.call(*asked_points, **points))
    accepted(client.call(*asked_depths))


def test_rows_are_as_large_as_said(client):
    for rows, kind, name, fields, expected in (
        (
            *(PAIRS, srv.ComputeSignedDistancePairwise, 'compute_signed_distance_pairwise', {}),
            results.SIGNED_DISTANCE_SIZE,
        ),
        (
            *(PAIRS, srv.ComputePointPairPenetration, 'compute_point_pair_penetration', {}),
            results.PENETRATION_SIZE,
        ),
        (
            *(COUNT**2, srv.ComputeSignedDistanceToPoint, 'compute_signed_distance_to_point'),
            {'points': [0.0] * 3 * COUNT},
            results.POINT_DISTANCE_SIZE,
        ),
    ):
        answer = accepted(client.call(kind, name, **fields))
        assert 0 <= size(answer.result) - rows * expected < HEADERS
    found = accepted(client.call(srv.FindCollisionCandidates, 'find_collision_candidates'))
    assert 0 <= size(found) - PAIRS * results.CANDIDATE_SIZE < HEADERS
