"""The buffers of a band to pixels: depth, label, colour."""

import math

from drake_geom_ros.geometry._rendering.compiled import compiled, inlined
from drake_geom_ros.geometry._rendering.kernels.rays import normal
from drake_geom_ros.geometry._rendering.tolerances import EDGE_COSINE

# Of a surface's colour: what it has everywhere, and what light from the camera and from above add.
AMBIENT, FROM_CAMERA, FROM_ABOVE = 0.35, 0.5, 0.25
# What is left of the colour at an edge.
EDGE = 0.45


@compiled
def write_depths(depths, low, high, out):
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
def write_labels(owners, labels, empty, out):
    """Write the labels (n,) of the owners, ``empty`` where there is none."""
    for row in range(owners.shape[0]):
        for u in range(owners.shape[1]):
            k = owners[row, u]
            out[row, u, 0] = empty if k < 0 else labels[k]


@inlined
def normal_in_camera(k, f, z, x, y, kinds, shapes, R_CGs, p_CGs, triangles, p_CVs):
    """Return the unit normal in C at depth z of a pixel's ray (x, y, 1), towards the camera."""
    if f >= 0:
        a, b, c = triangles[f, 0], triangles[f, 1], triangles[f, 2]
        ex, ey, ez = (
            p_CVs[b, 0] - p_CVs[a, 0],
            p_CVs[b, 1] - p_CVs[a, 1],
            p_CVs[b, 2] - p_CVs[a, 2],
        )
        gx, gy, gz = (
            p_CVs[c, 0] - p_CVs[a, 0],
            p_CVs[c, 1] - p_CVs[a, 1],
            p_CVs[c, 2] - p_CVs[a, 2],
        )
        nx, ny, nz = ey * gz - ez * gy, ez * gx - ex * gz, ex * gy - ey * gx
    else:
        R = R_CGs[k]
        cx, cy, cz = x * z - p_CGs[k, 0], y * z - p_CGs[k, 1], z - p_CGs[k, 2]
        px = R[0, 0] * cx + R[1, 0] * cy + R[2, 0] * cz
        py = R[0, 1] * cx + R[1, 1] * cy + R[2, 1] * cz
        pz = R[0, 2] * cx + R[1, 2] * cy + R[2, 2] * cz
        mx, my, mz = normal(kinds[k], shapes[k, 0], shapes[k, 1], shapes[k, 2], px, py, pz)
        nx = R[0, 0] * mx + R[0, 1] * my + R[0, 2] * mz
        ny = R[1, 0] * mx + R[1, 1] * my + R[1, 2] * mz
        nz = R[2, 0] * mx + R[2, 1] * my + R[2, 2] * mz
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    if nx * x + ny * y + nz > 0.0:
        length = -length
    if length == 0.0:
        return 0.0, 0.0, -1.0
    return nx / length, ny / length, nz / length


@inlined
def is_edge(k, nx, ny, nz, other, m):
    """Return whether a pixel of body k and normal n differs from a neighbour and its normal m."""
    return other != k or nx * m[0] + ny * m[1] + nz * m[2] < EDGE_COSINE


@inlined
def channel(value):
    """Return a colour from 0 to 1 as a number of 8 bits."""
    return int(min(max(value, 0.0), 1.0) * 255.0 + 0.5)


@compiled
def write_colours(
    first_row,
    depths,
    owners,
    facets,
    view,
    kinds,
    shapes,
    R_CGs,
    p_CGs,
    triangles,
    p_CVs,
    colours,
    facet_colours,
    background,
    edges,
    above,
    normals,
    out,
):
    """Write a band's colours.

    ``above`` (width,) and ``normals`` (width, 3) are owners and normals of the row above, and are
    left as those of the last row: so an edge does not hang on where bands end.
    """
    for row in range(depths.shape[0]):
        y = (row + first_row + 0.5 - view[3]) / view[1]
        for u in range(depths.shape[1]):
            k, f, z = owners[row, u], facets[row, u], depths[row, u]
            out[row, u, 3] = 255
            if k < 0:
                for i in range(3):
                    out[row, u, i] = channel(background[i])
                # A body's silhouette belongs to the body: the pixel beside it draws it.
                above[u] = k
                continue
            x = (u + 0.5 - view[2]) / view[0]
            nx, ny, nz = normal_in_camera(
                k, f, z, x, y, kinds, shapes, R_CGs, p_CGs, triangles, p_CVs
            )
            facing = -(nx * x + ny * y + nz) / math.sqrt(x * x + y * y + 1.0)
            up = max(nx * view[6] + ny * view[7] + nz * view[8], 0.0)
            light = AMBIENT + FROM_CAMERA * facing + FROM_ABOVE * up
            if edges:
                new = row + first_row > 0 and is_edge(k, nx, ny, nz, above[u], normals[u])
                if u > 0:
                    new = new or is_edge(k, nx, ny, nz, above[u - 1], normals[u - 1])
                if new:
                    light *= EDGE
            above[u] = k
            normals[u, 0], normals[u, 1], normals[u, 2] = nx, ny, nz
            for i in range(3):
                base = colours[k, i]
                if f >= 0 and facet_colours[f, 0] >= 0.0:
                    base = facet_colours[f, i]
                out[row, u, i] = channel(base * light)
