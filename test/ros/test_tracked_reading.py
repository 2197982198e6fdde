"""TrackedObjects by their bytes are what rclpy reads, whatever is in them."""

import numpy as np
import pytest
from drake_geom_msgs import msg
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.serialized_tracked import TrackedObjectsBytes
from drake_geom_ros.ros.message_reading import time_of, tracked_objects_reader

FLOATS = st.floats(allow_nan=False, width=64)


@st.composite
def shapes(draw):
    """Draw a Shape, which need be none that the node takes."""
    return msg.Shape(
        type=draw(st.integers(0, 255)),
        dimensions=draw(st.lists(FLOATS, max_size=3)),
        mesh_uri=draw(st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=5)),
        vertices=draw(st.lists(FLOATS, max_size=4)),
        triangles=draw(st.lists(st.integers(0, 2**32 - 1), max_size=3)),
    )


@st.composite
def messages(draw):
    """Draw a TrackedObjects."""
    count = draw(st.integers(0, 4))
    text = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=9)
    message = msg.TrackedObjects(
        names=draw(st.lists(text, min_size=count, max_size=count)),
        shapes=draw(st.lists(shapes(), min_size=count, max_size=count)),
        poses=draw(st.lists(FLOATS, max_size=8)),
        velocities=draw(st.lists(FLOATS, max_size=3)),
        lifetimes=draw(st.lists(FLOATS, max_size=3)),
    )
    message.header.stamp.sec = draw(st.integers(-(2**31), 2**31 - 1))
    message.header.stamp.nanosec = draw(st.integers(0, 2**32 - 1))
    message.header.frame_id = draw(text)
    return message


def plain(message):
    """Return the values of a message, of either kind."""
    stamp = message.header.stamp
    arrays = (message.poses, message.velocities, message.lifetimes)
    return (
        (stamp.sec, stamp.nanosec, message.header.frame_id),
        list(message.names),
        [
            (s.type, list(s.dimensions), s.mesh_uri, list(s.vertices), list(s.triangles))
            for s in message.shapes
        ],
        [np.asarray(each).tolist() for each in arrays],
    )


@settings(max_examples=200, deadline=None)
@given(st.lists(messages(), min_size=1, max_size=3))
def test_bytes_say_what_rclpy_reads(drawn):
    reader = TrackedObjectsBytes(time_of)
    for message in [*drawn, drawn[-1]]:
        raw = serialize_message(message)
        by_bytes = reader.read(raw, 'a')
        assert by_bytes is not None
        assert plain(by_bytes) == plain(deserialize_message(raw, msg.TrackedObjects))


def people(count=3, x=1.0):
    shape = msg.Shape(type=msg.Shape.SPHERE, dimensions=[0.1])
    return msg.TrackedObjects(
        names=[f'{k}' for k in range(count)],
        shapes=[shape] * count,
        poses=[x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0] * count,
        lifetimes=[1.0] * count,
    )


def test_the_same_bodies_are_the_same_tuple_and_others_are_not():
    reader = TrackedObjectsBytes(time_of)
    first, second = (reader.read(serialize_message(people(x=x)), 'a') for x in (1.0, 2.0))
    assert second.shapes is first.shapes
    assert second.poses[0] == 2.0
    other = people()
    other.shapes[1] = msg.Shape(type=msg.Shape.SPHERE, dimensions=[0.2])
    third = reader.read(serialize_message(other), 'a')
    assert [shape.dimensions[0] for shape in third.shapes] == [0.1, 0.2, 0.1]


def test_cut_off_bytes_are_refused_and_misread_sizes_named():
    reader, raw = tracked_objects_reader(msg.TrackedObjects), serialize_message(people())
    for length in range(0, len(raw) - 24, 7):
        with pytest.raises(ArgumentError):
            reader.read(raw[:length], 'a')
    message = people()
    message.shapes[2] = msg.Shape(type=msg.Shape.SPHERE, dimensions=[5e-320])
    for _ in range(2):
        with pytest.raises(ArgumentError, match=r'sizes\[2\]: 5e-320 is refused'):
            reader.read(serialize_message(message), 'a')
