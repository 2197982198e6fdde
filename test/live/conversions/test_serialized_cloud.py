"""Clouds by their bytes, as rclpy reads them."""

import array
import struct

import pytest
from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from drake_geom_ros.live.conversions.serialized_cloud import (
    CloudField,
    cloud_of_bytes,
    is_plain,
)

names = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=9)
words, bytes_ = st.integers(0, 2**32 - 1), st.integers(0, 255)
fields = st.builds(PointField, name=names, offset=words, datatype=bytes_, count=words)
clouds = st.builds(
    PointCloud2,
    header=st.builds(
        Header,
        stamp=st.builds(Time, sec=st.integers(-(2**31), 2**31 - 1), nanosec=words),
        frame_id=names,
    ),
    height=words,
    width=words,
    fields=st.lists(fields, max_size=4),
    is_bigendian=st.booleans(),
    point_step=words,
    row_step=words,
    data=st.binary(max_size=40).map(lambda data: array.array('B', data)),
    is_dense=st.booleans(),
)


@given(clouds)
def test_a_cloud_is_what_rclpy_reads(cloud):
    raw = serialize_message(cloud)
    assert is_plain(raw)
    told = cloud_of_bytes(raw)
    assert told.header.stamp == (cloud.header.stamp.sec, cloud.header.stamp.nanosec)
    assert told.header.frame_id == cloud.header.frame_id
    assert told.fields == [CloudField(f.name, f.offset, f.datatype, f.count) for f in cloud.fields]
    for name in ('height', 'width', 'is_bigendian', 'point_step', 'row_step', 'is_dense'):
        assert getattr(told, name) == getattr(cloud, name)
    assert bytes(told.data) == bytes(cloud.data)


@given(clouds, st.data())
def test_what_is_cut_off_is_refused(cloud, data):
    raw = serialize_message(cloud)
    end = len(raw.rstrip(b'\0')) if not cloud.is_dense else len(raw)
    cut = data.draw(st.integers(4, max(4, min(end, len(raw) - 4) - 4)))
    with pytest.raises(ValueError, match='cut off'):
        cloud_of_bytes(raw[:cut])


def test_the_other_byte_order():
    """Laid out by hand: a stamp, 'ab', no field, three bytes of data."""
    body = struct.pack('>iII3sxIII', 7, 8, 3, b'ab\0', 1, 3, 0)
    body += struct.pack('>B3xIII3sB', 1, 1, 3, 3, b'xyz', 1)
    told = cloud_of_bytes(b'\x00\x00\x00\x00' + body)
    assert (told.header.stamp, told.header.frame_id) == ((7, 8), 'ab')
    assert (told.height, told.width, told.fields, told.is_bigendian) == (1, 3, [], True)
    assert (told.point_step, told.row_step, bytes(told.data)) == (1, 3, b'xyz')


def test_other_layouts_are_told():
    raw = serialize_message(PointCloud2())
    assert deserialize_message(raw, PointCloud2) == PointCloud2()
    for other in (b'\x00\x06', b'\x00\x0a', b''):
        assert not is_plain(other + raw[2:] if other else b'')


def test_more_fields_than_are_read_are_refused_before_they_are():
    raw = serialize_message(PointCloud2())
    at = 4 + struct.calcsize('<iIIB3xII')
    with pytest.raises(ValueError, match='4000000000 fields; at most'):
        cloud_of_bytes(raw[:at] + struct.pack('<I', 4_000_000_000) + raw[at + 4 :])
