"""The decorators of the renderer's compiled code: the options of ``_proximity.compiled``.

The caches are in a folder of their own, named after these sources: a change of the renderer leaves
the kernels of distances as they are.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import config, njit

from drake_geom_ros.geometry._proximity.compiled import (
    CACHE_FOLDER,
    entry_options,
    for_compiled_callers,
)


def _cache_folder() -> str:
    """Return the folder of this version's cache, or an empty text where none can be written."""
    if not CACHE_FOLDER:
        return ''
    folder = Path(__file__).parent
    sources = b''.join(path.read_bytes() for path in sorted(folder.rglob('*.py')))
    return str(Path(CACHE_FOLDER) / f'rendering-{hashlib.sha256(sources).hexdigest()[:16]}')


_FOLDER = _cache_folder()


def compiled(function: Callable[..., Any]) -> Any:
    """Return the function compiled on its first call, without the GIL; it makes no arrays."""
    return _compiled(function, forceinline=False)


def inlined(function: Callable[..., Any]) -> Any:
    """Return the function compiled into whoever calls it: for what each pixel needs."""
    return _compiled(function, forceinline=True)


def _compiled(function: Callable[..., Any], *, forceinline: bool) -> Any:
    before = config.CACHE_DIR
    config.CACHE_DIR = _FOLDER
    try:
        dispatcher = njit(
            cache=bool(_FOLDER),
            nogil=True,
            error_model='numpy',
            forceinline=forceinline,
            _nrt=False,
            **entry_options(),
        )(function)
        return for_compiled_callers(dispatcher, constants=True)
    finally:
        config.CACHE_DIR = before
