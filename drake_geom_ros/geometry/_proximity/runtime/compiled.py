"""The decorators of all compiled code: their options, and the cache on disk that they share.

``NUMBA_DISABLE_JIT=1`` leaves everything uncompiled. ``cache_folders`` says where the cache is.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numba import __version__ as numba_version
from numba import cfunc, config, from_dtype, njit, typeof, types, version_info
from numba.core import event

from drake_geom_ros.geometry._proximity.runtime.cache_folders import (
    FOLDERS,
    CacheFolders,
    remove_old_versions,
)
from drake_geom_ros.geometry._proximity.runtime.compile_behind import (
    VARIABLE,
    Mode,
    compile_behind,
    mode,
)
from drake_geom_ros.geometry._proximity.runtime.progress import Journal, Progress
from drake_geom_ros.geometry._proximity.runtime.sources import digest_of

# The version whose inside was tested. With another one compiling takes three times as long.
TESTED_NUMBA = (0, 68)
if version_info.short == TESTED_NUMBA:
    from drake_geom_ros.geometry._proximity.runtime import numba_inside as _inside

    numba_inside: Any = _inside
else:
    numba_inside = None

_PACKAGE = 'drake_geom_ros.'
CACHE_FOLDER = FOLDERS.own
# Events: this process compiles something, or waits for another one that does.
_COMPILING = ('numba:compile', *([] if numba_inside is None else [numba_inside.WAITING]))


class _Compiling(event.Listener):  # type: ignore[misc]
    """Hears of each function that is compiled, ours or not, but not of those from a cache."""

    def on_start(self, event: event.Event) -> None:
        if event.data['dispatcher'].py_func.__module__.startswith(_PACKAGE):
            remove_old_versions(CACHE_FOLDER)

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


def _report_slow_way() -> None:
    print(f'drake_geom_ros: kernels are {kernels_in_words()}', file=sys.stderr)


_progress = Progress(CACHE_FOLDER)
event.register('numba:compile', _Uncollected())
for _kind in _COMPILING:
    event.register(_kind, _progress)
event.register('numba:compile', Journal(CACHE_FOLDER))
if CACHE_FOLDER:
    event.register('numba:compile', _Compiling())
if numba_inside is None:
    event.register('numba:compile', _First(_report_slow_way))


# What is compiled is called as it was before, so it keeps its type.
_F = TypeVar('_F', bound=Callable[..., Any])

# Called with the name of what is compiled, its number and that of the last, when it begins.
Tell: TypeAlias = Callable[[str, int, int], None]


def kernels_in_words() -> str:
    """Return which kernels answer in this process, and why not the fastest."""
    if config.DISABLE_JIT:
        return 'none: NUMBA_DISABLE_JIT is set'
    if numba_inside is None:
        tested = '.'.join(map(str, TESTED_NUMBA))
        return (
            f'compiled in the slow way by Numba {numba_version} (tested is {tested}): compiling '
            'takes three times as long, and small queries up to twice as long'
        )
    if _any_cpu_serves:
        return f'for any CPU of this type ({VARIABLE} is {mode().value})'
    return 'for this CPU'


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
        self.folders = FOLDERS.room(f'{name}-{digest_of(sources)}')

    def compiled(self, function: _F) -> _F:
        """Return the function compiled on its first call, without the GIL; it makes no arrays."""
        dispatcher: _F = _compiled(function, folders=self.folders, constants=True)
        return dispatcher

    def inlined(self, function: _F) -> _F:
        """Return the function compiled into whoever calls it."""
        options = {'forceinline': True, 'constants': True}
        dispatcher: _F = _compiled(function, folders=self.folders, **options)
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
    folders: CacheFolders = FOLDERS,
    constants: bool = False,
) -> Any:
    dispatcher = njit(
        nogil=nogil,
        error_model='numpy',
        forceinline=forceinline,
        **options(counted=counted),
    )(function)
    if kept and not config.DISABLE_JIT:
        _keep(dispatcher, folders)
    return for_compiled_callers(dispatcher, constants=constants)


def _keep(dispatcher: Any, folders: CacheFolders) -> None:
    """Have a dispatcher keep what it compiles in these folders: see ``numba_inside``."""
    if numba_inside is not None:
        served = None if mode() is Mode.FIRST else _use_any_cpu
        numba_inside.share_cache(dispatcher, *folders, served)
    elif folders.own:
        with _caching_in(folders.own):
            dispatcher.enable_caching()


def _use_any_cpu(machine: tuple[str, ...]) -> None:
    """Note that a kernel for any CPU serves, and have those for this one compiled."""
    _any_cpu_serves.add(machine)
    compile_behind(CACHE_FOLDER, machine)


_any_cpu_serves: set[tuple[str, ...]] = set()


@contextmanager
def _caching_in(folder: str) -> Iterator[None]:
    """Return a context in which Numba's own cache is in a folder."""
    before = config.CACHE_DIR
    config.CACHE_DIR = folder
    try:
        yield
    finally:
        config.CACHE_DIR = before


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
    with _caching_in(CACHE_FOLDER and str(Path(CACHE_FOLDER) / 'addresses')):
        callback = cfunc(signature, cache=bool(CACHE_FOLDER), error_model='numpy')
        return callback(function.py_func).address
