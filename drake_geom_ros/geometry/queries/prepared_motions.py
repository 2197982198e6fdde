"""What checks of motions prepared, kept for those of the same frames that follow."""

from __future__ import annotations

import threading
from collections.abc import Hashable
from typing import Any

_MOST = 8  # kinds of motions: who moves ever other frames must not fill the memory


class PreparedMotions:
    """A few prepared things by what they are of; who takes one has it alone until it comes back.

    One of each kind is kept, those that were used last. Any number of threads may take.
    """

    def __init__(self) -> None:
        self._kept: dict[Hashable, Any] = {}
        self._lock = threading.Lock()

    def __reduce__(self) -> tuple[type[PreparedMotions], tuple[()]]:
        return PreparedMotions, ()  # a copy begins with nothing

    def take(self, kind: Hashable) -> Any:
        """Return what is kept of a kind, which nobody else gets meanwhile; None: nothing is."""
        with self._lock:
            return self._kept.pop(kind, None)

    def keep(self, kind: Hashable, prepared: Any) -> None:
        """Take something back, or the first of its kind."""
        with self._lock:
            self._kept[kind] = prepared
            if len(self._kept) > _MOST:
                del self._kept[next(iter(self._kept))]
