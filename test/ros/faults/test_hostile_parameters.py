"""Requests to the services that every node has: none of them ends it, and all are answered."""

import math

import pytest
from drake_geom_msgs import msg, srv
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from ros.scene_calls import accepted, add_pair, poses

pytestmark = pytest.mark.topics

NO_TYPE = 200
BAD = Parameter(name='rate', value=ParameterValue(type=NO_TYPE))


def number(name, value):
    kind = ParameterType.PARAMETER_DOUBLE
    return Parameter(name=name, value=ParameterValue(type=kind, double_value=value))


def put(client, *parameters):
    return client.call(SetParameters, 'set_parameters', parameters=parameters).results


def test_a_parameter_of_no_type_is_refused_by_itself(client):
    good = number('max_distance', 0.75)
    results = put(client, good, BAD, number('max_distance', 0.5))
    assert [result.successful for result in results] == [True, False, True]
    assert str(NO_TYPE) in results[1].reason
    together = client.call(
        SetParametersAtomically, 'set_parameters_atomically', parameters=[good, BAD]
    )
    assert not together.result.successful
    assert str(NO_TYPE) in together.result.reason
    value = client.call(GetParameters, 'get_parameters', names=['max_distance']).values[0]
    assert value.double_value == 0.5
    accepted(client.call(srv.HasCollisions, 'has_collisions'))


@pytest.mark.parametrize(
    ('kind', 'name', 'fields'),
    [
        (SetParameters, 'set_parameters', {'parameters': [Parameter()]}),
        (SetParametersAtomically, 'set_parameters_atomically', {'parameters': [BAD] * 3}),
        (GetParameters, 'get_parameters', {'names': ['', 'rate\0', 'nobody']}),
        (DescribeParameters, 'describe_parameters', {'names': ['', 'nobody']}),
        (ListParameters, 'list_parameters', {'prefixes': ['', '.'], 'depth': 2**64 - 1}),
        (ChangeState, 'change_state', {'transition': Transition(id=NO_TYPE)}),
        (ChangeState, 'change_state', {'transition': Transition(label='nothing')}),
    ],
)
def test_whatever_a_request_holds_it_is_answered(client, kind, name, fields):
    client.call(kind, name, **fields)
    accepted(client.call(srv.HasCollisions, 'has_collisions'))


@pytest.mark.parametrize('value', [1e-12, 5e-324])
def test_a_rate_that_no_timer_can_have_is_refused(client, value):
    (result,) = put(client, number('rate', value))
    assert not result.successful
    assert 'lie in' in result.reason
    (kept,) = client.call(GetParameters, 'get_parameters', names=['rate']).values
    assert kept.double_value == 0.0
    accepted(client.call(srv.HasCollisions, 'has_collisions'))


def test_parameters_at_their_ends(client, node):
    """What is accepted can be: cycles go on and are answered."""
    add_pair(client, 'ends')
    results = client.listen(msg.SignedDistancePairs, 'signed_distances')
    publisher = client.publisher(msg.FramePoses, 'frame_poses')
    message = poses(['a', 'b'], [(0, 0, 0), (0.1, 0, 0)], 'ends')

    def answered():
        publisher.publish(message)
        return results

    for name, default, ends in (
        ('rate', 0.0, (1e-3, 1e4)),
        ('max_distance', 0.5, (0.0, 5e-324, 1.7e308, math.inf)),
        ('time_budget', 0.0, (5e-324, 1.7e308, math.inf)),
        ('stale_after', 1.0, (0.0, 5e-324, math.inf)),
        ('point_threshold', 0.1, (0.0, 5e-324, math.inf)),
    ):
        for end in ends:
            assert put(client, number(name, end))[0].successful, (name, end)
            results.clear()
            if (name, end) != ('rate', 1e-3):
                client.wait_for(answered, f'results with {name} {end}')
        assert put(client, number(name, default))[0].successful
    assert 'internal error' not in node.output()
