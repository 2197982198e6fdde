"""Folders of compiled functions: one of the user, and one that the package may bring.

Numba judges whether a cached function is out of date by the one file that holds it; a change of a
function that it calls, in another file, goes unseen. So the cache lives in a folder named after
the content of all sources, outside the package, which may be read-only. ``NUMBA_CACHE_DIR`` moves
it. That folder may hold other things too, so only what bears these names is ever removed: folders
of older sources, when something is compiled.

A wheel brings a second folder, ``_kernels``, which is only read: kernels for every CPU of the
machine's type. It is as trustworthy as the package that holds it.
"""

from __future__ import annotations

import functools
import os
import shutil
import stat
import tempfile
from pathlib import Path
from typing import NamedTuple

from numba import config

from drake_geom_ros.geometry._proximity.runtime.sources import (
    PACKAGE,
    SOURCES,
    UNCOMPILED,
    digest_of,
)

_FOLDER = 'drake_geom_ros'
SHIPPED = PACKAGE / '_kernels'
_VERSION = 'kernels-'  # a digest follows
_KEPT_VERSIONS = 4  # older folders are removed: a developer makes a new one with each edit
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


class CacheFolders(NamedTuple):
    """The folders of one set of compiled functions."""

    own: str  # of this user; empty where none can be written
    shipped: str  # of the package, only read; empty where it brings none

    def room(self, name: str) -> CacheFolders:
        """Return the folders of this name within these."""
        return CacheFolders(*(folder and str(Path(folder) / name) for folder in self))


def _candidates() -> list[Path]:
    """Return the folders that may hold the caches, the best first."""
    if config.CACHE_DIR:
        return [Path(config.CACHE_DIR) / _FOLDER]
    home = os.environ.get('XDG_CACHE_HOME') or os.path.expanduser('~/.cache')
    return [
        Path(home) / _FOLDER,
        Path(tempfile.gettempdir()) / f'{_FOLDER}-{os.getuid()}',
    ]


def own_folder(path: Path) -> bool:
    """Make a folder that only this user can write to, and return whether it is one.

    A cache that other users can fill runs their code.
    """
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = path.stat()
    except OSError:
        return False
    is_shared = status.st_uid != os.getuid() or status.st_mode & _OTHERS_WRITE
    return not is_shared and os.access(path, os.W_OK)


def _found() -> CacheFolders:
    """Return the folders of these sources."""
    name = _VERSION + digest_of(SOURCES, UNCOMPILED)
    own = ''
    for base in _candidates():
        if own_folder(base) and own_folder(base / name):
            own = str(base / name)
            break
    shipped = SHIPPED / name
    return CacheFolders(own, str(shipped) if shipped.is_dir() else '')


FOLDERS = _found()


def _last_change(path: Path) -> float:
    """Return when a folder was last changed [s]; 0 where another process removed it meanwhile."""
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


@functools.cache
def remove_old_versions(folder: str) -> None:
    """Remove the caches beside this one, of older sources, but for the newest few."""
    current = Path(folder)
    others = [path for path in current.parent.glob(f'{_VERSION}*') if path.name != current.name]
    others.sort(key=_last_change, reverse=True)
    for old in others[_KEPT_VERSIONS:]:
        shutil.rmtree(old, ignore_errors=True)
