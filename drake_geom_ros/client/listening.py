"""Subscriptions to a scene_graph node's results, matched with the scene tables they refer to."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any, TypeVar

from drake_geom_msgs import msg
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from drake_geom_ros.client.contact_surfaces import ContactSurfaces
from drake_geom_ros.client.results import (
    Penetrations,
    PointDistances,
    Results,
    SignedDistances,
)
from drake_geom_ros.client.scene_table import SceneTable

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Reading a large scene takes a while, and more versions may arrive meanwhile.
_SCENES = QoSProfile(depth=32, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_STREAM = QoSProfile(depth=10)
_MOST_TABLES = 32  # a result may refer to any of the last so many sets of names
_MOST_WAITING = 200  # results of a topic that wait for their table
_WARN_PERIOD = 5.0  # [s] between two warnings that results were dropped
_Results = TypeVar('_Results', bound=Results[Any])
_Take = Callable[[Any, SceneTable], None]


class SceneListener:
    """Subscriber to a node's scene and results; each result gets the names it was made with.

    A result is matched with the table of its ``names_version``. That table may be of another
    ``scene_version``, since names do not change where only shapes change. A result that arrives
    before its table waits for it. A result whose table was skipped is dropped, counted in
    ``dropped`` and reported in the log.
    """

    def __init__(self, node: Node, server: str = '/scene_graph') -> None:
        """Listen with ``node``, which the caller spins, to the node named ``server``."""
        self._node = node
        self._server = server
        self.table: SceneTable | None = None
        self._tables: dict[int, SceneTable] = {}
        self._arrivals: list[_Arrivals] = []
        self._scene_callbacks: list[Callable[[SceneTable], None]] = []
        node.create_subscription(msg.Scene, f'{server}/scene', self._take_scene, _SCENES)

    @property
    def dropped(self) -> int:
        """Number of results that were dropped because the table with their names never came."""
        return sum(arrivals.dropped for arrivals in self._arrivals)

    def table_of(self, names_version: int) -> SceneTable | None:
        """Return the newest table with the names of a version, or None if none has arrived."""
        return self._tables.get(names_version)

    def on_scene(self, take: Callable[[SceneTable], None]) -> None:
        """Call ``take`` with each version of the scene."""
        self._scene_callbacks.append(take)

    def on_signed_distances(self, take: Callable[[SignedDistances], None]) -> None:
        """Call ``take`` with each result of ``~/signed_distances``."""
        self._listen(msg.SignedDistancePairs, 'signed_distances', SignedDistances, take)

    def on_penetrations(self, take: Callable[[Penetrations], None]) -> None:
        """Call ``take`` with each result of ``~/penetrations``."""
        self._listen(msg.PenetrationPairs, 'penetrations', Penetrations, take)

    def on_point_distances(self, take: Callable[[PointDistances], None]) -> None:
        """Call ``take`` with each result of ``~/point_distances``."""
        self._listen(msg.PointDistances, 'point_distances', PointDistances, take)

    def on_contact_surfaces(self, take: Callable[[ContactSurfaces], None]) -> None:
        """Call ``take`` with each result of ``~/contact_surfaces``."""
        self._listen(msg.ContactSurfaces, 'contact_surfaces', ContactSurfaces, take)

    def _listen(
        self,
        message: Any,
        topic: str,
        results: Callable[[Any, SceneTable], _Results],
        take: Callable[[_Results], None],
    ) -> None:
        arrivals = _Arrivals(lambda received, table: take(results(received, table)))
        self._arrivals.append(arrivals)

        def hear(received: Any) -> None:
            arrivals.hear(received, self._tables)
            self._warn_dropped()

        self._node.create_subscription(message, f'{self._server}/{topic}', hear, _STREAM)

    def _take_scene(self, message: msg.Scene) -> None:
        before, self.table = self.table, SceneTable.from_message(message)
        if before is not None and self.table.version < before.version:
            self._tables.clear()  # the node restarted, and may reuse version numbers
        self._tables.pop(self.table.names_version, None)  # keeps the newest table last
        self._tables[self.table.names_version] = self.table
        if len(self._tables) > _MOST_TABLES:
            del self._tables[next(iter(self._tables))]
        for callback in self._scene_callbacks:
            callback(self.table)
        for arrivals in self._arrivals:
            arrivals.look(self._tables)
        self._warn_dropped()

    def _warn_dropped(self) -> None:
        if dropped := self.dropped:
            self._node.get_logger().warning(
                f'results of {self._server} were dropped ({dropped} or more): the names that they '
                'refer to did not come on its ~/scene',
                throttle_duration_sec=_WARN_PERIOD,
            )


class _Arrivals:
    """Queue of one topic's results that wait for the tables with their names, in order."""

    def __init__(self, take: _Take) -> None:
        self._take = take
        self._waiting: deque[Any] = deque()
        self.dropped = 0

    def hear(self, message: Any, tables: dict[int, SceneTable]) -> None:
        """Deliver a result, or queue it until its table arrives."""
        self._waiting.append(message)
        if len(self._waiting) > _MOST_WAITING:
            self._waiting.popleft()
            self.dropped += 1
        self.look(tables)

    def look(self, tables: dict[int, SceneTable]) -> None:
        """Deliver queued results of these tables, oldest first; drop those of skipped tables."""
        newest = next(reversed(tables), -1)
        while self._waiting:
            message = self._waiting[0]
            table = tables.get(message.names_version)
            if table is None and message.names_version > newest:
                return
            self._waiting.popleft()
            if table is None:
                self.dropped += 1
            else:
                self._take(message, table)
