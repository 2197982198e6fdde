"""The parsers of trimesh, which return the arrays of a file as they stand in it.

trimesh is imported by the first mesh that is read, since that takes 0.5 s and most scenes have
none. It drops and guesses where a file is damaged or unusual, so each format has checks of its own
in front of it.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

_NO_FILES: Mapping[str, bytes] = MappingProxyType({})


def parsed(
    data: bytes, kind: str, files: Mapping[str, bytes] = _NO_FILES, **options: Any
) -> dict[str, Any]:
    """Return what a parser of trimesh makes of a file: arrays and their names.

    ``files`` are those that the file names; no other one is opened. Raises errors of many kinds.
    """
    from trimesh.exchange.load import mesh_loaders

    loaders: dict[str, Any] = mesh_loaders
    loaded: dict[str, Any] = loaders[kind](io.BytesIO(data), resolver=dict(files), **options)
    return loaded


def scene_of(data: bytes, kind: str) -> Any:
    """Return trimesh's scene of a file, whose meshes have the arrays of the file."""
    import trimesh

    return trimesh.load_scene(io.BytesIO(data), file_type=kind, process=False)
