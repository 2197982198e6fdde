"""Types of requests have the fields of the services that they stand for, and of these types."""

import importlib
from collections.abc import Sequence
from typing import Any, get_args, get_origin, get_type_hints

import pytest
from drake_geom_msgs import srv
from moveit_msgs.srv import GetStateValidity
from rosidl_parser.definition import AbstractSequence, Array, BasicType, NamespacedType

from drake_geom_ros.live.conversions.message_types import CameraMessage
from drake_geom_ros.live.services.state_validity import check_state_validity
from drake_geom_ros.ros.services.table import SERVICES


def fields_of(protocol):
    """Return the types of a protocol's fields by name, of properties too."""
    fields = get_type_hints(protocol)
    for base in protocol.__mro__:
        for name, member in vars(base).items():
            if isinstance(member, property):
                fields[name] = get_type_hints(member.fget)['return']
    return {name: kind for name, kind in fields.items() if not name.startswith('_')}


def differences(protocol, message, place):
    """Return where a protocol is at odds with a message class, down to the fields of fields."""
    there = dict(zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True))
    for name, kind in fields_of(protocol).items():
        if name not in there:
            yield f'{place}.{name} is no field of {message.__name__}'
        else:
            yield from _differences_of_field(kind, there[name], f'{place}.{name}')


def _differences_of_field(kind, slot, place):
    is_list = get_origin(kind) is Sequence
    if is_list != isinstance(slot, (AbstractSequence, Array)):
        yield f'{place}: {kind} is not {slot}'
        return
    if is_list:
        (kind,), slot = get_args(kind), slot.value_type
    if kind is Any:
        return
    if isinstance(slot, NamespacedType):
        message = getattr(importlib.import_module('.'.join(slot.namespaces)), slot.name)
        yield from differences(kind, message, place)
        return
    name = slot.typename if isinstance(slot, BasicType) else 'string'
    is_float = name in ('float', 'double')
    expected = {'boolean': bool, 'string': str}.get(name, float if is_float else int)
    if kind is not expected:
        yield f'{place}: {kind} is not {name}'


@pytest.mark.parametrize(
    ('service', 'handler'),
    [
        *(pytest.param(each, handler, id=name) for name, each, handler in SERVICES),
        pytest.param(GetStateValidity, check_state_validity, id='check_state_validity'),
    ],
)
def test_a_handler_names_the_type_of_its_request(service, handler):
    request = get_type_hints(handler)['request']
    assert request.__module__.endswith('.request_types')
    assert list(differences(request, service.Request, request.__name__)) == []


def test_a_difference_is_found():
    found = list(differences(CameraMessage, srv.GetPose.Request, 'pose'))
    assert 'pose.width is no field of GetPose_Request' in found
    assert list(_differences_of_field(float, BasicType('uint8'), 'x')) == [
        "x: <class 'float'> is not uint8"
    ]
