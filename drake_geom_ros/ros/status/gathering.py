"""Gathers the state of a node: its topics, its scene, its diagnostics and its filters."""

from __future__ import annotations

import math
import time
from collections import Counter
from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from drake_geom_msgs import msg
from rclpy.node import NodeNameNonExistentError
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from drake_geom_ros.client import NoAnswerError, SceneGraphClient
from drake_geom_ros.common.geometry_names import WORLD
from drake_geom_ros.ros.message_classes import message_class
from drake_geom_ros.ros.sensing.protocol import SENSORS

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_ANY = QoSProfile(depth=50, reliability=ReliabilityPolicy.BEST_EFFORT)  # meets every publisher
# Megabytes a message: not listened to.
_LARGE = 'sensor_msgs/msg/Image', 'sensor_msgs/msg/PointCloud2'
_INTERNAL = 'SceneGraphInternal'  # the source of the world frame: nobody's
_WINDOW = 2.2  # [s] in which messages are counted; diagnostics come once a second


@dataclass
class TopicTraffic:
    """A topic of the node, and how many others read or write it."""

    name: str
    type: str
    published: bool  # by the node; else it listens
    others: int
    rate: float | None = None  # [Hz] None: not measured


@dataclass
class Status:
    """The gathered state of a node."""

    node: str
    topics: list[TopicTraffic]
    scene_version: int
    sources: list[dict[str, Any]]
    level: str  # of the diagnostics: ok, warn, error, or 'none' where there are none
    summary: str
    waiting_frames: list[str]
    waiting_pairs: int
    stale_frames: list[str]
    refused: dict[str, int]
    latest_refusal: str
    filters: dict[str, Any]
    values: dict[str, str]  # all of the diagnostics


class Watcher:
    """Reads a node, once or again and again."""

    def __init__(self, client: SceneGraphClient, server: str) -> None:
        """``server`` is the node's full name."""
        self._client, self._server = client, server
        self._counts: Counter[str] = Counter()
        self._counted: dict[str, Any] = {}
        self._latest: dict[str, Any] = {}
        listen = client.node.create_subscription
        listen(msg.Scene, f'{server}/scene', self._keep('scene'), _LATCHED)
        listen(msg.CycleReport, f'{server}/cycle_report', self._keep('cycle'), 10)
        listen(DiagnosticArray, '/diagnostics', self._take_diagnostics, 10)

    def status(self, window: float = _WINDOW) -> Status:
        """Return the node's state within ``window`` [s]; NoAnswerError if it is silent."""
        self._client.wait_for(lambda: 'scene' in self._latest, f'{self._server}/scene')
        # A latched message may come before discovery tells who its node is.
        self._client.wait_for(self._topics, f'{self._server} in the ROS graph')
        before, begun = Counter(self._counts), time.monotonic()
        counted = set(self._counted)
        pause(self._client, window)
        counts, seconds = Counter(self._counts), time.monotonic() - begun
        if not (topics := self._topics()):  # again: discovery may have told some of them only
            raise NoAnswerError(f'{self._server} left the ROS graph within {window:g} s')
        for topic in topics:
            if topic.name in counted:
                topic.rate = (counts[topic.name] - before[topic.name]) / seconds
        return self._told(topics)

    def _keep(self, name: str) -> Any:
        return lambda message: self._latest.__setitem__(name, message)

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == self._server:
                self._latest['diagnostics'] = status

    def _topics(self) -> list[TopicTraffic]:
        """Return the node's topics, none where the ROS graph does not know it.

        Those that others read or write are counted from now on.
        """
        if not (topics := self._topics_of(self._server)):
            return []
        # What it hears of clouds and depth images, a process of its own does.
        topics += self._topics_of(self._server + SENSORS)
        return sorted(topics, key=lambda each: (not each.published, each.name))

    def _topics_of(self, server: str) -> list[TopicTraffic]:
        node, topics = self._client.node, []
        namespace, _, name = server.rpartition('/')
        for published, of_node in (
            (True, node.get_publisher_names_and_types_by_node),
            (False, node.get_subscriber_names_and_types_by_node),
        ):
            try:
                listed = of_node(name, namespace or '/')
            except NodeNameNonExistentError:
                return []
            for topic, (kind, *_) in listed:
                if topic in ('/rosout', '/parameter_events'):
                    continue
                listing = (
                    node.get_subscriptions_info_by_topic
                    if published
                    else node.get_publishers_info_by_topic
                )
                others = [each for each in listing(topic) if each.node_name != node.get_name()]
                topics.append(TopicTraffic(topic, kind, published, len(others)))
                if others and kind not in _LARGE and topic not in self._counted:
                    self._count(topic, kind)
        return topics

    def _count(self, topic: str, kind: str) -> None:
        """Count the messages of a topic, as they are on the wire."""

        def take(message: bytes) -> None:
            self._counts[topic] += 1

        self._counted[topic] = self._client.node.create_subscription(
            message_class(kind), topic, take, _ANY, raw=True
        )

    def _told(self, topics: list[TopicTraffic]) -> Status:
        scene, cycle = self._latest['scene'], self._latest.get('cycle')
        status = self._latest.get('diagnostics')
        values = {each.key: each.value for each in status.values} if status else {}
        filters = self._client.ask('get_filters')
        level = {b'\x00': 'ok', b'\x01': 'warn', b'\x02': 'error', b'\x03': 'stale'}
        return Status(
            node=self._server,
            topics=topics,
            scene_version=scene.scene_version,
            sources=_sources(scene),
            level=level.get(status.level, 'unknown') if status else 'none',
            summary=status.message if status else 'no diagnostics have come: is the node active?',
            waiting_frames=list(cycle.waiting_frames)
            if cycle
            else _names(values, 'names of frames that never had a pose'),
            waiting_pairs=int(values.get('pairs left out because of them', 0)),
            stale_frames=_names(values, 'names of stale frames'),
            refused={
                key.removeprefix('refused: '): int(value)
                for key, value in values.items()
                if key.startswith('refused: ')
            },
            latest_refusal=values.get('latest refusal', 'none'),
            filters={
                'filtered_pairs': filters.filtered_pairs,
                'active': values.get('transient filters', 'none'),
                'ids': list(filters.active_filter_ids),
                'owners': list(filters.active_filter_owners),
            },
            values=values,
        )


def pause(client: SceneGraphClient, seconds: float) -> None:
    """Let time pass [s], unless what ends the client's waits ends this one."""
    over = time.monotonic() + seconds
    client.wait_for(lambda: time.monotonic() >= over, 'the time to pass', math.inf)


def _names(values: dict[str, str], key: str) -> list[str]:
    return [name for name in values.get(key, '').split(', ') if name]


def _sources(scene: msg.Scene) -> list[dict[str, Any]]:
    """Return the sources with their frames and how many geometries each has."""
    geometries = Counter(geometry.source_id for geometry in scene.geometries)
    return [
        {
            'name': source.name,
            'frames': [
                f.name for f in scene.frames if f.source_id == source.id and f.name != WORLD
            ],
            'geometries': geometries[source.id],
        }
        for source in scene.sources
        if source.name != _INTERNAL
    ]
