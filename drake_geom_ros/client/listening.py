"""Listens to a scene_graph node's results and gives each the names of its own scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from drake_geom_msgs import msg
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from drake_geom_ros.client.results import (
    Penetrations,
    PointDistances,
    Results,
    SignedDistances,
)
from drake_geom_ros.client.scene_table import SceneTable

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_STREAM = QoSProfile(depth=10)
_Results = TypeVar('_Results', bound=Results[Any])


class SceneListener:
    """Receives the scene of a node, and its results with the names of the right version of it.

    A result may arrive before the version of the scene that it refers to; the newest such result
    waits for it. A result for an earlier version is dropped, because its ids may have changed
    their meaning.
    """

    def __init__(self, node: Node, server: str = '/scene_graph') -> None:
        """Listen with ``node``, which the caller spins, to the node named ``server``."""
        self._node = node
        self._server = server
        self.table: SceneTable | None = None
        self._arrivals: list[_Arrivals] = []
        self._told: list[Callable[[SceneTable], None]] = []
        node.create_subscription(msg.Scene, f'{server}/scene', self._take_scene, LATCHED)

    def on_scene(self, take: Callable[[SceneTable], None]) -> None:
        """Call ``take`` with each version of the scene."""
        self._told.append(take)

    def on_signed_distances(self, take: Callable[[SignedDistances], None]) -> None:
        """Call ``take`` with each result of ``~/signed_distances``."""
        self._listen(msg.SignedDistancePairs, 'signed_distances', SignedDistances, take)

    def on_penetrations(self, take: Callable[[Penetrations], None]) -> None:
        """Call ``take`` with each result of ``~/penetrations``."""
        self._listen(msg.PenetrationPairs, 'penetrations', Penetrations, take)

    def on_point_distances(self, take: Callable[[PointDistances], None]) -> None:
        """Call ``take`` with each result of ``~/point_distances``."""
        self._listen(msg.PointDistances, 'point_distances', PointDistances, take)

    def _listen(
        self,
        message: Any,
        topic: str,
        results: Callable[[Any, SceneTable], _Results],
        take: Callable[[_Results], None],
    ) -> None:
        arrivals = _Arrivals(lambda heard, table: take(results(heard, table)))
        self._arrivals.append(arrivals)

        def hear(heard: Any) -> None:
            arrivals.hear(heard, self.table)

        self._node.create_subscription(message, f'{self._server}/{topic}', hear, _STREAM)

    def _take_scene(self, message: msg.Scene) -> None:
        self.table = SceneTable.from_message(message)
        for told in self._told:
            told(self.table)
        for arrivals in self._arrivals:
            arrivals.look(self.table)


class _Arrivals:
    """Results of one topic, of which the newest waits for its scene."""

    def __init__(self, take: Callable[[Any, SceneTable], None]) -> None:
        self._take = take
        self._waiting: Any = None

    def hear(self, message: Any, table: SceneTable | None) -> None:
        """Hand a result on, or keep it until its scene comes."""
        self._waiting = message
        if table is not None:
            self.look(table)

    def look(self, table: SceneTable) -> None:
        """Hand on what waits for this scene, drop what is of an earlier one."""
        message = self._waiting
        if message is None or message.scene_version > table.version:
            return
        self._waiting = None
        if message.scene_version == table.version:
            self._take(message, table)
