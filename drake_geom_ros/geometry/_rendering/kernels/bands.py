"""All bodies into the buffers of a band of rows."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kinds import CONVEX
from drake_geom_ros.geometry._rendering.compiled import compiled
from drake_geom_ros.geometry._rendering.kernels.primitives import draw_primitive
from drake_geom_ros.geometry._rendering.kernels.triangles import draw_triangles, pose_vertices
from drake_geom_ros.geometry._rendering.kernels.windows import box_window


@compiled
def pose_meshes(
    kinds, R_CGs, p_CGs, vertex_starts, p_GVs, p_CVs, view, size, eye, middle, windows, nearest
):
    """Pose the vertices of all meshes, and fill their windows and least depths.

    ``size`` is width and height; ``eye`` (3, 3) and ``middle`` (3,) are for the box around a mesh.
    """
    for k in range(len(kinds)):
        if kinds[k] != CONVEX:
            continue
        first, last = vertex_starts[k], vertex_starts[k + 1]
        box = pose_vertices(R_CGs[k], p_CGs[k], p_GVs[first:last], p_CVs[first:last])
        for i in range(3):
            middle[i] = 0.5 * (box[2 * i] + box[2 * i + 1])
        hx, hy, hz = 0.5 * (box[1] - box[0]), 0.5 * (box[3] - box[2]), 0.5 * (box[5] - box[4])
        u0, u1, v0, v1, z = box_window(eye, middle, hx, hy, hz, view, size[0], size[1])
        windows[k, 0], windows[k, 1], windows[k, 2], windows[k, 3] = u0, u1, v0, v1
        nearest[k] = z


class Band(NamedTuple):
    """Rows of an image that are drawn at once."""

    first_row: int
    depths: NDArray[np.float64]  # (rows, width) [m]; infinite where nothing is
    owners: NDArray[np.int32]  # (rows, width) the body's row, -1 for none
    facets: NDArray[np.int32]  # (rows, width) the triangle, -1 for primitives


@compiled
def draw_band(
    order,
    kinds,
    shapes,
    R_CGs,
    p_CGs,
    windows,
    nearest,
    triangle_starts,
    triangles,
    p_CVs,
    view,
    slopes,
    band,
):
    """Draw bodies, those named by ``order``, into a band, which is cleared."""
    rows, width = band.depths.shape
    for row in range(rows):
        for u in range(width):
            band.depths[row, u] = np.inf
            band.owners[row, u] = -1
            band.facets[row, u] = -1
    for k in order:
        window = windows[k]
        if window[0] >= window[1] or window[2] >= window[3]:
            continue
        if window[3] <= band.first_row or window[2] >= band.first_row + rows:
            continue
        if kinds[k] == CONVEX:
            first, last = triangle_starts[k], triangle_starts[k + 1]
            draw_triangles(k, first, last, triangles, p_CVs, view, slopes, band)
        else:
            kind, shape, R, p = kinds[k], shapes[k], R_CGs[k], p_CGs[k]
            draw_primitive(k, kind, shape, R, p, window, nearest[k], view, slopes, band)
