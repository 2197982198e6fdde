"""Windows that bound the pixels of a body: projections of corners, clipped at the near plane."""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._rendering.compiled import compiled, inlined
from drake_geom_ros.geometry._rendering.tolerances import PIXEL_SLACK


@inlined
def pixel(position: float, size: int) -> int:
    """Return a position [pixels] as the index of a row or column, clipped to [-1, size]."""
    return int(min(max(position, -1.0), float(size)))


@inlined
def span(low: float, high: float, focal: float, centre: float, size: int) -> tuple[int, int]:
    """Return the range of pixels, first and end, whose centres are in [low, high].

    ``low`` and ``high`` are slopes x / z; pixel u is at (u + 0.5 - centre) / focal.
    """
    first = np.ceil(low * focal + centre - 0.5 - PIXEL_SLACK)
    last = np.floor(high * focal + centre - 0.5 + PIXEL_SLACK)
    return max(pixel(first, size), 0), min(pixel(last, size), size - 1) + 1


@inlined
def widened(
    x: float, y: float, z: float, box: tuple[float, float, float, float]
) -> tuple[float, float, float, float]:
    """Return a box of slopes (x_low, x_high, y_low, y_high) extended by a point ahead."""
    u, v = x / z, y / z
    return min(box[0], u), max(box[1], u), min(box[2], v), max(box[3], v)


@inlined
def crossed(
    x0: float,
    y0: float,
    z0: float,
    x1: float,
    y1: float,
    z1: float,
    near: float,
    box: tuple[float, float, float, float],
) -> tuple[float, float, float, float]:
    """Return a box of slopes extended by the crossing of an edge and the near plane, if any."""
    if (z0 < near) == (z1 < near):
        return box
    k = (near - z0) / (z1 - z0)
    return widened(x0 + k * (x1 - x0), y0 + k * (y1 - y0), near, box)


@compiled
def box_window(
    R: Floats, p: Floats, hx: float, hy: float, hz: float, view: Floats, width: int, height: int
) -> tuple[int, int, int, int, float]:
    """Return the window (u0, u1, v0, v1) of a posed box, and its least depth.

    The window is empty, u0 >= u1, where the whole box is out of sight.
    """
    near, far = view[4], view[5]
    box = (math.inf, -math.inf, math.inf, -math.inf)
    z_low, z_high = math.inf, -math.inf
    for i in range(8):
        sx = hx if i & 1 else -hx
        sy = hy if i & 2 else -hy
        sz = hz if i & 4 else -hz
        x = p[0] + R[0, 0] * sx + R[0, 1] * sy + R[0, 2] * sz
        y = p[1] + R[1, 0] * sx + R[1, 1] * sy + R[1, 2] * sz
        z = p[2] + R[2, 0] * sx + R[2, 1] * sy + R[2, 2] * sz
        z_low, z_high = min(z_low, z), max(z_high, z)
        if z >= near:
            box = widened(x, y, z, box)
        # The three edges from this corner to those with one more bit.
        if not i & 1:
            x1, y1, z1 = x + 2 * hx * R[0, 0], y + 2 * hx * R[1, 0], z + 2 * hx * R[2, 0]
            box = crossed(x, y, z, x1, y1, z1, near, box)
        if not i & 2:
            x1, y1, z1 = x + 2 * hy * R[0, 1], y + 2 * hy * R[1, 1], z + 2 * hy * R[2, 1]
            box = crossed(x, y, z, x1, y1, z1, near, box)
        if not i & 4:
            x1, y1, z1 = x + 2 * hz * R[0, 2], y + 2 * hz * R[1, 2], z + 2 * hz * R[2, 2]
            box = crossed(x, y, z, x1, y1, z1, near, box)
    if z_high < near or z_low > far:
        return 0, 0, 0, 0, z_low
    u0, u1 = span(box[0], box[1], view[0], view[2], width)
    v0, v1 = span(box[2], box[3], view[1], view[3], height)
    return u0, u1, v0, v1, z_low
