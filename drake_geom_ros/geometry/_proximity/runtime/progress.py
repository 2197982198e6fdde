"""Reports of compilation: a progress line on standard error, and a journal file on demand.

A first query takes seconds, and the first query of a URDF may take a minute: silence looks like a
program that hangs. Callers that report by a ``tell`` callback of their own (a log, the command
``compile``) silence the line. On a terminal the line is overwritten and erased at the end;
elsewhere a line is printed every ten seconds.

The environment variable ``DRAKE_GEOM_ROS_COMPILE_LOG`` names a file to which each process appends
a line for each function that it compiles, not for those that it loads: process, cache folder,
function, types of its arguments. The folder is empty for what no cache keeps, such as functions
that are compiled into those that call them.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from numba.core import event

_PACKAGE = 'drake_geom_ros.'
_SOON = 1.0  # [s] of compiling that is not reported
_PERIOD = 10.0  # [s] between two lines that are not overwritten
_WIDTH = 100  # characters of a line that is overwritten


class Progress(event.Listener):  # type: ignore[misc]
    """Counter of compiled functions of this package that reports the progress."""

    def __init__(self, folder: str) -> None:
        """Take the folder of the cache; empty: there is no cache."""
        self._kept = f'kept in {folder}' if folder else 'for this process only: no cache is kept'
        self._depth, self._count, self._spent = 0, 0, 0.0
        self._begun, self._next, self._quiet, self._what = 0.0, _SOON, 0, ''

    @contextmanager
    def silent(self) -> Iterator[None]:
        """Return a context without progress lines, for callers that report themselves."""
        self._quiet += 1
        try:
            yield
        finally:
            self._quiet -= 1

    def on_start(self, event: event.Event) -> None:
        """Count a function whose compilation begins, and report if it is time to."""
        function = event.data['dispatcher'].py_func
        if self._depth == 0:
            self._begun, self._what = time.monotonic(), function.__name__.strip('_')
        self._depth += 1
        if function.__module__.startswith(_PACKAGE):
            self._count += 1
        seconds = self._spent + time.monotonic() - self._begun
        if seconds >= self._next and not self._quiet:
            self._say(seconds)

    def on_end(self, event: event.Event) -> None:
        """Add the time of a compilation that ended."""
        self._depth -= 1
        if self._depth == 0:
            self._spent += time.monotonic() - self._begun
            if self._next > _SOON and sys.stderr.isatty() and not self._quiet:
                print('\r\033[K', end='', file=sys.stderr, flush=True)

    def _say(self, seconds: float) -> None:
        line = (
            f'drake_geom_ros: compiling, once: {self._what}, {self._count} functions so far, '
            f'{seconds:.0f} s'
        )
        if sys.stderr.isatty():
            self._next = seconds + 0.2
            print(f'\r\033[K{line[:_WIDTH]}', end='', file=sys.stderr, flush=True)
        else:
            self._next = seconds + _PERIOD
            print(f'{line}; {self._kept}', file=sys.stderr, flush=True)


class Journal(event.Listener):  # type: ignore[misc]
    """Journal of the functions of this package that are compiled."""

    def __init__(self, folder: str) -> None:
        """Take the folder of the cache; empty: there is no cache."""
        self._folder = folder

    def on_start(self, event: event.Event) -> None:
        """Append a line in one write, because several processes may share the file."""
        file = os.environ.get('DRAKE_GEOM_ROS_COMPILE_LOG')
        dispatcher = event.data['dispatcher']
        function = dispatcher.py_func
        if file and function.__module__.startswith(_PACKAGE):
            name = f'{function.__module__}.{function.__qualname__}'
            folder = self._folder if dispatcher.stats.cache_path else ''
            row = (str(os.getpid()), folder, name, str(event.data['args']))
            with open(file, 'a') as journal:
                journal.write('\t'.join(row) + '\n')

    def on_end(self, event: event.Event) -> None:
        """Do nothing."""
