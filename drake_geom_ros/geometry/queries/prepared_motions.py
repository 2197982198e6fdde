"""Cache of prepared motion checks, for later checks of the same frames."""

from __future__ import annotations

import threading
from collections.abc import Hashable
from typing import Any

_MAX_KINDS = 8  # a limit, since callers may move different frames each time


class PreparedMotions:
    """Thread-safe cache with one entry a kind; a caller owns an entry from ``take`` to ``keep``.

    It holds the entries that were used last.
    """

    def __init__(self) -> None:
        self._entries: dict[Hashable, Any] = {}
        self._lock = threading.Lock()

    def __reduce__(self) -> tuple[type[PreparedMotions], tuple[()]]:
        return PreparedMotions, ()  # a copy begins with nothing

    def take(self, kind: Hashable) -> Any:
        """Remove and return the entry of a kind, None if there is none."""
        with self._lock:
            return self._entries.pop(kind, None)

    def keep(self, kind: Hashable, prepared: Any) -> None:
        """Store an entry, and drop the oldest one beyond the limit."""
        with self._lock:
            self._entries[kind] = prepared
            if len(self._entries) > _MAX_KINDS:
                del self._entries[next(iter(self._entries))]
