"""Decoding of messages, by the definitions in a recording or by those of ROS."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from drake_geom_ros.recordings.errors import RecordingError
from drake_geom_ros.recordings.raw_messages import RecordedTopic

TF = 'tf2_msgs/msg/TFMessage'
JOINTS = 'sensor_msgs/msg/JointState'
POSES = 'drake_geom_msgs/msg/FramePoses'
TEXT = 'std_msgs/msg/String'
SCENE = 'drake_geom_msgs/msg/Scene'
TRACKED = 'drake_geom_msgs/msg/TrackedObjects'
DISTANCES = 'drake_geom_msgs/msg/SignedDistancePairs'
OVERLAPS = 'drake_geom_msgs/msg/PenetrationPairs'
EVENTS = 'drake_geom_msgs/msg/ProximityEvents'
CLOCK = 'rosgraph_msgs/msg/Clock'
CLOUD = 'sensor_msgs/msg/PointCloud2'
IMAGE = 'sensor_msgs/msg/Image'
SCAN = 'sensor_msgs/msg/LaserScan'
OCTOMAP = 'octomap_msgs/msg/Octomap'
GRID = 'nav_msgs/msg/OccupancyGrid'
RANGE = 'sensor_msgs/msg/Range'

_ENCODINGS = 'ros2msg', 'ros2idl', 'omgidl', 'unknown', ''  # the last two use ROS's definitions
_BETWEEN = f'{"=" * 80}\n'  # separator of definitions in one text

# A copy of msg_defs, which wheels lack; recordings before ROS 2 Iron have no definitions.
FRAME_POSES = """
std_msgs/Header header
string source
string[] frame_names
uint64[] frame_ids
float64[] poses
"""


@lru_cache(maxsize=64)
def store_of(topic: RecordedTopic) -> Any:
    """Return a rosbags type store with the type of a topic."""
    from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

    if topic.encoding not in _ENCODINGS:
        raise RecordingError(
            f'its definition is of the encoding {topic.encoding!r}, and those of ROS 2 are '
            f'{", ".join(_ENCODINGS[:2])}'
        )
    if topic.encoding == 'ros2msg' and topic.definition:
        store = get_typestore(Stores.EMPTY)
        store.register(get_types_from_msg(topic.definition, topic.type))
        return store
    if topic.encoding in ('ros2idl', 'omgidl') and topic.definition:
        store = get_typestore(Stores.EMPTY)
        for text in topic.definition.split(_BETWEEN):
            # If there are several, each follows a line with its name.
            named = text.startswith('IDL: ')
            store.register(get_types_from_idl(text.partition('\n')[2] if named else text))
        return store
    store = get_typestore(Stores.LATEST)
    store.register(get_types_from_msg(FRAME_POSES, POSES))
    return store


def message_of(topic: RecordedTopic, data: bytes) -> Any:
    """Return the message of some bytes; invalid bytes raise any kind of exception."""
    return store_of(topic).deserialize_cdr(data, topic.type)
