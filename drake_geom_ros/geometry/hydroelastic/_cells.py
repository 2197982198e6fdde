"""Cuts a body of convex cells into tetrahedra with matching faces."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry.errors import GeometryError
from drake_geom_ros.geometry.meshes.volume_mesh import VolumeMesh, signed_volumes
from drake_geom_ros.math.array_types import Floats, Indices

Loop = Sequence[int]  # the corners of a flat face, in order around it


class CutBody(NamedTuple):
    """Tetrahedra of a body, and the extent (n,) [-] of each vertex: 0 outside, 1 innermost."""

    mesh: VolumeMesh
    extents: Floats


def body_of_cells(cells: Iterable[Sequence[Loop]], p_MVs: Floats, extents: Floats) -> CutBody:
    """Return the body that convex cells fill; each cell is a sequence of flat faces.

    Corners of a face may coincide (the same index twice); a face of fewer than three is ignored.
    Each cell is cut into pyramids over its lowest vertex, each face into triangles about its own
    lowest one, so that two cells cut a shared face in the same way (a pulling triangulation; De
    Loera, Rambau, Santos, Triangulations, 4.3.2). If the extent is linear in each cell, the cut
    does not change it.
    """
    rows: list[tuple[int, int, int, int]] = []
    for cell in cells:
        faces = [face for face in map(_corners, cell) if len(face) >= 3]
        apex = min(min(face) for face in faces)
        rows += [
            (face[0], face[i], face[i + 1], apex)
            for face in faces
            if apex not in face
            for i in range(1, len(face) - 1)
        ]
    return oriented(np.array(rows, dtype=np.int64), p_MVs, extents)


def oriented(elements: Indices, p_MVs: Floats, extents: Floats) -> CutBody:
    """Return tetrahedra with the orientation of a VolumeMesh, and the vertices that they use.

    Raises GeometryError if one has no volume.
    """
    volumes = signed_volumes(elements, p_MVs)
    if not np.abs(volumes).min() > 0.0:
        raise GeometryError(
            'a hydroelastic mesh has a tetrahedron without volume: '
            f'{p_MVs[elements[int(np.argmin(np.abs(volumes)))]].tolist()}; '
            'the shape is too thin or too finely cut'
        )
    inside_out = volumes < 0.0
    elements[inside_out] = elements[inside_out][:, [1, 0, 2, 3]]
    used, renumbered = np.unique(elements, return_inverse=True)
    mesh = VolumeMesh.FromArrays(renumbered.reshape(-1, 4), p_MVs[used])
    return CutBody(mesh, extents[used])


def _corners(loop: Loop) -> list[int]:
    """Return the distinct corners of a face, starting at the lowest."""
    once = [v for i, v in enumerate(loop) if v not in loop[:i]]
    at = once.index(min(once)) if once else 0
    return once[at:] + once[:at]
