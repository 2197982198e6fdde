"""Drawing of triangles into a band, by edge functions of their corners along the ray.

S. Woop, C. Benthin, I. Wald, *Watertight ray/triangle intersection*, Journal of Computer Graphics
Techniques 2(1), 2013: with q = (x - d_x z, y - d_y z) of each corner, the ray d meets the triangle
(a, b, c) where q_b x q_c, q_c x q_a and q_a x q_b have one sign. Normalised to the sum 1, they are
the weights of the corners there. No corner is divided by its depth, so corners behind the camera
need no special case.

Triangles that share a corner compute the same q for it, and rounding preserves the order of two
products: the sign of their difference is right, or it is 0, which counts as inside. So no ray
passes between two adjacent triangles, nor through a shared corner.
"""

import math

from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, signed32
from drake_geom_ros.geometry._rendering.compiled import compiled, inlined
from drake_geom_ros.geometry._rendering.kernels.records import Band, Bodies, Seen
from drake_geom_ros.geometry._rendering.kernels.windows import crossed, span, widened


@compiled
def pose_vertices(
    R: Floats, p: Floats, p_GVs: Floats, p_CVs: Floats
) -> tuple[float, float, float, float, float, float]:
    """Fill ``p_CVs`` (n, 3) with the vertices in C; return the AABB (6) around them."""
    x_low, y_low, z_low = math.inf, math.inf, math.inf
    x_high, y_high, z_high = -math.inf, -math.inf, -math.inf
    for i in range(len(p_GVs)):
        x, y, z = p_GVs[i, 0], p_GVs[i, 1], p_GVs[i, 2]
        cx = R[0, 0] * x + R[0, 1] * y + R[0, 2] * z + p[0]
        cy = R[1, 0] * x + R[1, 1] * y + R[1, 2] * z + p[1]
        cz = R[2, 0] * x + R[2, 1] * y + R[2, 2] * z + p[2]
        p_CVs[i, 0], p_CVs[i, 1], p_CVs[i, 2] = cx, cy, cz
        x_low, y_low, z_low = min(x_low, cx), min(y_low, cy), min(z_low, cz)
        x_high, y_high, z_high = max(x_high, cx), max(y_high, cy), max(z_high, cz)
    return x_low, x_high, y_low, y_high, z_low, z_high


@inlined
def triangle_window(
    x0: float,
    y0: float,
    z0: float,
    x1: float,
    y1: float,
    z1: float,
    x2: float,
    y2: float,
    z2: float,
    view: Floats,
    width: int,
    height: int,
) -> tuple[int, int, int, int]:
    """Return the window (u0, u1, v0, v1) of a triangle; empty where it is out of sight."""
    near = view[4]
    least, most = min(z0, z1, z2), max(z0, z1, z2)
    if most < near or least > view[5]:
        return 0, 0, 0, 0
    box = (math.inf, -math.inf, math.inf, -math.inf)
    if z0 >= near:
        box = widened(x0, y0, z0, box)
    if z1 >= near:
        box = widened(x1, y1, z1, box)
    if z2 >= near:
        box = widened(x2, y2, z2, box)
    if least < near:
        box = crossed(x0, y0, z0, x1, y1, z1, near, box)
        box = crossed(x1, y1, z1, x2, y2, z2, near, box)
        box = crossed(x2, y2, z2, x0, y0, z0, near, box)
    u0, u1 = span(box[0], box[1], view[0], view[2], width)
    v0, v1 = span(box[2], box[3], view[1], view[3], height)
    return u0, u1, v0, v1


@compiled
def draw_triangles(k: int, bodies: Bodies, seen: Seen, band: Band) -> None:
    """Draw the triangles of body ``k`` into a band; see ``draw_primitive``.

    Among triangles of one body at the same depth, the one with the lower number is shown.
    """
    first, last = bodies.triangle_starts[k], bodies.triangle_starts[k + 1]
    triangles, p_CVs, view, slopes = bodies.triangles, seen.p_CVs, seen.camera, seen.slopes
    near, far = view[4], view[5]
    first_row = band.first_row
    rows, width = band.depths.shape
    k = signed32(k)
    for f in range(first, last):
        a, b, c = triangles[f, 0], triangles[f, 1], triangles[f, 2]
        x0, y0, z0 = p_CVs[a, 0], p_CVs[a, 1], p_CVs[a, 2]
        x1, y1, z1 = p_CVs[b, 0], p_CVs[b, 1], p_CVs[b, 2]
        x2, y2, z2 = p_CVs[c, 0], p_CVs[c, 1], p_CVs[c, 2]
        u0, u1, v0, v1 = triangle_window(
            x0, y0, z0, x1, y1, z1, x2, y2, z2, view, width, first_row + rows
        )
        v0 = max(v0, first_row)
        if u0 >= u1 or v0 >= v1:
            continue
        xs = slopes[u0:u1]
        for row in range(v0 - first_row, v1 - first_row):
            y = (row + first_row + 0.5 - view[3]) / view[1]
            ay, by, cy = y0 - y * z0, y1 - y * z1, y2 - y * z2
            row_depths = band.depths[row, u0:u1]
            row_owners = band.owners[row, u0:u1]
            row_facets = band.facets[row, u0:u1]
            for i in range(len(xs)):
                x, deep, owner = xs[i], row_depths[i], row_owners[i]
                ax, bx, cx = x0 - x * z0, x1 - x * z1, x2 - x * z2
                wa, wb, wc = bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx
                inside = (wa >= 0.0) & (wb >= 0.0) & (wc >= 0.0)
                inside |= (wa <= 0.0) & (wb <= 0.0) & (wc <= 0.0)
                total = wa + wb + wc
                z = (wa * z0 + wb * z1 + wc * z2) / total
                # A total of 0 is a triangle seen edge on. Triangles come in ascending order, so
                # that the first one of a body remains at equal depths.
                hit = inside & (total != 0.0) & (near <= z) & (z <= far)
                shown = hit & ((z < deep) | ((z == deep) & (k < owner)))
                row_depths[i] = z if shown else deep
                row_owners[i] = k if shown else owner
                row_facets[i] = f if shown else row_facets[i]
