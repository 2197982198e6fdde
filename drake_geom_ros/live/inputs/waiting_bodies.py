"""Messages of tracked bodies that wait for the next poses, whose thread takes them along.

A message that comes by itself finds cold caches: to take it costs eight times as much as right
behind poses, which have just run the same code.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

from drake_geom_ros.live.conversions.arrivals import MessageInfo
from drake_geom_ros.live.scene.held_scene import HeldScene


class WaitingMessage(NamedTuple):
    """The bytes of a message, and what the middleware says of it."""

    raw: bytes
    info: MessageInfo


class WaitingBodies:
    """A queue of messages, oldest first. The scene is never waited for while it is locked."""

    def __init__(
        self,
        take: Callable[[WaitingMessage], object],
        move: Callable[[WaitingMessage, HeldScene], bool],
        call_later: Callable[[], object],
    ) -> None:
        """``take`` takes any message and may last; ``move`` takes one that only moves bodies.

        ``move`` returns False for another message, and does not wait. ``call_later`` has the
        thread of trackers call ``take_all`` soon.
        """
        self._take, self._move, self.call_later = take, move, call_later
        self._messages: deque[WaitingMessage] = deque()
        self._lock = threading.Lock()  # taken before the scene, or not waited for

    def __len__(self) -> int:
        return len(self._messages)

    def add(self, raw: Any, info: MessageInfo) -> None:
        """Let a message wait."""
        self._messages.append(WaitingMessage(raw, info))

    def take_all(self) -> None:
        """Take all messages, in the thread of trackers."""
        with self._lock:
            while self._messages:
                self._take(self._messages.popleft())

    def move_with(self, scene: HeldScene) -> None:
        """Take the messages that only move bodies, in the thread that holds the scene.

        From the first other one on they are left to the thread of trackers.
        """
        if not self._messages or not self._lock.acquire(blocking=False):
            return
        try:
            while self._messages and self._move(self._messages[0], scene):
                self._messages.popleft()
        finally:
            self._lock.release()
        if self._messages:
            self.call_later()
