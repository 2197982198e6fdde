"""Compiling before anybody waits for it."""

from __future__ import annotations

from drake_geom_ros.geometry._proximity.compiled import CACHE_FOLDER, Tell
from drake_geom_ros.geometry._proximity.rehearsal import compile_everything


def compile_all_kernels(tell: Tell | None = None) -> list[str]:
    """Compile what queries of any scene run, or load it from the cache; return the kernels.

    Takes minutes the first time and about a second from then on. ``tell(name, number, last)`` is
    called before each part that the cache does not have.
    ``SceneGraphContext.compile_kernels`` does it for one scene.
    """
    return compile_everything(tell)


def kernel_cache() -> str:
    """Return the folder that keeps compiled kernels; empty where none can be written."""
    return CACHE_FOLDER
