"""What kernels are given: bodies, how a camera sees them, a band of rows, and what to fill."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class Bodies(NamedTuple):
    """What is shown, in ascending order of ids; a mesh has the kind CONVEX, and its triangles."""

    kinds: Indices  # (n,) shape type numbers
    shapes: Floats  # (n, 3), see ``kernels``
    colours: Floats  # (n, 3) from 0 to 1
    labels: NDArray[np.int16]  # (n,)
    is_labelled: NDArray[np.bool_]  # (n,) false: left out of label images
    vertex_starts: Indices  # (n + 1,)
    p_GVs: Floats  # (v, 3) [m]
    triangle_starts: Indices  # (n + 1,)
    triangles: NDArray[np.int32]  # (f, 3) rows of p_GVs
    facet_colours: NDArray[np.float32]  # (f, 3); below 0: that of the body


class Seen(NamedTuple):
    """Bodies as a camera sees them; numbers of bodies are rows of ``Bodies``."""

    order: Indices  # those that are drawn, from front to back
    R_CGs: Floats  # (n, 3, 3)
    p_CGs: Floats  # (n, 3) [m]
    p_CVs: Floats  # (v, 3) [m]
    windows: Indices  # (n, 4) columns and rows u0, u1, v0, v1
    nearest: Floats  # (n,) least depths [m]
    camera: Floats  # (10,), ``view`` of kernels
    slopes: Floats  # (width,) x of the rays of a row's pixels


class Band(NamedTuple):
    """Rows of an image that are drawn at once."""

    first_row: int
    depths: Floats  # (rows, width) [m]; infinite where nothing is
    owners: NDArray[np.int32]  # (rows, width) the body's row, -1 for none
    facets: NDArray[np.int32]  # (rows, width) the triangle, -1 for primitives


class Normals(NamedTuple):
    """The normals of pixels in C, of length 1; each array (n,)."""

    xs: Floats
    ys: Floats
    zs: Floats


class Windows(NamedTuple):
    """Where bodies can be in an image."""

    pixels: Indices  # (n, 4) columns and rows u0, u1, v0, v1
    nearest: Floats  # (n,) least depths [m]


class Paint(NamedTuple):
    """How colours are made, and room for it."""

    background: Floats  # (3,) from 0 to 1
    edges: bool
    above: NDArray[np.int32]  # (width,) owners of the row before the band
    normals: Floats  # (2, 3, width) of even and of odd rows
    light: NDArray[np.float32]  # (width,)


class Outputs(NamedTuple):
    """Images that are filled; of no size: not wanted."""

    color: NDArray[np.uint32]  # (height, width), a pixel's four bytes in each
    depth: NDArray[np.float32]  # (height, width, 1)
    label: NDArray[np.int16]  # (height, width, 1)
