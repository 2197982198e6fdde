"""What trimesh does for us: mesh files, convex hulls, connected pieces. Nobody else imports it.

It takes 2 s to import, and most scenes have no mesh.
"""

from __future__ import annotations

import functools
import io
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._obj_file import parse_obj
from drake_geom_ros.geometry._proximity.tolerances import (
    COPLANAR,
    EPS,
    FLAT_HULL,
)
from drake_geom_ros.geometry.errors import MeshFileError

HULL_EXPONENT = 24  # hulls are made of points brought to about 2^24

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


def parse_mesh(data: bytes, kind: str, filename: str) -> tuple[Floats, Indices]:
    """Return vertices (n, 3) [m] and triangles (m, 3) of a file's content; ``kind`` is its suffix.

    The scene of a glTF file is flattened, each mesh where its node puts it. No other file is
    opened, whatever this one names: materials and textures are left out, and a buffer of glTF must
    be embedded. Raises MeshFileError for content that cannot be read.
    """
    if kind == 'obj':  # ours keeps faces of many corners in shape, and knows no materials
        return parse_obj(data.decode(errors='replace'), filename)
    import trimesh

    try:
        mesh: Any = trimesh.load(
            *(io.BytesIO(data), kind, None), force='mesh', process=False, skip_materials=True
        )
        return np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)
    except Exception as error:
        # A reader of many formats raises errors of many kinds.
        raise MeshFileError(
            f'{filename!r} holds no mesh that can be read: {error!r}. What it refers to in other '
            'files, such as buffers of glTF, is not opened: embed them (.glb)'
        ) from None


def parse_colours(data: bytes, kind: str, filename: str) -> NDArray[np.float32] | None:
    """Return the colours (m, 3) from 0 to 1 of a file's triangles, as ``parse_mesh`` counts them.

    Of vertices of several colours the mean. None where the file holds none for faces or vertices;
    materials and textures are left out, and so are all colours of .obj files.
    """
    if kind == 'obj':
        return None
    import trimesh

    try:
        mesh: Any = trimesh.load(
            *(io.BytesIO(data), kind, None), force='mesh', process=False, skip_materials=True
        )
        if not mesh.visual.defined or mesh.visual.kind not in ('face', 'vertex'):
            return None
        # Not of trimesh's own mean of vertices: it is rounded to whole numbers by the version.
        if mesh.visual.kind == 'face':
            colours = np.asarray(mesh.visual.face_colors, dtype=np.float64)
        else:
            of_vertices = np.asarray(mesh.visual.vertex_colors, dtype=np.float64)
            colours = of_vertices[np.asarray(mesh.faces)].mean(axis=1)
        return (colours[:, :3] / 255.0).astype(np.float32)
    except Exception as error:
        raise MeshFileError(f'{filename!r}: its colours cannot be read: {error!r}') from None


@functools.cache
def readable_kinds() -> tuple[str, ...]:
    """Return the suffixes of the files that ``parse_mesh`` reads."""
    import trimesh

    return tuple(sorted({'obj', *trimesh.exchange.load.mesh_formats()}))


def tight_box(points: Floats) -> Floats:
    """Return the axes, columns of a rotation (3, 3), of a smallest box around points (n, 3).

    One side of the box lies in a face of the points' hull.
    """
    import trimesh

    axes: Floats = trimesh.bounds.oriented_bounds(points)[0][:3, :3].T  # type: ignore[no-untyped-call]
    return axes


def convex_hull(points: Floats, name: str) -> tuple[Floats, Indices]:
    """Return vertices and triangles, counter-clockwise from outside, of the convex hull of points.

    Points that lie in a face or on an edge of the hull, to rounding, are none of its vertices.
    ``name`` is for the error. Raises MeshFileError where the hull has no volume.
    """
    extents = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[1]
    if len(extents) < 3 or extents[2] <= FLAT_HULL * extents[0]:
        raise MeshFileError(
            f'{name}: its {len(points)} vertices lie in a plane, and a convex hull without '
            'a volume has no inside; give the mesh a thickness'
        )
    vertices, triangles = _hull(points)
    while (corners := _corners(vertices, triangles)).sum() < len(vertices):
        vertices, triangles = _hull(vertices[corners])
    vertices.flags.writeable = triangles.flags.writeable = False
    return vertices, triangles


def connected_pieces(triangles: Indices, count: int) -> list[Indices]:
    """Return the triangles of each piece, joined by vertices, of a surface of ``count`` ones."""
    from trimesh.graph import connected_component_labels as labelled

    edges = triangles[:, [[0, 1], [1, 2]]].reshape(-1, 2)
    labels = labelled(edges, node_count=count)  # type: ignore[no-untyped-call]
    _, of = np.unique(labels[triangles[:, 0]], return_inverse=True)
    order = np.argsort(of, kind='stable')
    return np.split(order, np.searchsorted(of[order], np.arange(1, int(of.max()) + 1)))


def _hull(points: Floats) -> tuple[Floats, Indices]:
    import trimesh

    # trimesh merges vertices within 1e-8 and drops triangles below 1e-14: at this size that is
    # rounding. A power of two, so that the points stay what they are.
    exponent = HULL_EXPONENT - math.frexp(float(np.abs(points).max()))[1]
    hull = trimesh.Trimesh(np.ldexp(points, exponent), process=False).convex_hull
    vertices = np.ldexp(np.array(hull.vertices, dtype=np.float64), -exponent)
    return vertices, np.array(hull.faces, dtype=np.int64)


def _corners(vertices: Floats, triangles: Indices) -> NDArray[np.bool_]:
    """Return which vertices of a hull are corners, seen from where faces are not all in a line.

    A vertex is none if it is no farther than rounding from the planes of all faces around it, or
    from the segment between two vertices that it shares edges with.
    """
    noise = COPLANAR * EPS * float(np.ptp(vertices, axis=0).max())
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    owners = triangles.ravel()
    order = np.argsort(owners, kind='stable')
    ends = np.searchsorted(owners[order], np.arange(len(vertices) + 1))
    keep = np.ones(len(vertices), dtype=np.bool_)
    for vertex in _beside_flat_edges(vertices, triangles, normals, noise).tolist():
        around = order[ends[vertex] : ends[vertex + 1]] // 3
        ring = np.setdiff1d(triangles[around], [vertex])
        if not keep[ring].all():
            continue  # of two that need each other one stays until the next hull
        arms = vertices[ring] - vertices[vertex]
        flat = np.abs(arms @ normals[around[0]]).max() <= noise
        keep[vertex] = not (flat or _is_between(arms, noise))
    return keep


def _beside_flat_edges(
    vertices: Floats, triangles: Indices, normals: Floats, noise: float
) -> Indices:
    """Return the vertices on an edge whose two triangles lie in one plane: no others can go."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    order = np.lexsort((edges[:, 1], edges[:, 0]))[: len(edges) // 2 * 2]
    first, second = order[::2], order[1::2]
    apex = vertices[triangles[second // 3, (second % 3 + 2) % 3]]
    rises = np.abs(((apex - vertices[edges[first, 0]]) * normals[first // 3]).sum(axis=1))
    return np.unique(edges[first[rises <= noise]])


def _is_between(arms: Floats, noise: float) -> bool:
    """Return whether the origin is on a segment between two points (n, 3), to within ``noise``."""
    lengths = np.linalg.norm(arms, axis=1)
    units = arms / lengths[:, None]
    i, j = np.unravel_index(np.argmin(units @ units.T), (len(arms), len(arms)))
    if units[i] @ units[j] > 0.0:
        return False
    gap = arms[j] - arms[i]
    return float(np.linalg.norm(np.cross(arms[i], gap))) <= noise * float(np.linalg.norm(gap))
