"""The points of a PLY file, without faces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry.meshes._formats import parse_mesh


def ply_points(data: bytes, filename: str) -> NDArray[np.float64]:
    r"""Return the vertices (n, 3) [m] in the content of a PLY file, in its order.

    ``filename`` is for the error. Raises MeshFileError for content that cannot be read completely.

    >>> text = b'ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n'
    >>> ply_points(text + b'property float z\nend_header\n1 2 3\n', 'one.ply').tolist()
    [[1.0, 2.0, 3.0]]
    """
    return parse_mesh(data, 'ply', filename).vertices
