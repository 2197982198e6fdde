"""Records of the renderer's kernels: bodies, their view by a camera, bands, and outputs."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class Bodies(NamedTuple):
    """Bodies to show, in ascending order of ids; a mesh has the kind CONVEX and its triangles."""

    kinds: Indices  # (n,) shape type numbers
    shapes: Floats  # (n, 3), see ``kernels``
    colours: Floats  # (n, 3) from 0 to 1
    labels: NDArray[np.int16]  # (n,)
    is_labelled: NDArray[np.bool_]  # (n,) False: omitted from label images
    vertex_starts: Indices  # (n + 1,)
    p_GVs: Floats  # (v, 3) [m]
    triangle_starts: Indices  # (n + 1,)
    triangles: NDArray[np.int32]  # (f, 3) rows of p_GVs
    facet_colours: NDArray[np.float32]  # (f, 3); below 0: the colour of the body


class Seen(NamedTuple):
    """Bodies in the view of a camera; numbers of bodies are rows of ``Bodies``."""

    order: Indices  # bodies to draw, from front to back
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
    depths: Floats  # (rows, width) [m]; infinite without a body
    owners: NDArray[np.int32]  # (rows, width) the body's row, -1 for none
    facets: NDArray[np.int32]  # (rows, width) the triangle, -1 for primitives


class Normals(NamedTuple):
    """The normals of pixels in C, of length 1; each array (n,)."""

    xs: Floats
    ys: Floats
    zs: Floats


class Windows(NamedTuple):
    """Windows that bound the pixels of bodies in an image."""

    pixels: Indices  # (n, 4) columns and rows u0, u1, v0, v1
    nearest: Floats  # (n,) least depths [m]


class Paint(NamedTuple):
    """Options of the colours of an image, and scratch arrays."""

    background: Floats  # (3,) from 0 to 1
    edges: bool
    above: NDArray[np.int32]  # (width,) owners of the row before the band
    normals: Floats  # (2, 3, width) of even and of odd rows
    light: NDArray[np.float32]  # (width,)


class Outputs(NamedTuple):
    """Images to fill; an empty array is not filled."""

    color: NDArray[np.uint32]  # (height, width), four bytes of a pixel in each
    depth: NDArray[np.float32]  # (height, width, 1)
    label: NDArray[np.int16]  # (height, width, 1)
