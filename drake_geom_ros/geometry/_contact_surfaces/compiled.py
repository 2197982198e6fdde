"""The decorators of this room's compiled code: the options of ``_proximity.runtime.compiled``.

The caches are in a folder of their own, named after these sources, as those of the renderer are: a
change here leaves all other kernels as they are, and who asks for no surface compiles none.
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

SOURCES = (Path(__file__).parent,)
_FOLDER = CACHE_FOLDER and str(Path(CACHE_FOLDER) / f'contact-surfaces-{digest_of(SOURCES)}')
_F = TypeVar('_F', bound=Callable[..., Any])


def compiled(function: _F) -> _F:
    """Return the function compiled on its first call, without the GIL; it makes no arrays."""
    dispatcher: _F = _compiled(function, forceinline=False)
    return dispatcher


def inlined(function: _F) -> _F:
    """Return the function compiled into whoever calls it."""
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
