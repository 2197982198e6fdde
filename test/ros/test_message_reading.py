"""What is read by bytes is what rclpy reads: the same poses, refusals and words by both ways."""

import array
import struct

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from drake_geom_msgs.msg import FramePoses, FrameTwists
from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from hypothesis import given, settings
from hypothesis import strategies as st
from live.live_scenes import Clock, live_scene
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from drake_geom_ros.live.conversions.serialized_poses import PoseReader
from drake_geom_ros.live.conversions.serialized_transforms import TransformReader
from drake_geom_ros.live.conversions.transforms import transforms_of
from drake_geom_ros.live.inputs.joint_input import JointInput
from drake_geom_ros.live.inputs.pose_inputs import PoseInputs
from drake_geom_ros.live.inputs.tf_input import TfInput
from drake_geom_ros.ros.message_reading import MessageReader, pose_reader, time_of

TFMessage = pytest.importorskip('tf2_msgs.msg').TFMessage

SCENE = """
sources: [s]
robots: [{urdf: ARM, name: arm, pose: {}}]
frames:
  - {name: base, source: s}
  - {name: hand, source: s, parent: base}
  - {name: räder, source: s}
"""
URDF = (
    '<robot name="arm"><link name="l0"/><link name="l1"/><joint name="j" type="revolute">'
    '<parent link="l0"/><child link="l1"/><axis xyz="0 0 1"/>'
    '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>'
)
KINDS = (TFMessage, JointState, FramePoses, FrameTwists)

names = st.sampled_from(
    [
        'world',
        'base',
        '/base',
        'hand',
        's/hand',
        'räder',
        'j',
        'arm::j',
        '',
        '/',
        'ß' * 5,
        'x' * 70,
    ]
)
numbers = st.sampled_from(
    [0.0, -0.0, 1.0, 0.5, -2.0, 5e-324, 1e-290, 1e300, np.inf, np.nan, 1.0005, 1.1]
)
stamps = st.builds(
    Time,
    sec=st.sampled_from([0, 100, 99, 50, -1, 2**31 - 1]),
    nanosec=st.sampled_from([0, 5, 2**32 - 1]),
)
headers = st.builds(Header, stamp=stamps, frame_id=names)
quaternions = st.one_of(
    st.just(Quaternion()),
    st.builds(Quaternion, x=numbers, y=numbers, z=numbers, w=numbers),
)
transforms = st.builds(
    TransformStamped,
    header=headers,
    child_frame_id=names,
    transform=st.builds(
        Transform,
        translation=st.builds(Vector3, x=numbers, y=numbers, z=numbers),
        rotation=quaternions,
    ),
)


def doubles(most):
    return st.lists(numbers, max_size=most).map(lambda values: array.array('d', values))


def ids():
    return st.lists(st.integers(0, 2**64 - 1), max_size=3).map(lambda v: array.array('Q', v))


rows = st.tuples(numbers, numbers, numbers, quaternions).map(
    lambda row: [*row[:3], *(getattr(row[3], axis) for axis in 'xyzw')]
)
poses = st.lists(rows, max_size=3).map(lambda many: array.array('d', [n for r in many for n in r]))
lists = st.lists(names, max_size=4)
frames = {'header': headers, 'source': names, 'frame_names': lists, 'frame_ids': ids()}
messages = st.one_of(
    st.builds(TFMessage, transforms=st.lists(transforms, max_size=6)),
    st.builds(
        JointState,
        header=headers,
        name=lists,
        position=doubles(4),
        velocity=doubles(4),
        effort=doubles(2),
    ),
    st.builds(FramePoses, **frames, poses=poses),
    st.builds(FrameTwists, **frames, twists=doubles(18)),
)
WORDS = (0, 1, 2, 5, 2**16, 2**31, 2**32 - 1)
BYTES = (b'\0', b'\1', b'\xff', b'a', b'\xc3', b'\7')
ORDERS = (b'\0\0', b'\0\1\0\1', b'\0\1\1\0', b'\0\2', b'\0\6', b'\0\x0b')


def spoilt(draw, raw):
    """Return a message with a few bytes changed."""
    raw = bytearray(raw)
    at = draw(st.integers(0, max(0, len(raw) - 8)))
    match draw(st.sampled_from(['byte', 'word', 'number', 'cut', 'more', 'order'])):
        case 'byte':
            raw[at : at + 1] = draw(st.sampled_from(BYTES))
        case 'word':
            raw[at - at % 4 : at - at % 4 + 4] = struct.pack('<I', draw(st.sampled_from(WORDS)))
        case 'number':
            at += 4 - at % 8
            raw[at : at + 8] = struct.pack('<d', draw(numbers))
        case 'cut':
            del raw[at:]
        case 'more':
            raw += draw(st.binary(max_size=9))
        case 'order':
            order = draw(st.sampled_from(ORDERS))
            raw[: len(order)] = order
    return bytes(raw)


@st.composite
def streams(draw):
    """Return messages of one type, as bytes: some repeat others with a few bytes changed."""
    message = draw(messages)
    kind, raws = type(message), [serialize_message(message)]
    for _ in range(draw(st.integers(0, 4))):
        raw = draw(st.sampled_from(raws))
        for _ in range(draw(st.integers(0, 3))):
            raw = spoilt(draw, raw)
        raws.append(raw)
    return kind, raws


class Listening:
    """A scene and how it is told of messages: what comes of them is kept, in words."""

    def __init__(self, scene, read):
        self._read = read
        self.clock = Clock(100.0)
        self.live = live_scene(scene, self.clock)
        self.tf = TfInput(self.live.clocks)
        joints = JointInput(self.live.clocks, 1.0, by_default=True)
        self.inputs = PoseInputs(self.tf, joints)

    def take(self, raw, kind):
        with self.live.editing() as scene:
            try:
                outcome = self._take(scene, self._read(raw), kind)
            except RuntimeError as error:
                outcome = f'{type(error).__name__}: {error}'
            query, labels = scene.query, scene.model.names.labels
            at = [query.X_WF(f).GetAsMatrix4().tobytes() for f in labels if query.is_placed(f)]
            since = [scene.poses.since(f) for f in labels]
            stamp = scene.poses.ages.newest_stamp
            return outcome, at, since, stamp, self.inputs.troubles(scene, 1.0)

    def _take(self, scene, message, kind):
        if kind is TFMessage:
            refusal = self.tf.take(message, static=False)
            return refusal, self.inputs.pose_by_transforms(scene)
        if kind is JointState:
            return self.inputs.take_joint_states(scene, message)
        if kind is FrameTwists:
            return scene.poses.take_twists(message)
        return self.inputs.take_poses(scene, message)


def ways(kind):
    """Return two ways to read messages: by bytes, and by rclpy alone."""
    convert = transforms_of if kind is TFMessage else None

    class Never:
        def read(self, raw, sender=''):
            return None

    if kind is TFMessage:
        fast = MessageReader(kind, TransformReader(time_of), convert)
    else:
        fast = pose_reader(kind)
    return fast, MessageReader(kind, Never(), convert)


@pytest.fixture(scope='module')
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp('arm') / 'arm.urdf'
    path.write_text(URDF)
    return SCENE.replace('ARM', str(path))


@settings(max_examples=200)
@given(streams())
def test_both_ways_pose_and_refuse_the_same_in_the_same_words(scene, stream):
    kind, raws = stream
    one, other = (
        Listening(scene, lambda raw, reader=reader: reader.read(raw, 'sender'))
        for reader in ways(kind)
    )
    for raw in raws:
        assert one.take(raw, kind) == other.take(raw, kind)
        one.clock.now = other.clock.now = one.clock.now + 0.1


@given(messages)
def test_what_a_plain_message_holds_is_read_without_rclpy(message):
    kind = type(message)
    raw = serialize_message(message)
    deserialized = deserialize_message(raw, kind)
    if kind is TFMessage:
        read = TransformReader(time_of).read(raw)
        if not message.transforms:
            assert read is None
            return
        expected = transforms_of(deserialized)
        assert read.names is expected.names
        for a, b in zip(read[1:4], expected[1:4], strict=True):
            np.testing.assert_array_equal(a, b)
        assert [read.stamp(k) for k in range(len(read.names))] == [
            each.header.stamp for each in message.transforms
        ]
        return
    read = PoseReader(kind.__name__, time_of).read(raw)
    assert (read.header.stamp, read.header.frame_id) == (
        message.header.stamp,
        message.header.frame_id,
    )
    for name in kind.get_fields_and_field_types():
        if name != 'header':
            np.testing.assert_array_equal(getattr(read, name), getattr(deserialized, name))


def test_misread_numbers_are_refused_by_both_ways():
    raw = serialize_message(FramePoses(frame_names=['hand'], poses=[5e-324] * 7))
    for reader in ways(FramePoses):
        with pytest.raises(RuntimeError, match=r'poses\[0\]: .*is refused'):
            reader.read(raw, '')


def test_names_are_looked_up_once_for_each_sender():
    """Two senders by turns, whose messages are as long: the same object for the same names."""
    reader = TransformReader(time_of)
    raws = [
        serialize_message(
            TFMessage(transforms=[TransformStamped(header=Header(frame_id='w'), child_frame_id=c)])
        )
        for c in ('a', 'b')
    ]
    first = [reader.read(raw, sender).names for raw, sender in zip(raws, 'xy', strict=True)]
    assert first[0].pairs == (('w', 'a'),)
    assert [reader.read(raw, s).names for raw, s in zip(raws, 'xy', strict=True)] == first
    assert reader.read(raws[1], 'x').names.pairs == (('w', 'b'),)


@pytest.mark.parametrize('kind', KINDS)
def test_bytes_that_are_no_message_are_named(kind):
    for reader in ways(kind):
        with pytest.raises(RuntimeError, match=rf'^3 bytes are no \w+/{kind.__name__}: '):
            reader.read(b'abc', '')
