"""Messages that wait for the pose of their stamp, each topic apart from all others.

The thread that takes messages never sleeps for one: a sensor whose poses come late, or never,
must not delay the others.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from drake_geom_ros.live.scene.moments import PATIENCE, UnknownYetError


class _Waiting(NamedTuple):
    """A message that waits."""

    attempt: Callable[[], object]
    refuse: Callable[[Exception], object]
    came: float  # [s]


class LateMessages:
    """Takes the messages of several topics in the order of each."""

    def __init__(
        self, patience: float = PATIENCE, now: Callable[[], float] = time.monotonic
    ) -> None:
        """Let a message wait for ``patience`` [s] of the steady clock ``now()``."""
        self._patience, self._now = patience, now
        self._queues: dict[str, deque[_Waiting]] = {}

    def __len__(self) -> int:
        """Return how many topics wait."""
        return len(self._queues)

    def take(
        self,
        topic: str,
        attempt: Callable[[], object],
        refuse: Callable[[Exception], object],
        depth: int = 1,
    ) -> int:
        """Take a message by ``attempt()``, now or, where that raises UnknownYetError, later.

        Behind a message that waits, the newest ``depth`` of its topic are kept; return how many
        others were dropped for this one. Another exception, or the last UnknownYetError, goes to
        ``refuse``; one of the connection is raised.
        """
        dropped = 0
        waiting = _Waiting(attempt, refuse, self._now())
        queue = self._queues.get(topic)
        if queue is not None:
            while len(queue) > depth:  # the first one waits, the others are behind it
                del queue[1]
                dropped += 1
            queue.append(waiting)
        elif not self._is_done(waiting):
            self._queues[topic] = deque([waiting])
        return dropped

    def retry(self) -> None:
        """Take what waits, as far as it is possible by now."""
        for topic, queue in list(self._queues.items()):
            while queue and self._is_done(queue[0]):
                queue.popleft()
            if not queue:
                del self._queues[topic]

    def forget(self, topic: str) -> None:
        """Drop what waits of a topic."""
        self._queues.pop(topic, None)

    def _is_done(self, waiting: _Waiting) -> bool:
        try:
            waiting.attempt()
        except UnknownYetError as unknown:
            if self._now() - waiting.came < self._patience:
                return False
            waiting.refuse(unknown)
        except (EOFError, ConnectionError):
            raise
        except Exception as error:
            waiting.refuse(error)
        return True
