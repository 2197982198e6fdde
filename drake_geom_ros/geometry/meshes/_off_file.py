"""OFF files of text (OFF, COFF). The format has no unit: numbers are metres."""

from __future__ import annotations

from drake_geom_ros.geometry.meshes._obj_file import StatementLines, mesh_of
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh

_HEADERS = ('OFF', 'COFF')  # of vertices alone, or of vertices with colours


def parse_off(data: bytes) -> ParsedMesh:
    """Return the mesh in an OFF file; raises ValueError for a truncated or other file.

    It is read as the faces of an OBJ file, since trimesh's own reader cuts each face into a fan.
    """
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
    rows = list(range(len(lines)))
    points = StatementLines([_point(each) for each in lines[:vertex_count]], rows)
    faces: dict[int, StatementLines] = {}
    for row, words in enumerate(lines[vertex_count:]):
        corners = [int(word) for word in words[1 : int(words[0]) + 1]]
        if len(corners) != int(words[0]) or len(corners) < 3:
            raise ValueError(f'the face {" ".join(words)!r} has no {words[0]} vertices, 3 or more')
        if not 0 <= min(corners) <= max(corners) < vertex_count:
            raise ValueError(f'a face has the vertex {max(corners)}; there are {vertex_count}')
        of_kind = faces.setdefault(len(corners), StatementLines([], []))
        of_kind.texts.append(' '.join(str(corner + 1) for corner in corners))
        of_kind.numbers.append(row)
    return ParsedMesh(*mesh_of(points, faces)[:2])


def _point(words: list[str]) -> str:
    """Return the three numbers of a vertex; raises ValueError for others."""
    if len([float(word) for word in words[:3]]) < 3:
        raise ValueError(f'{" ".join(words)!r} is no vertex')
    return ' '.join(words[:3])
