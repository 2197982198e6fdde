"""Every number of a request is converted to the type of its field, or refused."""

import array

import numpy as np
import pytest

pytest.importorskip('rclpy')
from drake_geom_msgs import msg, srv
from geometry_msgs.msg import Point, Pose
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from drake_geom_ros.client.requests import RequestError, request_of
from drake_geom_ros.client.services import service_type


def asked(service, **fields):
    return request_of(service_type(service).Request, fields, service)


@pytest.mark.parametrize('one', [1, np.float32(1), np.int64(1), np.uint8(1), np.array(1.0), 1.0])
@pytest.mark.parametrize(
    ('service', 'field'),
    [
        ('compute_signed_distance_pairwise', 'max_distance'),
        ('compute_signed_distance_to_point', 'threshold'),
        ('evaluate_states', 'clearance'),
        ('check_motion', 'min_distance'),
        ('check_motion', 'time_tolerance'),
        ('apply_transient_filter', 'lease'),
    ],
)
def test_a_number_of_any_type_arrives_as_a_float(service, field, one):
    value = getattr(asked(service, **{field: one}), field)
    assert (type(value), value) == (float, 1.0)


def test_numbers_of_messages_within_messages_are_converted_and_those_passed_stay():
    rule = msg.ProximityRule(name='r', set_a=['a'], level=np.int64(3), enter=1, leave=np.int32(2))
    request = asked('add_proximity_rule', rule=rule)
    values = request.rule.enter, request.rule.leave, request.rule.level
    assert [type(value) for value in values] == [float, float, int]
    assert values == (1.0, 2.0, 3)
    assert (type(rule.enter), request.rule.name) == (int, 'r')
    pose = Pose(position=Point(x=1))
    assert type(asked('attach', pose=pose).pose.position.x) is float


def test_numbers_in_sequences_of_messages_are_converted():
    role = msg.Role(role=1, properties=[msg.Property(group='g', name='n')])
    role.properties[0].value.double_value = 3
    (sent,) = asked('register_geometry', roles=[role]).roles
    value = sent.properties[0].value.double_value
    assert (type(value), value) == (float, 3.0)


def test_arrays_are_converted_whatever_they_hold():
    request = asked('evaluate_states', positions=np.array([[1, 2]]).ravel())
    assert request.positions == array.array('d', [1.0, 2.0])
    points = np.arange(3, dtype=np.float32)
    assert asked('compute_signed_distance_to_point', points=points).points.tolist() == [0, 1, 2]
    shape = msg.Shape(dimensions=[1, 2, 3])
    assert asked('change_shape', shape=shape).shape.dimensions.tolist() == [1.0, 2.0, 3.0]


def test_messages_that_need_no_conversion_are_sent_as_they_are():
    path = JointTrajectory(points=[JointTrajectoryPoint(positions=[0.0])])
    assert asked('check_motion', path=path).path is path


def test_numpy_truth_values_arrive_as_true():
    assert asked('evaluate_states', stop_at_first=np.bool_(True)).stop_at_first is True


@pytest.mark.parametrize(
    ('service', 'fields', 'reason'),
    [
        ('check_motion', {'min_distance': '1'}, r"min_distance is '1' \(str\); it must be double"),
        ('check_motion', {'min_distance': None}, 'min_distance is None'),
        ('check_motion', {'min_distance': True}, 'min_distance is True'),
        ('check_motion', {'max_evaluations': 1.5}, 'max_evaluations is 1.5'),
        ('check_motion', {'max_evaluations': -1}, 'uint32 goes from 0 to 4294967295'),
        ('check_motion', {'ignore_limits': 1}, 'ignore_limits is 1'),
        ('check_motion', {'min_distanse': 1.0}, "nearest: 'min_distance'"),
        ('check_motion', {'accuracy': 3}, 'accuracy is 3'),
        ('check_motion', {'start': {'a': 1}}, 'start is'),
        ('evaluate_states', {'joint_names': 'j1'}, "joint_names is 'j1'"),
        ('evaluate_states', {'positions': ['a']}, 'positions is'),
        ('evaluate_states', {'positions': [[0.0, 1.0]]}, r'positions has the shape \(1, 2\)'),
        ('remove_filter', {'filter_id': -1}, 'filter_id is -1'),
    ],
)
def test_what_does_not_convert_is_refused_by_the_name_of_the_field(service, fields, reason):
    with pytest.raises(RequestError, match=reason):
        asked(service, **fields)


def test_every_field_of_every_service_goes_through():
    names = [name for name in dir(srv) if not name.startswith('_') and name[0].isupper()]
    for name in names:
        kind = getattr(srv, name, None)
        if not hasattr(kind, 'Request'):
            continue
        default = kind.Request()
        fields = {field: getattr(default, field) for field in default.get_fields_and_field_types()}
        assert request_of(kind.Request, fields, name) == default
