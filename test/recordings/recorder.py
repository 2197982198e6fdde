"""Recordings made by rosbags' own writer."""

from array import array
from functools import cache
from pathlib import Path

import numpy as np
import pytest

# Whoever takes this module is skipped without the extra ``recordings``, and that is told.
pytest.importorskip('rosbags')
pytest.importorskip('mcap')

from rosbags.interfaces import Nodetype
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.live.conversions.scene import fill_scene
from drake_geom_ros.scene_files import load_scene

MSGS = Path(__file__).parents[2] / 'msg_defs' / 'msg'
BEGIN = 1_700_000_000 * 10**9  # [ns]


@cache
def store():
    found = get_typestore(Stores.ROS2_JAZZY)
    for file in sorted(MSGS.glob('*.msg')):
        found.register(get_types_from_msg(file.read_text(), f'drake_geom_msgs/msg/{file.stem}'))
    return found


def _type(name):
    return store().types[name]


def stamp(seconds):
    nanoseconds = BEGIN + round(seconds * 1e9)
    return _type('builtin_interfaces/msg/Time')(*divmod(nanoseconds, 10**9))


def header(seconds, frame=''):
    return _type('std_msgs/msg/Header')(stamp(seconds), frame)


def joint_state(seconds, names, positions):
    none = np.zeros(0)
    return _type('sensor_msgs/msg/JointState')(
        header(seconds), list(names), np.array(positions, dtype=float), none, none
    )


def frame_poses(seconds, names, rows, source='', ids=()):
    return _type('drake_geom_msgs/msg/FramePoses')(
        *(header(seconds), source, list(names), np.array(ids, dtype=np.uint64)),
        np.array(rows, dtype=float).ravel(),
    )


def transforms(seconds, *edges):
    """Return a TFMessage of (parent, child, row of 7)."""
    entries = []
    for parent, child, row in edges:
        p = _type('geometry_msgs/msg/Vector3')(*map(float, row[:3]))
        q = _type('geometry_msgs/msg/Quaternion')(*map(float, row[3:]))
        X = _type('geometry_msgs/msg/Transform')(p, q)
        entries.append(
            _type('geometry_msgs/msg/TransformStamped')(header(seconds, parent), child, X)
        )
    return _type('tf2_msgs/msg/TFMessage')(entries)


def text(data):
    return _type('std_msgs/msg/String')(data)


def empty(kind):
    """Return a message of a type, such as ``drake_geom_msgs/msg/Scene``, with nothing in it."""
    _, fields = store().fielddefs[kind]
    return _type(kind)(*(_nothing(*field) for _, field in fields))


def _nothing(form, what):
    if form == Nodetype.NAME:
        return empty(what)
    if form == Nodetype.SEQUENCE:
        element, inside = what[0]
        is_number = element == Nodetype.BASE and inside[0] != 'string'
        return np.zeros(0, dtype=inside[0]) if is_number else []
    return {'string': '', 'bool': False}.get(what[0], 0)


class _Kinds:
    """Makes messages of our package by their names, as the classes of ROS do."""

    def __getattr__(self, name):
        def make(**values):
            message = empty(f'drake_geom_msgs/msg/{name}')
            _take_floats(message)
            for field, value in values.items():
                setattr(message, field, value)
            return message

        return make


def scene(file):
    """Return the ``~/scene`` of a node that has loaded a scene file."""
    load_scene(file, graph := SceneGraph())
    return scene_of(graph)


def scene_of(graph):
    """Return the ``~/scene`` of a node that holds a scene."""
    message = _Kinds().Scene()
    fill_scene(message, graph.model_inspector(), _Kinds())
    _as_recorded(message)
    return message


def _take_floats(message):
    """Let the floats of a message be filled where they are, as in messages of ROS."""
    for name, value in vars(message).items():
        if isinstance(value, np.ndarray) and value.dtype == np.float64:
            setattr(message, name, array('d', value))
        elif hasattr(value, '__msgtype__'):
            _take_floats(value)


def _as_recorded(message):
    """Replace the arrays of a message, and of those in it, by NumPy's."""
    for name, value in vars(message).items():
        if isinstance(value, array) or name == 'double_array_value':
            setattr(message, name, np.array(value))
        for each in value if isinstance(value, list) else [value]:
            if hasattr(each, '__msgtype__'):
                _as_recorded(each)


def clock(seconds):
    sec, nanosec = divmod(round(seconds * 1e9), 10**9)
    return _type('rosgraph_msgs/msg/Clock')(_type('builtin_interfaces/msg/Time')(sec, nanosec))


def record(folder, messages, *, sqlite=False, compressed='', silent=()):
    """Write (seconds, topic, message) in a folder; return the folder.

    ``compressed`` is how, as rosbag2 has it: 'file', 'message' or, of MCAP, 'storage'. ``silent``
    are (topic, type) of which nobody published a message.
    """
    plugin = StoragePlugin.SQLITE3 if sqlite else StoragePlugin.MCAP
    writer = Writer(folder, version=9, storage_plugin=plugin)
    if compressed:
        mode = CompressionMode[compressed.upper()]
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for topic, kind in silent:
            writer.add_connection(topic, kind, typestore=store())
        for seconds, topic, message in messages:
            kind = message.__msgtype__
            _as_recorded(message)
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store())
            raw = store().serialize_cdr(message, kind)
            writer.write(connections[topic], BEGIN + round(seconds * 1e9), raw)
    return folder


def file_of(folder):
    """Return the only storage file of a recording."""
    (file,) = (each for each in folder.iterdir() if each.suffix in ('.mcap', '.db3'))
    return file
