"""Other nodes that bear this node's full name.

ROS lets them be, and then each service is answered by both, and each parameter is set on either.
They are reported and not refused: a node that is killed stays in the graph of the others until DDS
gives it up after 20 s, and one that a supervisor starts in its place must not stop at its ghost.
"""

from __future__ import annotations

from typing import Any


class Namesakes:
    """Looks for nodes of the name of one, and logs when they come and when they are gone."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self._others = 0

    def trouble(self) -> str:
        """Return what is wrong, and what to do; empty where the name is this node's own."""
        name, logger = self._node.get_fully_qualified_name(), self._node.get_logger()
        namesakes = [each for each in self._names() if each == name]
        others = len(namesakes) - 1  # it sees itself
        text = _in_words(name, others) if others > 0 else ''
        if others != self._others:
            self._others = others
            # rclpy wants a line of code for each severity.
            if text:
                logger.error(text)
            else:
                logger.info(f'this node is the only one called {name} again')
        return text

    def _names(self) -> list[str]:
        pairs = self._node.get_node_names_and_namespaces()
        return [f'{namespace.rstrip("/")}/{name}' for name, namespace in pairs]


def _in_words(name: str, others: int) -> str:
    return (
        f'this node is not the only one called {name}: {others} more in the graph. Any of '
        'them may answer a call, each with its own scene and parameters. Stop all but one, or '
        'give each its own name or namespace (-r __node:=NAME, -r __ns:=/NAMESPACE); a node that '
        'was killed disappears after 20 s'
    )
