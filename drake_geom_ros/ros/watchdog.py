"""Notices that a node does nothing any more, says where it is stuck, and may end the process.

The watch is kept by a thread of faulthandler in C: a thread of Python could not run while another
one waits in C and keeps the interpreter's lock. Whoever sees that the node lives feeds the
watchdog; where nobody has done so for the limit, the traces of all threads are written to the
standard error. No ROS import here.
"""

from __future__ import annotations

import faulthandler
import time
from collections.abc import Iterator
from contextlib import contextmanager

_FEEDS = 10  # in the time of the limit: each one starts a thread


class Watchdog:
    """Barks when it was not fed for ``limit`` [s] (0: never), and then ends the process if asked.

    The exit code of a process that it ends is 1.
    """

    def __init__(self, limit: float, *, exits: bool) -> None:
        self.limit = limit
        self._exits = exits
        self._paused = False
        self._next = 0.0  # [s] of the steady clock

    def feed(self) -> None:
        """Say that the node lives."""
        now = time.monotonic()
        if self.limit and not self._paused and now >= self._next:
            self._next = now + self.limit / _FEEDS
            faulthandler.dump_traceback_later(self.limit, repeat=not self._exits, exit=self._exits)

    def stop(self) -> None:
        """Watch no more."""
        faulthandler.cancel_dump_traceback_later()
        self._next = 0.0

    @contextmanager
    def paused(self) -> Iterator[None]:
        """Do not watch what may take as long as it likes, such as the compilation of kernels."""
        self._paused = True
        self.stop()
        try:
            yield
        finally:
            self._paused = False
            self.feed()
