"""OFF files of text (OFF, COFF). The format has no unit: numbers are metres."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry.meshes._obj_file import triangulate
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh

_HEADERS = ('OFF', 'COFF')  # of vertices alone, or of vertices with colours


def parse_off(data: bytes) -> ParsedMesh:
    """Return the mesh in an OFF file; raises ValueError for a truncated or other file."""
    text = data.decode('utf-8-sig', errors='replace')
    lines = [words for line in text.splitlines() if (words := line.split('#', 1)[0].split())]
    head = lines.pop(0) if lines else []
    if not head or head[0].upper() not in _HEADERS:
        raise ValueError(f'it begins with {" ".join(head)[:20]!r}; {", ".join(_HEADERS)} are read')
    counts = head[1:] or (lines.pop(0) if lines else [])
    if len(counts) < 2:
        raise ValueError('it has no numbers of vertices and faces')
    vertex_count, face_count = int(counts[0]), int(counts[1])
    if len(lines) != vertex_count + face_count or min(vertex_count, face_count) < 0:
        raise ValueError(
            f'its header states {vertex_count} vertices and {face_count} faces, and {len(lines)} '
            'lines follow'
        )
    vertices = np.array([_point(words) for words in lines[:vertex_count]]).reshape(-1, 3)
    triangles: list[tuple[int, int, int]] = []
    for words in lines[vertex_count:]:
        corners = [int(word) for word in words[1 : int(words[0]) + 1]]
        if len(corners) != int(words[0]) or len(corners) < 3:
            raise ValueError(f'the face {" ".join(words)!r} has no {words[0]} vertices, 3 or more')
        if not 0 <= min(corners) <= max(corners) < vertex_count:
            raise ValueError(f'a face has the vertex {max(corners)}; there are {vertex_count}')
        triangles += triangulate(corners, [tuple(vertices[k].tolist()) for k in corners])
    return ParsedMesh(vertices, np.array(triangles, dtype=np.int64).reshape(-1, 3))


def _point(words: list[str]) -> list[float]:
    if len(words) < 3:
        raise ValueError(f'{" ".join(words)!r} is no vertex')
    return [float(word) for word in words[:3]]
