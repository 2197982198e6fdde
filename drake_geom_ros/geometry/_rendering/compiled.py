"""The decorators of the renderer's compiled code: the options of ``_proximity.compiled``.

The caches are in a folder of their own, named after these sources: a change of the renderer leaves
the kernels of distances as they are.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from numba import config, njit

from drake_geom_ros.geometry._proximity.runtime.compiled import (
    CACHE_FOLDER,
    digest_of,
    for_compiled_callers,
    options,
)

SOURCES = (Path(__file__).parent,)  # and those of the folder above: see ``cache_folder``


def cache_folder() -> str:
    """Return the folder of this version's cache, or an empty text where none can be written."""
    if not CACHE_FOLDER:
        return ''
    return str(Path(CACHE_FOLDER) / f'rendering-{digest_of(SOURCES)}')


_FOLDER = cache_folder()
_F = TypeVar('_F', bound=Callable[..., Any])


def compiled(function: _F) -> _F:
    """Return the function compiled on its first call, without the GIL; it makes no arrays."""
    dispatcher: _F = _compiled(function, forceinline=False)
    return dispatcher


def inlined(function: _F) -> _F:
    """Return the function compiled into whoever calls it: for what each pixel needs."""
    dispatcher: _F = _compiled(function, forceinline=True)
    return dispatcher


def _compiled(function: Callable[..., Any], *, forceinline: bool) -> Any:
    before = config.CACHE_DIR
    config.CACHE_DIR = _FOLDER
    try:
        dispatcher = njit(
            cache=bool(_FOLDER),
            nogil=True,
            error_model='numpy',
            forceinline=forceinline,
            **options(counted=False),
        )(function)
        return for_compiled_callers(dispatcher, constants=True)
    finally:
        config.CACHE_DIR = before
