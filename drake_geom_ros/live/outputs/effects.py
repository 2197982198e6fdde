"""Effects of a node with counts, seconds and reasons: the rows of ~/cycle_report."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

NO_SUBSCRIBER = 'no subscriber'


@dataclass
class Effect:
    """One thing that a cycle may do: how much, how long, or why not."""

    name: str
    count: int = 0
    seconds: float = 0.0
    reason: str = ''


class Beside:
    """Work beside the cycles, added up from one report to the next.

    Those who do it are in threads of their own.
    """

    def __init__(self, name: str, why_not: Callable[[], str]) -> None:
        """``why_not()`` returns the reason when nothing was done."""
        self._name = name
        self._why_not = why_not
        self._lock = threading.Lock()
        self._times, self._count, self._seconds = 0, 0, 0.0

    @classmethod
    def publishing(cls, topic: str, why_not: Callable[[], str]) -> Beside:
        """Return the row of a topic of the node."""
        return cls(f'publish ~/{topic}', why_not)

    def did(self, count: int, seconds: float) -> None:
        """Add a message with ``count`` items that took so long [s]."""
        with self._lock:
            self._times += 1
            self._count += count
            self._seconds += seconds

    def take(self) -> Effect:
        """Return what was done since this was last called."""
        with self._lock:
            times, count, seconds = self._times, self._count, self._seconds
            self._times, self._count, self._seconds = 0, 0, 0.0
        return Effect(self._name, count, seconds, '' if times else self._why_not())


def unheard(publisher: Any, otherwise: str) -> str:
    """Return why nothing was published: nobody subscribes, or what else it is."""
    return otherwise if publisher.get_subscription_count() else NO_SUBSCRIBER
