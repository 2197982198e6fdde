"""A node that writes the bytes of messages to an MCAP file, as ``ros2 bag record`` does."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rosbags.interfaces import Connection
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from drake_geom_ros.ros.message_classes import message_class
from drake_geom_ros.scene_files import share_folders

LOOK_PERIOD = 0.2  # [s] between two looks for publishers
_DEPTH = 1000  # messages that may wait while the disk is busy
_VERSION = 9  # of metadata.yaml, that of Jazzy and Kilted


@dataclass
class _Heard:
    """A topic that is recorded."""

    kind: str
    profile: QoSProfile
    subscription: Subscription[Any] | None
    connection: Connection


class Recorder:
    """Subscribes to topics as soon as they have a publisher, and writes what comes.

    The QoS of a subscription is the strictest that fits all publishers of its topic, so that
    latched messages are recorded, and best-effort publishers are heard.
    """

    def __init__(
        self, node: Node, folder: Path, topics: Iterable[str], warn: Callable[[str], None]
    ) -> None:
        """Record into ``folder``, which must not exist; ``warn(text)`` logs what goes wrong."""
        self._node, self._warn = node, warn
        self.topics = tuple(node.resolve_topic_name(topic) for topic in topics)
        self._definitions = Definitions()
        self._heard: dict[str, _Heard] = {}
        self.refused: set[str] = set()  # topics that cannot be recorded
        self.failure: OSError | None = None  # for which nothing more is written
        self.counts: Counter[str] = Counter()
        self.lost: Counter[str] = Counter()  # messages that the middleware dropped
        self._writer = Writer(folder, version=_VERSION, storage_plugin=StoragePlugin.MCAP)
        self._writer.open()
        self._timer = node.create_timer(LOOK_PERIOD, self.look)
        self.look()

    @property
    def heard(self) -> set[str]:
        """The topics that are subscribed to."""
        return set(self._heard)

    def look(self) -> None:
        """Subscribe to topics that have a publisher now, anew where the QoS no longer fits."""
        for topic in self.topics:
            publishers = self._node.get_publishers_info_by_topic(topic)
            kinds = sorted({each.topic_type for each in publishers})
            if not kinds or topic in self.refused:
                continue
            heard = self._heard.get(topic)
            profile = _fitting([each.qos_profile for each in publishers])
            if heard is None:
                self._open(topic, kinds, profile)
            elif kinds == [heard.kind] and not _fits(heard.profile, profile):
                self._unsubscribe(heard)
                heard.profile = profile
                heard.subscription = self._subscribe(topic, heard)

    @property
    def is_complete(self) -> bool:
        """True if messages were recorded, and as far as is known none that came is missing."""
        return bool(self.counts) and not (self.failure or self.refused or any(self.lost.values()))

    def close(self) -> None:
        """Stop, and write the index and ``metadata.yaml``."""
        self._node.destroy_timer(self._timer)
        for heard in self._heard.values():
            self._unsubscribe(heard)
        try:
            self._writer.close()
        except OSError as error:
            self.failure = self.failure or error

    def _open(self, topic: str, kinds: list[str], profile: QoSProfile) -> None:
        if len(kinds) > 1:
            self._refuse(topic, f'{topic} has publishers of several types: {", ".join(kinds)}')
            return
        (kind,) = kinds
        try:
            message_class(kind)
            types = self._definitions.add(kind)
        except (ImportError, AttributeError, UnknownTypeError) as error:
            self._refuse(topic, f'{topic} is not recorded: {error}')
            return
        connection = self._writer.add_connection(topic, kind, typestore=types)
        heard = _Heard(kind, profile, None, connection)
        heard.subscription = self._subscribe(topic, heard)
        self._heard[topic] = heard

    def _refuse(self, topic: str, reason: str) -> None:
        self.refused.add(topic)
        self._warn(reason)

    def _unsubscribe(self, heard: _Heard) -> None:
        if heard.subscription is not None:
            self._node.destroy_subscription(heard.subscription)

    def _subscribe(self, topic: str, heard: _Heard) -> Subscription[Any]:
        def write(data: bytes) -> None:
            if self.failure is not None:
                return
            try:
                self._writer.write(heard.connection, time.time_ns(), data)
                self.counts[topic] += 1
            except OSError as error:  # the disk is full, or gone
                self.failure = error

        def count_lost(status: Any) -> None:
            self.lost[topic] += status.total_count_change

        return self._node.create_subscription(
            message_class(heard.kind),
            topic,
            write,
            heard.profile,
            raw=True,
            event_callbacks=SubscriptionEventCallbacks(message_lost=count_lost),
        )


def _fitting(offered: list[QoSProfile]) -> QoSProfile:
    """Return the strictest profile that all publishers fit."""
    reliable = all(each.reliability == ReliabilityPolicy.RELIABLE for each in offered)
    latched = all(each.durability == DurabilityPolicy.TRANSIENT_LOCAL for each in offered)
    return QoSProfile(
        depth=_DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def _fits(profile: QoSProfile, other: QoSProfile) -> bool:
    """Return whether a subscription hears all that one with the other profile would."""
    strict = ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL
    return not (
        (profile.reliability == strict[0] != other.reliability)
        or (profile.durability == strict[1] != other.durability)
    )


class UnknownTypeError(RuntimeError):
    """The definition of a message type is not installed."""


class Definitions:
    """Reads definitions when a type is first asked for, with all types that it is made of."""

    def __init__(self) -> None:
        self.types: Typestore = get_typestore(Stores.EMPTY)

    def add(self, kind: str) -> Typestore:
        """Return a type store that has ``kind`` (``package/msg/Type``).

        Raises UnknownTypeError where its package, or its file there, is missing.
        """
        waiting = [kind]
        while waiting:
            name = waiting.pop()
            if name in self.types.fielddefs:
                continue
            for message_type, fields in get_types_from_msg(_text_of(name), name).items():
                self.types.register({message_type: fields})
                waiting += [each for each in _parts(fields[1]) if each not in self.types.fielddefs]
        return self.types


def _text_of(kind: str) -> str:
    package, _, name = kind.split('/')
    folders = share_folders()
    for folder in folders:
        path = folder / package / 'msg' / f'{name}.msg'
        if path.is_file():
            return path.read_text()
    raise UnknownTypeError(
        f'the type {kind} cannot be recorded: its definition is in none of '
        f'{", ".join(map(str, folders))}'
    )


def _parts(fields: object) -> list[str]:
    """Return the names of message types in the fields of a definition."""
    names: list[str] = []
    if isinstance(fields, (list, tuple)):
        for each in fields:
            names += _parts(each)
    elif isinstance(fields, str) and fields.count('/') == 2:
        names.append(fields)
    return names
