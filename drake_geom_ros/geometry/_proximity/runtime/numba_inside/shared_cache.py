"""A cache on disk that processes share: one of them compiles a function, the others wait for it.

Numba's cache has no regard for other processes. Two that need a function at the same time both
compile it. Two that save different versions of it at the same time may write both to one file, and
the index may name that file for the other version.

A process that holds a lock waits for no further lock, so processes never wait in a circle. The
lock of a process that ends, however it ends, is free.

Relied on: a dispatcher looks into ``_cache`` before it compiles and saves there afterwards, both
within its ``compile`` and under the compiler's lock for threads.
"""

from __future__ import annotations

import fcntl
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from numba.core import event
from numba.core.caching import FunctionCache

WAITING = 'drake_geom_ros:waiting'  # the event of waiting for another process
PATIENCE = 600.0  # [s]; on a busy machine a kernel took 300
_PAUSE = 0.01  # [s]


class Lock:
    """The lock of one function among the processes that share a cache folder."""

    _count = 0  # locks that this process holds

    def __init__(self, path: Path) -> None:
        """``path`` is the file of the lock, made on demand."""
        self.path = path
        self._held: ExitStack | None = None

    def take(self, data: Any = None) -> bool:
        """Wait for the lock and return True; return False if another process still holds it.

        Where there can be no locks, as in a folder that is only read, it returns True at once.

        Args:
            data: of the event of waiting, for listeners.
        """
        if self._held is not None:
            return True
        with ExitStack() as stack:
            try:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                file = stack.enter_context(self.path.open('w'))
                if not (_is_locked(file) or (Lock._count == 0 and _waited(file, data))):
                    return False
            except OSError:
                return True
            # A child that was forked meanwhile has the file open, too: closing it is not enough.
            stack.callback(fcntl.flock, file, fcntl.LOCK_UN)
            Lock._count += 1
            self._held = stack.pop_all()
        return True

    def release(self) -> None:
        """Release the lock if this process holds it."""
        if self._held is not None:
            held, self._held = self._held, None
            Lock._count -= 1
            held.close()


def _is_locked(file: Any) -> bool:
    """Lock a file and return True, or return False if another process has."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _waited(file: Any, data: Any) -> bool:
    """Wait until a file is locked by this process; return False when patience ends."""
    end = time.monotonic() + PATIENCE
    with event.trigger_event(WAITING, data=data):
        while time.monotonic() < end:
            time.sleep(_PAUSE)
            if _is_locked(file):
                return True
    return False


class SharedCache(FunctionCache):  # type: ignore[misc]
    """The cache of a function: a process that misses something in it has the lock until it saves.

    What is compiled without the lock, since another process is compiling it, is not saved.
    """

    def __init__(self, dispatcher: Any, folder: str) -> None:
        """``folder`` holds the locks."""
        function = dispatcher.py_func
        super().__init__(function)
        name = f'{function.__module__}.{function.__qualname__}'
        self.lock = Lock(Path(folder) / 'locks' / name)
        self._event_data = {'dispatcher': dispatcher}
        self._saves = True

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return a version that is in the cache, or None: it is this process that compiles it."""
        found = super().load_overload(sig, target_context)
        if found is None:
            self._saves = self.lock.take(self._event_data)
            found = super().load_overload(sig, target_context)  # saved by another one meanwhile
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save a version."""
        if self._saves:
            super().save_overload(sig, data)


def share_cache(dispatcher: Any, folder: str) -> None:
    """Have a dispatcher keep what it compiles in a cache whose locks are in a folder."""
    cache = dispatcher._cache = SharedCache(dispatcher, folder)
    compile_or_load = dispatcher.compile

    def compile_and_release(sig: Any) -> Any:
        try:
            return compile_or_load(sig)
        finally:
            cache.lock.release()

    dispatcher.compile = compile_and_release
