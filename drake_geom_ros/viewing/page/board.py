"""Content of a page as JSON by section; browsers get the newest of each section that changed."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable
from typing import Any


class Board:
    """The newest text of each section; watchers are notified of changes."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._texts: dict[str, tuple[int, str]] = {}
        self._serial = 0
        self._watchers: list[Callable[[], None]] = []

    def put(self, section: str, value: Any) -> None:
        """Replace a section; an equal value changes nothing. Infinite numbers become null."""
        text = json.dumps({'section': section, 'value': finite(value)}, separators=(',', ':'))
        with self._lock:
            if section in self._texts and self._texts[section][1] == text:
                return
            self._serial += 1
            self._texts[section] = self._serial, text
            watchers = list(self._watchers)
        for watcher in watchers:
            watcher()

    def value(self, section: str) -> Any:
        """Return the value of a section as browsers get it; None before the first one."""
        with self._lock:
            _, text = self._texts.get(section, (0, '{"value":null}'))
        return json.loads(text)['value']

    def newer_than(self, serial: int) -> tuple[int, list[str]]:
        """Return the number of the last change, and the texts that changed after another one."""
        with self._lock:
            newer = sorted(entry for entry in self._texts.values() if entry[0] > serial)
            return self._serial, [text for _, text in newer]

    def watch(self, watcher: Callable[[], None]) -> None:
        """Call ``watcher()`` after each change, in any thread."""
        with self._lock:
            self._watchers.append(watcher)

    def leave(self, watcher: Callable[[], None]) -> None:
        """Do not call ``watcher()`` any more."""
        with self._lock:
            self._watchers.remove(watcher)


def finite(value: Any) -> Any:
    """Return a value with None for numbers that JSON cannot hold."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [finite(each) for each in value]
    return value
