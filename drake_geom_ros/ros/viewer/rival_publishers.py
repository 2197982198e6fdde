"""A check that the topics of a node come from one node: two of one name mix their messages."""

from __future__ import annotations

import time
from collections.abc import Sequence

from rclpy.node import Node

_PERIOD = 1.0  # [s] between two checks


class RivalPublishers:
    """Counts the publishers of topics that only one node should publish."""

    def __init__(self, node: Node, topics: Sequence[str]) -> None:
        self._node, self._topics = node, topics
        self._next = 0.0  # [s] of the steady clock
        self._warning = ''

    def warning(self) -> str:
        """Return a warning if a topic has several publishers, else an empty text.

        The topics are checked once a second, and a new warning is logged.
        """
        now = time.monotonic()
        if now < self._next:
            return self._warning
        self._next = now + _PERIOD
        before, self._warning = self._warning, self._check()
        if self._warning and self._warning != before:
            self._node.get_logger().warning(self._warning)
        return self._warning

    def _check(self) -> str:
        for topic in self._topics:
            nodes = [
                f'{each.node_namespace.rstrip("/")}/{each.node_name}'
                for each in self._node.get_publishers_info_by_topic(topic)
            ]
            if len(nodes) > 1:
                return (
                    f'NOT ONE SCENE: {len(nodes)} publishers send {topic} (of the nodes '
                    f'{" and ".join(sorted(nodes))}), and this page mixes their scenes. Start one '
                    'of them with another name (-r __node:=NAME) or ROS_DOMAIN_ID. A node that '
                    'was killed counts for some 20 s.'
                )
        return ''
