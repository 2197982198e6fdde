"""Notices that a node does nothing any more, says where it is stuck, and may end the process.

Two keep the watch. A thread of Python sees that nobody has fed the watchdog for the limit, and
writes the traces of all threads to the standard error. A thread of faulthandler in C sees that not
even this thread runs, for another one waits in C and keeps the interpreter's lock. It alone would
not do: it reads the frames of the others without the lock, and where they run meanwhile, the
process may end by that (three busy threads, traces every 5 ms, CPython 3.11: within 20 s).
"""

from __future__ import annotations

import faulthandler
import os
import sys
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta

_LOOKS = 10  # in the time of the limit


class Watchdog:
    """Barks when it was not fed for ``limit`` [s] (0: never), and then ends the process if asked.

    The exit code of a process that it ends is 1.
    """

    def __init__(self, limit: float, *, exits: bool) -> None:
        self.limit = limit
        self._exits = exits
        self._paused = False
        self._fed = 0.0  # [s] of the steady clock
        self._thread: threading.Thread | None = None
        self._stopped = threading.Event()

    def feed(self) -> None:
        """Say that the node lives."""
        self._fed = time.monotonic()
        if self.limit and not self._paused and self._thread is None:
            self._stopped.clear()
            self._arm()
            self._thread = threading.Thread(target=self._watch, name='watchdog', daemon=True)
            self._thread.start()

    def stop(self) -> None:
        """Watch no more."""
        self._stopped.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        faulthandler.cancel_dump_traceback_later()

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

    def _watch(self) -> None:
        """Look at when the node was fed, while this thread runs, and have that watched in C."""
        while not self._stopped.wait(self.limit / _LOOKS):
            self._arm()
            if time.monotonic() - self._fed >= self.limit:
                self._bark()
                self._fed = time.monotonic()

    def _arm(self) -> None:
        """Have the traces written, and the process ended, where this is not called in time."""
        repeat = not self._exits
        faulthandler.dump_traceback_later(self.limit, repeat=repeat, exit=self._exits)

    def _bark(self) -> None:
        """Write the traces of all threads, with the interpreter's lock, and end the process."""
        names = {thread.ident: thread.name for thread in threading.enumerate()}
        said = [f'Timeout ({timedelta(seconds=self.limit)})!\n']
        for number, frame in sys._current_frames().items():
            said += [f'Thread {names.get(number, number)}:\n', *traceback.format_stack(frame)]
        sys.stderr.write(''.join(said))
        sys.stderr.flush()
        if self._exits:
            os._exit(1)  # what is stuck would keep an orderly end waiting
