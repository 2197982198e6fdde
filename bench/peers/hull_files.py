"""Convex hulls as files, for the libraries that read them from there."""

from __future__ import annotations

import atexit
import hashlib
import shutil
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

_folder: list[Path] = []


def hull_faces(vertices: NDArray[np.float64]) -> NDArray[np.int32]:
    """Return the triangles (k, 3) of the hull of vertices (n, 3), seen counterclockwise."""
    hull = ConvexHull(vertices)
    faces = hull.simplices.copy()
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    inward = np.einsum('ij,ij->i', np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return faces


def hull_file(vertices: NDArray[np.float64]) -> str:
    """Return the path of an OBJ file with the hull of vertices (n, 3) [m], gone at exit."""
    if not _folder:
        _folder.append(Path(tempfile.mkdtemp(prefix='bench-hulls-')))
        atexit.register(shutil.rmtree, _folder[0])
    path = _folder[0] / f'{hashlib.sha1(vertices.tobytes()).hexdigest()}.obj'
    lines = [f'v {x!r} {y!r} {z!r}' for x, y, z in vertices.tolist()]
    lines += [f'f {a} {b} {c}' for a, b, c in (hull_faces(vertices) + 1).tolist()]
    path.write_text('\n'.join(lines) + '\n')
    return str(path)
