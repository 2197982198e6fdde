"""A cache on disk that processes share: one of them compiles a function, the others wait for it.

Numba's cache has no regard for other processes: two that need a function at the same time both
compile it. It is tied to the absolute path of a source and to one CPU, so no wheel can bring it.
Here each version of a function is one file, named after all that its code depends on
(``SharedCache._place``).

A process that holds a lock waits for no further lock, so processes never wait in a circle. The
lock of a process that ends, however it ends, is free.

Relied on: a dispatcher looks into ``_cache`` before it compiles and saves there afterwards, both
within its ``compile`` and under the compiler's lock for threads; a compiler does again what
``_compilation_chain_init_hook`` does.
"""

from __future__ import annotations

import fcntl
import functools
import hashlib
import inspect
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core import event
from numba.core.caching import NullCache
from numba.core.serialize import dumps

from drake_geom_ros.geometry._proximity.runtime.numba_inside import kernel_files, object_code

WAITING = 'drake_geom_ros:waiting'  # the event of waiting for another process
PATIENCE = 600.0  # [s]; on a busy machine a kernel took 300
_PAUSE = 0.01  # [s]
_PACKAGE = 'drake_geom_ros.'
# All that the code depends on beside the function, the types of its arguments and the CPU.
_VERSIONS = numba.__version__, llvmlite.__version__, sys.implementation.cache_tag


class Lock:
    """The lock of one function among the processes that share a cache folder."""

    _count = 0  # locks that this process holds

    def __init__(self, path: Path) -> None:
        """Take the file of the lock, which is made on demand."""
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


# Called with the CPU of this machine where kernels for any CPU serve in place of its own.
Served = Callable[[tuple[str, ...]], None]


def any_cpu(machine: tuple[str, ...]) -> tuple[str, ...]:
    """Return how Numba describes code for every CPU of the type of this one."""
    return machine[0], 'generic', ''


@functools.cache
def _content(path: str) -> str:
    """Return a name for the content of a file."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


class SharedCache(NullCache):  # type: ignore[misc]
    """The cache of a function: a process that misses something in it has the lock until it saves.

    What is compiled without the lock, since another process is compiling it, is not saved.
    """

    def __init__(self, dispatcher: Any, own: str, shipped: str, served: Served | None) -> None:
        """Take the folder of the user and the one that is only read; either may be empty.

        With ``served``, code for any CPU serves where there is none for this one.
        """
        self._function = function = dispatcher.py_func
        self._own, self._served = own, served
        self._event_data = {'dispatcher': dispatcher}
        self._folders = [Path(folder) for folder in (shipped, own) if folder]
        module = function.__module__.removeprefix(_PACKAGE)
        self._name = f'{module}.{function.__qualname__}'.replace('<', '').replace('>', '')
        self.lock = Lock(Path(own) / 'locks' / self._name) if own else None
        self._saves = bool(own)

    @property
    def cache_path(self) -> str | None:
        """Return the folder in which versions are kept, or None where none are."""
        return self._own or None

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return a version that is in the cache, or None: it is this process that compiles it."""
        found = self._load(sig, target_context)
        if found is None and self.lock is not None:
            self._saves = self.lock.take(self._event_data)
            found = self._load(sig, target_context)  # saved by another one meanwhile
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save a version."""
        if self._saves and object_code.is_storable(data):
            content = object_code.to_bytes(sig, data)
            try:
                kernel_files.write(
                    self._place(sig, data.codegen.magic_tuple(), self._own), content
                )
            except OSError as error:
                _report_once(self._own, error.strerror or str(error))

    def _load(self, signature: Any, context: Any) -> Any:
        machine = context.codegen().magic_tuple()
        machines = [machine] if self._served is None else [machine, any_cpu(machine)]
        for each in dict.fromkeys(machines):
            for folder in self._folders:
                content = kernel_files.read(self._place(signature, each, folder))
                found = content and object_code.from_bytes(content, signature, context)
                if found:
                    if each != machine and self._served is not None:
                        self._served(machine)
                    return found
        return None

    def _place(self, signature: Any, machine: tuple[str, ...], folder: str | Path) -> Path:
        """Return the file of a version in a folder."""
        code = self._function.__code__
        cells = tuple(cell.cell_contents for cell in self._function.__closure__ or ())
        parts = (
            *(*_VERSIONS, *machine, str(signature), code.co_firstlineno),
            *(code.co_code, dumps(cells) if cells else b''),
            _content(inspect.getfile(self._function)),
        )
        digest = hashlib.sha256(repr(parts).encode()).hexdigest()
        return Path(folder) / f'{self._name[-180:]}-{digest[:24]}.kernel'


@functools.cache
def _report_once(folder: str, reason: str) -> None:
    print(f'drake_geom_ros: cannot keep kernels in {folder}: {reason}', file=sys.stderr)


def share_cache(dispatcher: Any, own: str, shipped: str, served: Served | None) -> None:
    """Have a dispatcher load from these folders and keep what it compiles in its own."""
    cache = dispatcher._cache = SharedCache(dispatcher, own, shipped, served)
    compile_or_load = dispatcher.compile

    def compile_and_release(sig: Any) -> Any:
        try:
            return compile_or_load(sig)
        finally:
            if cache.lock is not None:
                cache.lock.release()

    dispatcher.compile = compile_and_release
    # It looks for extensions of Numba in all packages, which a compiler does in any case.
    dispatcher._compilation_chain_init_hook = lambda: None
