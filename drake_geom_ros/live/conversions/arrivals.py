"""Age of a message on arrival, and its publisher."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any, TypeAlias

_LONGEST_WAITING = 60.0  # [s] no message waits that long to be taken

MessageInfo: TypeAlias = Mapping[str, Any]  # of rclpy, which in Jazzy has no name for it


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
