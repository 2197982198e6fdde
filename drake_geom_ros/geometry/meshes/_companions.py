"""Files that a mesh file names: buffers of glTF, which hold its numbers.

They lie beside the mesh file or in folders below, so that a mesh file opens nothing else.
"""

from __future__ import annotations

import json
from pathlib import PurePosixPath
from urllib.parse import unquote

from drake_geom_ros.geometry.errors import MeshFileError


def companions_of(data: bytes, kind: str, filename: str) -> tuple[str, ...]:
    """Return the names of the files that hold numbers of a mesh file; none of an invalid one.

    They are relative to its folder, with ``/`` between folders. Raises MeshFileError for a name
    outside of this folder.
    """
    if kind != 'gltf':
        return ()
    try:
        buffers = json.loads(data)['buffers']
        uris = [buffer['uri'] for buffer in buffers if 'uri' in buffer]
    except (ValueError, KeyError, TypeError):
        return ()
    names = [uri for uri in uris if isinstance(uri, str) and not uri.startswith('data:')]
    return tuple(dict.fromkeys(companion_name(name, filename) for name in names))


def companion_name(uri: str, filename: str) -> str:
    """Return the name of a file that a URI in a mesh file means; MeshFileError for others."""
    name = PurePosixPath(unquote(uri))
    if ':' in uri or '\\' in uri or name.is_absolute() or '..' in name.parts or not name.parts:
        raise MeshFileError(
            f'{filename!r} names the buffer {uri!r}; read are files in its own folder and below'
        )
    return str(name)
