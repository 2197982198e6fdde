"""Drawing of all bodies into a band of rows, and of all bands into images."""

import numpy as np

from drake_geom_ros.geometry._proximity.kinds import CONVEX
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._rendering.compiled import compiled
from drake_geom_ros.geometry._rendering.kernels.primitives import draw_primitive
from drake_geom_ros.geometry._rendering.kernels.records import (
    Band,
    Bodies,
    Outputs,
    Paint,
    Seen,
    Windows,
)
from drake_geom_ros.geometry._rendering.kernels.shading import (
    write_colours,
    write_depths,
    write_labels,
)
from drake_geom_ros.geometry._rendering.kernels.triangles import draw_triangles, pose_vertices
from drake_geom_ros.geometry._rendering.kernels.windows import box_window


@compiled
def pose_meshes(
    bodies: Bodies,
    R_CGs: Floats,
    p_CGs: Floats,
    p_CVs: Floats,
    view: Floats,
    size: tuple[int, int],
    scratch: tuple[Floats, Floats],
    body_windows: Windows,
) -> None:
    """Pose the vertices of all meshes, and fill their windows.

    ``size`` is width and height; ``scratch`` is the identity (3, 3), and (3,) for a box centre.
    """
    kinds, vertex_starts, p_GVs = bodies.kinds, bodies.vertex_starts, bodies.p_GVs
    (eye, middle), (windows, nearest) = scratch, body_windows
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


@compiled
def draw_band(bodies: Bodies, seen: Seen, band: Band) -> None:
    """Clear a band, and draw the seen bodies into it."""
    rows, width = band.depths.shape
    for row in range(rows):
        for u in range(width):
            band.depths[row, u] = np.inf
            band.owners[row, u] = -1
            band.facets[row, u] = -1
    for k in seen.order:
        window = seen.windows[k]
        if window[0] >= window[1] or window[2] >= window[3]:
            continue
        if window[3] <= band.first_row or window[2] >= band.first_row + rows:
            continue
        if bodies.kinds[k] == CONVEX:
            draw_triangles(k, bodies, seen, band)
        else:
            draw_primitive(k, bodies, seen, band)


@compiled
def draw_bands(
    bodies: Bodies,
    seen: Seen,
    buffers: Band,
    paint: Paint,
    depth_range: tuple[float, float],
    empty: int,
    top: int,
    outputs: Outputs,
) -> None:
    """Draw the seen bodies by bands of the size of ``buffers``, and fill ``outputs``.

    ``depth_range`` are the least and the largest depth [m] in images, ``empty`` is the label of
    pixels without a body, ``top`` is the row of the image in which ``outputs`` begin. All bands
    are drawn in one call, because between two calls another thread could take Python's lock.
    """
    color, depth, label = outputs
    height = max(len(color), len(depth), len(label))
    rows = len(buffers.depths)
    for first in range(0, height, rows):
        last = min(first + rows, height)
        count = last - first
        band = Band(
            top + first, buffers.depths[:count], buffers.owners[:count], buffers.facets[:count]
        )
        draw_band(bodies, seen, band)
        if len(depth):
            write_depths(band.depths, depth_range[0], depth_range[1], depth[first:last])
        if len(label):
            write_labels(band.owners, bodies.labels, empty, label[first:last])
        if len(color):
            write_colours(bodies, seen, paint, band, color[first:last])
