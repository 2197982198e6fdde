"""Age of a message on arrival, its publisher, and messages that never arrived."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any, TypeAlias

_MOST_PUBLISHERS = 64  # of a topic that are remembered
_LONGEST_WAITING = 60.0  # [s] no message waits that long to be taken

MessageInfo: TypeAlias = Mapping[str, Any]  # of rclpy, which in Jazzy has no name for it


class Gaps:
    """Counts the messages of one topic that never came here, by the numbers of their publishers.

    They were lost, or newer ones took their places in a short queue. Some middlewares number no
    messages: nothing is counted then.
    """

    def __init__(self) -> None:
        self._last: dict[str, int] = {}  # number of the last message, by publisher

    def before(self, info: MessageInfo) -> int:
        """Return how many messages are missing between one and the last one of its publisher."""
        number = info.get('publication_sequence_number')
        if not isinstance(number, int):
            return 0
        publisher = publisher_of(info)
        last = self._last.pop(publisher, None)
        if len(self._last) >= _MOST_PUBLISHERS:
            del self._last[next(iter(self._last))]
        self._last[publisher] = number
        return 0 if last is None else max(0, number - last - 1)


def publisher_of(info: MessageInfo) -> str:
    """Return the middleware's name for the publisher of a message; empty if it gives none."""
    gid = info.get('publisher_gid') or {}
    return bytes(gid.get('data', b'')).hex()


def waited(info: MessageInfo) -> float:
    """Return how long [s] ago a message came, by the time of day that the middleware notes."""
    came = info['received_timestamp']
    # It may have noted none, and the time of day may have been set meanwhile.
    ago = time.time() - came * 1e-9 if came else 0.0
    return ago if 0.0 <= ago <= _LONGEST_WAITING else 0.0
