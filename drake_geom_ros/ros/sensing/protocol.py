"""Messages between a node and its process of sensors over a pipe.

The process receives its ``Task``. For each message it sends a ``Begin``, which is answered by a
``Place`` or a ``RefusalReason``, and a ``Finish``, which is answered by None or a
``RefusalReason``. It reports its own refusals by ``RefusedMessage``, and messages that it never
had by ``MissedMessages``, which are not answered. Now
and then it sends ``ALIVE``: the answer is the topics to listen to from now on, or None where these
are as before. While it may compile it sends ``COMPILING``, which is not answered.
"""

from __future__ import annotations

from typing import NamedTuple

from drake_geom_ros.live.conversions.serialized_cloud import Header
from drake_geom_ros.live.inputs.obstacle_records import Found

SENSORS = '_sensors'  # what its name has behind that of the node
ALIVE, COMPILING = 'alive', 'compiling'
# Kinds of messages.
CLOUD, IMAGE, CAMERA, SCAN, CONE = 'cloud', 'image', 'camera', 'scan', 'cone'


class SensorTopic(NamedTuple):
    """A topic to listen to: its full name, what comes there, and how, by ROS's numbers."""

    input: str  # the map that is made of it
    kind: str
    told_as: str  # in diagnostics
    name: str
    history: int
    depth: int
    reliability: int
    durability: int


class Task(NamedTuple):
    """The work of the process, as a node of ROS of this name."""

    node_name: str
    namespace: str
    enclave: str  # of SROS 2: that of the node
    topics: tuple[SensorTopic, ...]


class Begin(NamedTuple):
    """A message of a map came, and it is asked where its frame was."""

    input: str
    header: Header
    waited: float  # [s] since it came
    known: int  # number of the bodies that the process has: these are not told again
    publisher: str  # by what the middleware calls it
    duration: float  # [s] for which it was measured, from its stamp on


class Finish(NamedTuple):
    """The map of the message that was begun last."""

    input: str
    found: Found


class RefusedMessage(NamedTuple):
    """A message was refused."""

    told_as: str
    reason: str


class MissedMessages(NamedTuple):
    """Messages of a map were lost, or replaced by newer ones before they were taken."""

    input: str
    messages: int


class RefusalReason(NamedTuple):
    """Why a message is not to be taken on."""

    reason: str
    may_pass: bool = False  # the message may be taken later
