"""Results are sent as bytes that rclpy reads as the message that it would have sent."""

import hypothesis.strategies as some
import numpy as np
import pytest
from drake_geom_msgs import msg
from hypothesis import given
from rclpy.serialization import deserialize_message
from std_msgs.msg import ColorRGBA

from drake_geom_ros.live.conversions.fields import fill_arrays
from drake_geom_ros.ros.outputs.result_publisher import ResultPublisher, writer_of

KINDS = msg.PenetrationPairs, msg.SignedDistancePairs, msg.CycleReport
NUMBERS = some.floats(allow_nan=False)
SCALARS = {
    'uint32': some.integers(0, 2**32 - 1),
    'uint64': some.integers(0, 2**64 - 1),
    'double': NUMBERS,
    'string': some.text(some.characters(exclude_characters='\0', exclude_categories=['Cs'])),
}
ELEMENTS = {**SCALARS, 'boolean': some.booleans(), 'uint8': some.integers(0, 255)}
DTYPES = {'boolean': bool, 'uint8': np.uint8, 'uint64': np.uint64, 'double': float}


class Topic:
    """A publisher of rclpy, which keeps what it is given."""

    def __init__(self, kind):
        self.msg_type, self.published = kind, []

    def publish(self, message):
        self.published.append(message)

    def get_subscription_count(self):
        return 3


@pytest.mark.parametrize('kind', KINDS)
@given(data=some.data())
def test_bytes_are_read_as_the_same_message(kind, data):
    """Whatever is filled in, and however long the fields before another one are."""
    topic, expected = Topic(kind), kind()
    publisher = ResultPublisher(topic)
    record = publisher.make_message()
    assert not isinstance(record, kind)
    for name, text in kind.get_fields_and_field_types().items():
        element = text.removeprefix('sequence<').removesuffix('>')
        if name == 'header':
            expected.header.frame_id = record.header.frame_id = data.draw(SCALARS['string'])
            expected.header.stamp.sec, expected.header.stamp.nanosec = -3, 999_999_999
            record.header.stamp = expected.header.stamp
            continue
        is_many = element != text
        strategy = some.lists(ELEMENTS[element], max_size=9) if is_many else SCALARS[text]
        value = data.draw(strategy)
        for message in (record, expected):
            if is_many and element in DTYPES:
                fill_arrays(message, {name: np.array(value, DTYPES[element])})
            else:
                setattr(message, name, value)
    publisher.publish(record)
    (raw,) = topic.published
    assert isinstance(raw, bytes)
    assert deserialize_message(raw, kind) == expected


@pytest.mark.parametrize('kind', KINDS)
def test_a_new_record_is_an_empty_message(kind):
    topic = Topic(kind)
    publisher = ResultPublisher(topic)
    publisher.publish(publisher.make_message())
    assert deserialize_message(topic.published[0], kind) == kind()
    assert publisher.get_subscription_count() == 3


@pytest.mark.parametrize('kind', [ColorRGBA, msg.Scene])
def test_a_type_with_other_fields_goes_as_a_message(kind):
    topic = Topic(kind)
    publisher = ResultPublisher(topic)
    message = publisher.make_message()
    assert isinstance(message, kind)
    publisher.publish(message)
    assert topic.published == [message]


def test_a_middleware_that_reads_something_else_gets_messages(monkeypatch):
    kind = msg.PenetrationPairs
    assert writer_of(kind) is not None
    place = 'drake_geom_ros.live.conversions.serialized_results.LITTLE_ENDIAN'
    monkeypatch.setattr(place, b'\x00\x00\x00\x00')  # big-endian
    assert writer_of(kind) is None
    publisher = ResultPublisher(Topic(kind))
    assert isinstance(publisher.make_message(), kind)
