"""Conversion of a band's buffers to pixels: depth, label, colour."""

import math
import sys

import numpy as np

from drake_geom_ros.geometry._proximity.kinds import HALF_SPACE
from drake_geom_ros.geometry._proximity.runtime.arrays import (
    Floats,
    Integers16,
    Integers32,
    Singles,
    Unsigned32,
    signed32,
    unsigned32,
)
from drake_geom_ros.geometry._rendering.compiled import compiled, inlined
from drake_geom_ros.geometry._rendering.kernels.normals import facet_normals, primitive_normals
from drake_geom_ros.geometry._rendering.kernels.records import Band, Bodies, Normals, Paint, Seen
from drake_geom_ros.geometry._rendering.tolerances import EDGE_COSINE

# Parts of a surface's brightness: ambient light, light from the camera, and light from above.
# Single precision is more than enough for light, and twice as fast.
AMBIENT, FROM_CAMERA, FROM_ABOVE = np.float32(0.35), np.float32(0.5), np.float32(0.25)
# Factor of the brightness at an edge.
EDGE = np.float32(0.45)
ONE, NONE = np.float32(1.0), np.float32(0.0)
# Shifts of a pixel's bytes, in this order in memory, within a 32-bit number.
RED, GREEN, BLUE, ALPHA = (0, 8, 16, 24) if sys.byteorder == 'little' else (24, 16, 8, 0)


@compiled
def write_depths(depths: Floats, low: float, high: float, out: Singles) -> None:
    """Write depths (rows, width) [m] as float32: 0 below ``low``, infinity above ``high``."""
    for row in range(depths.shape[0]):
        for u in range(depths.shape[1]):
            z = depths[row, u]
            if z < low:
                out[row, u, 0] = 0.0
            elif z <= high:
                out[row, u, 0] = z
            else:
                out[row, u, 0] = math.inf


@compiled
def write_labels(owners: Integers32, labels: Integers16, empty: int, out: Integers16) -> None:
    """Write the labels (n,) of the owners, ``empty`` where there is none."""
    for row in range(owners.shape[0]):
        for u in range(owners.shape[1]):
            k = owners[row, u]
            out[row, u, 0] = empty if k < 0 else labels[k]


@inlined
def run_end(u: int, owners: Integers32) -> int:
    """Return the end of the run of pixels from ``u`` on that show the same body, or none."""
    end = u + 1
    while end < len(owners) and owners[end] == owners[u]:
        end += 1
    return end


@compiled
def find_edges(
    owners: Integers32,
    normals: Normals,
    other_owners: Integers32,
    other_normals: Normals,
    factors: Singles,
) -> None:
    """Darken pixels whose neighbour shows another body or another face, by ``factors`` (n,).

    All arrays are (n,). A body's silhouette belongs to the body: pixels without a body are not
    darkened, those beside them are.
    """
    xs, ys, zs = normals
    other_xs, other_ys, other_zs = other_normals
    for i in range(len(owners)):
        cosine = xs[i] * other_xs[i] + ys[i] * other_ys[i] + zs[i] * other_zs[i]
        is_edge = (owners[i] != other_owners[i]) | (cosine < EDGE_COSINE)
        factors[i] = EDGE if is_edge else factors[i]


@compiled
def light_run(y: float, slopes: Floats, view: Floats, normals: Normals, light: Singles) -> None:
    """Multiply ``light`` (n,) by the light at pixels (n,) from the camera and from above."""
    xs, ys, zs = normals
    up_x, up_y, up_z = view[6], view[7], view[8]
    for i in range(len(slopes)):
        x = slopes[i]
        towards = np.float32(-(xs[i] * x + ys[i] * y + zs[i]))
        up = np.float32(xs[i] * up_x + ys[i] * up_y + zs[i] * up_z)
        facing = towards / math.sqrt(np.float32(x * x + y * y + 1.0))
        lit = AMBIENT + FROM_CAMERA * facing + FROM_ABOVE * (up if up > NONE else NONE)
        light[i] = (lit if lit > NONE else NONE) * light[i]


@inlined
def channel(value: float, shift: int) -> int:
    """Return a colour channel, clipped to 1, as eight bits of a pixel."""
    level = signed32((value if value < ONE else ONE) * np.float32(255.0) + np.float32(0.5))
    return unsigned32(level) << unsigned32(shift)


@inlined
def pixel(red: float, green: float, blue: float) -> int:
    """Return a pixel's bytes as one number, which is five times faster than single bytes."""
    opaque = unsigned32(255) << unsigned32(ALPHA)
    return channel(red, RED) | channel(green, GREEN) | channel(blue, BLUE) | opaque


@compiled
def colour_run(colour: Floats, light: Singles, out: Unsigned32) -> None:
    """Write pixels (n,) of one colour at their light (n,)."""
    red, green, blue = np.float32(colour[0]), np.float32(colour[1]), np.float32(colour[2])
    for i in range(len(light)):
        out[i] = pixel(red * light[i], green * light[i], blue * light[i])


@compiled
def colour_facets(
    facets: Integers32, facet_colours: Singles, light: Singles, out: Unsigned32
) -> None:
    """Overwrite those pixels (n,) that show a triangle with a colour of its own."""
    for i in range(len(light)):
        colour = facet_colours[facets[i]]
        if colour[0] >= 0.0:
            out[i] = pixel(colour[0] * light[i], colour[1] * light[i], colour[2] * light[i])


@compiled
def write_colours(bodies: Bodies, seen: Seen, paint: Paint, band: Band, out: Unsigned32) -> None:
    """Write a band's colours, row by row, in runs of pixels that show one body.

    The last row's owners and normals are stored in ``paint``, so that edges do not depend on the
    borders of bands.
    """
    first_row, owners, facets = band.first_row, band.owners, band.facets
    background, edges, above, normals, light = paint
    view, slopes, R_CGs, p_CGs = seen.camera, seen.slopes, seen.R_CGs, seen.p_CGs
    width, count = len(slopes), len(owners)
    for row in range(count):
        y = (row + first_row + 0.5 - view[3]) / view[1]
        here, odd = owners[row], (row + first_row) & 1
        before = owners[row - 1] if row > 0 else above
        xs, ys, zs = normals[odd, 0], normals[odd, 1], normals[odd, 2]
        up_xs, up_ys, up_zs = normals[1 - odd, 0], normals[1 - odd, 1], normals[1 - odd, 2]
        end = 0
        while end < width:
            u = end
            k, end = here[u], run_end(u, here)
            lit, pixels = light[u:end], out[row, u:end]
            for i in range(len(lit)):
                lit[i] = ONE
            if k < 0:
                colour_run(background, lit, pixels)
                continue
            rays, shown = slopes[u:end], facets[row, u:end]
            towards = Normals(xs[u:end], ys[u:end], zs[u:end])
            if shown[0] >= 0:
                facet_normals(shown, bodies.triangles, seen.p_CVs, y, rays, towards)
            else:
                R, p, deep = R_CGs[k], p_CGs[k], band.depths[row, u:end]
                primitive_normals(bodies.kinds[k], bodies.shapes[k], R, p, y, rays, deep, towards)
            if edges:
                if row + first_row > 0:
                    others = Normals(up_xs[u:end], up_ys[u:end], up_zs[u:end])
                    find_edges(here[u:end], towards, before[u:end], others, lit)
                # Within a run of a half space, neighbours show the same face.
                v, last = max(u, 1), u + 1 if bodies.kinds[k] == HALF_SPACE else end
                a, b = v - 1, last - 1
                inner = Normals(xs[v:last], ys[v:last], zs[v:last])
                others = Normals(xs[a:b], ys[a:b], zs[a:b])
                find_edges(here[v:last], inner, here[a:b], others, light[v:last])
            light_run(y, rays, view, towards, lit)
            colour_run(bodies.colours[k], lit, pixels)
            if shown[0] >= 0:
                colour_facets(shown, bodies.facet_colours, lit, pixels)
    for u in range(width):
        above[u] = owners[count - 1, u]
