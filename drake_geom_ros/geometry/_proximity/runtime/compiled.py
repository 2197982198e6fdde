"""The decorators of all compiled code: their options, and a cache on disk that is never stale.

Numba judges whether a cached function is out of date by the stamp of the one file that holds it; a
change of a function that it calls, in another file, goes unseen. So the cache lives in a folder
named after the content of all our sources, outside the package, which may be read-only.
``NUMBA_CACHE_DIR`` moves it, ``NUMBA_DISABLE_JIT=1`` leaves everything uncompiled. That folder may
be others' too, so ours is one in it, and there only what bears our names is ever removed: folders
of older sources, when something is compiled.
"""

from __future__ import annotations

import functools
import gc
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numba import cfunc, config, from_dtype, njit, typeof, types, version_info
from numba.core import event

from drake_geom_ros.geometry._proximity.runtime.progress import Journal, Progress
from drake_geom_ros.geometry._proximity.runtime.sources import SOURCES, UNCOMPILED, digest_of

if version_info.short == (0, 68):  # whose inside it relies on; others compile for longer
    from drake_geom_ros.geometry._proximity.runtime import numba_inside as _inside

    numba_inside: Any = _inside
else:
    numba_inside = None

_FOLDER = 'drake_geom_ros'
_VERSION = 'kernels-'  # a digest follows
_KEPT_VERSIONS = 4  # older folders are removed: a developer makes a new one with each edit
# Events: this process compiles something, or waits for another one that does.
_COMPILING = ('numba:compile', *([] if numba_inside is None else [numba_inside.WAITING]))


def _candidates() -> list[Path]:
    """Return the folders that may hold the caches, the best first."""
    if config.CACHE_DIR:
        return [Path(config.CACHE_DIR) / _FOLDER]
    home = os.environ.get('XDG_CACHE_HOME') or os.path.expanduser('~/.cache')
    return [
        Path(home) / _FOLDER,
        Path(tempfile.gettempdir()) / f'{_FOLDER}-{os.getuid()}',
    ]


def _own_folder(path: Path) -> bool:
    """Make a folder that only this user can write to; a cache that others fill runs their code."""
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        return path.stat().st_uid == os.getuid() and os.access(path, os.W_OK)
    except OSError:
        return False


def _cache_folder() -> str:
    """Return the folder of this version's cache, or an empty text where none can be written."""
    name = _VERSION + digest_of(SOURCES, UNCOMPILED)
    for base in _candidates():
        if _own_folder(base) and _own_folder(base / name):
            return str(base / name)
    return ''


CACHE_FOLDER = _cache_folder()


def _last_change(path: Path) -> float:
    """Return when a folder was last changed [s]; 0 where another process removed it meanwhile."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


@functools.cache
def _remove_old_versions() -> None:
    """Remove the caches of older sources but for the newest few, once a process."""
    mine = Path(CACHE_FOLDER)
    others = [path for path in mine.parent.glob(f'{_VERSION}*') if path.name != mine.name]
    others.sort(key=_last_change, reverse=True)
    for old in others[_KEPT_VERSIONS:]:
        shutil.rmtree(old, ignore_errors=True)


class _Compiling(event.Listener):  # type: ignore[misc]
    """Hears of each function that is compiled, ours or not, but not of those from a cache."""

    def on_start(self, event: event.Event) -> None:
        if event.data['dispatcher'].py_func.__module__.startswith(f'{_FOLDER}.'):
            _remove_old_versions()

    def on_end(self, event: event.Event) -> None:
        pass


class _Uncollected(event.Listener):  # type: ignore[misc]
    """Lets no garbage be collected while something is compiled, with what it needs.

    What a compiler makes lives until it is done, so each collection goes through it in vain: 20 to
    30 % of the time of a program with many modules. (Numba compiles under one lock.)
    """

    def __init__(self) -> None:
        self._depth, self._was_enabled = 0, False

    def on_start(self, event: event.Event) -> None:
        if self._depth == 0:
            self._was_enabled = gc.isenabled()
            gc.disable()
        self._depth += 1

    def on_end(self, event: event.Event) -> None:
        self._depth -= 1
        if self._depth == 0 and self._was_enabled:
            gc.enable()


_progress = Progress(CACHE_FOLDER)
event.register('numba:compile', _Uncollected())
for _kind in _COMPILING:
    event.register(_kind, _progress)
event.register('numba:compile', Journal(CACHE_FOLDER))
if CACHE_FOLDER:
    event.register('numba:compile', _Compiling())


# What is compiled is called as it was before, so it keeps its type.
_F = TypeVar('_F', bound=Callable[..., Any])

# Called with the name of what is compiled, its number and that of the last, when it begins.
Tell: TypeAlias = Callable[[str, int, int], None]


class _First(event.Listener):  # type: ignore[misc]
    """Reports the first function that is compiled, not those that the cache has."""

    def __init__(self, action: Callable[[], None]) -> None:
        self._action: Callable[[], None] | None = action

    def on_start(self, event: event.Event) -> None:
        action, self._action = self._action, None
        if action is not None:
            action()

    def on_end(self, event: event.Event) -> None:
        pass


@contextmanager
def compilation(tell: Tell | None, name: str, number: int, last: int) -> Iterator[None]:
    """Report, once, when something in here has to be compiled; without ``tell``: ``Progress``."""
    if tell is None:
        yield
        return
    listener = _First(lambda: tell(name, number, last))
    with ExitStack() as stack:
        for kind in _COMPILING:
            stack.enter_context(event.install_listener(kind, listener))
        stack.enter_context(_progress.silent())
        yield


def compiled(function: _F) -> _F:
    """Return the function compiled on its first call, without the GIL, divisions as in NumPy.

    It makes no arrays and counts no references to those that it is handed: to count them took half
    the time of the depth of two hulls, and a third of that of most pairs (``bench/costs``).
    Compiling fails where it makes one. Whoever returns an array, in a record too, has to count as
    its callers do, else the array is lost or freed twice; a test looks at all of them.
    """
    dispatcher: _F = _compiled(function)
    return dispatcher


def inlined(function: _F) -> _F:
    """Return the function compiled as ``compiled`` does, for callers that must not call it.

    For what is small and called for every pair: LLVM leaves many such calls as they are, and to
    hand arrays and tuples over costs more than the work (half of the narrow phase of 1000 balls).
    """
    dispatcher: _F = _compiled(function, forceinline=True)
    return dispatcher


class Room:
    """The decorators of a room whose caches are in a folder of their own, named after its sources.

    So a change of it leaves all other kernels as they are, and who needs none of it compiles none.
    There is a version of a function for each constant that it is called with.
    """

    def __init__(self, name: str, sources: Iterable[Path]) -> None:
        self.folder = CACHE_FOLDER and str(Path(CACHE_FOLDER) / f'{name}-{digest_of(sources)}')

    def compiled(self, function: _F) -> _F:
        """Return the function compiled on its first call, without the GIL; it makes no arrays."""
        dispatcher: _F = _compiled(function, folder=self.folder, constants=True)
        return dispatcher

    def inlined(self, function: _F) -> _F:
        """Return the function compiled into whoever calls it."""
        options = {'forceinline': True, 'constants': True}
        dispatcher: _F = _compiled(function, folder=self.folder, **options)
        return dispatcher


def allocating(function: _F) -> _F:
    """Return the function compiled as ``compiled`` does, for one that makes arrays."""
    dispatcher: _F = _compiled(function, counted=True)
    return dispatcher


def view(function: _F) -> _F:
    """Return the function compiled to what shows a part of an array and holds no reference to it.

    See ``numba_inside``; without that it counts references.
    """
    if numba_inside is not None and not config.DISABLE_JIT:
        shown: _F = getattr(numba_inside, function.__name__)
        return shown
    dispatcher: _F = _compiled(function, forceinline=True)
    return dispatcher


def made(function: Callable[..., Any]) -> Any:
    """Return a function that was made, which no file has, compiled for callers that are.

    It may return arrays of memory that is not its own, whoever calls it.
    """
    return _compiled(function, counted=True, kept=False)


def given(number: type[Any], dimensions: int) -> Any:
    """Return the type of arrays that are given by anybody: of any strides, and only read."""
    return types.Array(from_dtype(np.dtype(number)), dimensions, 'A', readonly=True)


def own(number: type[Any], dimensions: int) -> Any:
    """Return the type of arrays of one's own, in one piece."""
    return types.Array(from_dtype(np.dtype(number)), dimensions, 'C')


def like(example: Any) -> Any:
    """Return the type of a value: of a number, or of a record of arrays of one's own."""
    return typeof(example)


class Entry:
    """A function that is compiled for arguments of some types alone, when first called.

    ``call`` raises TypeError for others, instead of compiling another version, so that whoever is
    given anything at all needs not look at it first: in the first cycle after other work each look
    costs a microsecond or two. It keeps the lock of the interpreter, for what is soon done: to
    give that back and take it again costs as much once more.
    """

    __slots__ = ('_function', '_types', 'call')

    def __init__(self, function: Callable[..., Any], *kinds: Any) -> None:
        self._function, self._types = function, kinds
        self.call: Callable[..., Any] = self._uncompiled if config.DISABLE_JIT else self._first

    def _first(self, *arguments: Any) -> Any:
        dispatcher = _compiled(self._function, nogil=False)
        dispatcher.compile(self._types)
        dispatcher.disable_compile()
        self.call = dispatcher
        return dispatcher(*arguments)

    def _uncompiled(self, *arguments: Any) -> Any:
        for argument, kind in zip(arguments, self._types, strict=True):
            if isinstance(kind, types.Array) and argument.ndim != kind.ndim:
                raise TypeError('another number of dimensions')
        return self._function(*arguments)


def _compiled(
    function: Callable[..., Any],
    *,
    forceinline: bool = False,
    counted: bool = False,
    kept: bool = True,
    nogil: bool = True,
    folder: str = CACHE_FOLDER,
    constants: bool = False,
) -> Any:
    before = config.CACHE_DIR
    config.CACHE_DIR = folder
    try:
        dispatcher = njit(
            nogil=nogil,
            error_model='numpy',
            forceinline=forceinline,
            **options(counted=counted),
        )(function)
        if kept and folder and not config.DISABLE_JIT:
            _keep(dispatcher, folder)
        return for_compiled_callers(dispatcher, constants=constants)
    finally:
        config.CACHE_DIR = before


def _keep(dispatcher: Any, folder: str) -> None:
    """Have a dispatcher keep what it compiles in a folder: see ``numba_inside``."""
    if numba_inside is None:
        dispatcher.enable_caching()
    else:
        numba_inside.share_cache(dispatcher, folder)


def options(*, counted: bool) -> dict[str, Any]:
    """Return further options of what is compiled: see ``numba_inside``."""
    return {} if numba_inside is None else numba_inside.options(counted)


def for_compiled_callers(dispatcher: Any, *, constants: bool) -> Any:
    """Return the dispatcher, as compiled code is to call it: see ``numba_inside``."""
    if config.DISABLE_JIT or numba_inside is None:
        return dispatcher
    return numba_inside.for_compiled_callers(dispatcher, constants)


def address_of(function: Any, signature: Any) -> Any:
    """Compile a function, or load it from the cache on disk, and return its address for C.

    Uncompiled, the address is the function.
    """
    if config.DISABLE_JIT:
        return function
    if numba_inside is not None:
        return numba_inside.address_of(function, signature)
    before = config.CACHE_DIR
    config.CACHE_DIR = CACHE_FOLDER and str(Path(CACHE_FOLDER) / 'addresses')
    try:
        callback = cfunc(signature, cache=bool(CACHE_FOLDER), error_model='numpy')
        return callback(function.py_func).address
    finally:
        config.CACHE_DIR = before
