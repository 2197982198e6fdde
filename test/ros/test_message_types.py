"""The types of messages that come in have fields of the real messages."""

import importlib
import inspect
import re

from every import report

from drake_geom_ros.live.conversions import message_types

TYPES = [
    each
    for each in vars(message_types).values()
    if inspect.isclass(each) and each.__module__ == message_types.__name__
]
MESSAGE = re.compile(r'\b(\w+_\w+|builtin_interfaces)/(\w+)')


def fields_of(package, name):
    """Return the fields of a message of ROS."""
    kind = getattr(importlib.import_module(f'{package}.msg'), name)
    return set(kind.get_fields_and_field_types())


def read_fields(kind):
    """Return the fields that a type has, with those of its bases."""
    every = [each for each in kind.__mro__ if each in TYPES]
    names = {name for each in every for name in inspect.get_annotations(each)}
    properties = {n for each in every for n, v in vars(each).items() if isinstance(v, property)}
    return names | properties


def test_types_have_fields_of_the_messages_that_they_name():
    named = {kind: MESSAGE.findall(kind.__doc__) for kind in TYPES}
    assert [kind.__name__ for kind, messages in named.items() if not messages] == [
        'StampedMessage'
    ]
    assert len(TYPES) > 20
    report(
        f'{kind.__name__}: {package}/{name} has no field {field!r}'
        for kind, messages in named.items()
        for package, name in messages
        for field in read_fields(kind) - fields_of(package, name)
    )


def test_a_field_that_no_message_has_is_seen():
    assert read_fields(message_types.TimeMessage) == {'sec', 'nanosec'}
    assert read_fields(message_types.CloudMessage) >= {'header', 'width'}
    assert fields_of('builtin_interfaces', 'Time') == {'sec', 'nanosec'}
