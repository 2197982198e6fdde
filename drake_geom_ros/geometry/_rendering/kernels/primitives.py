"""Primitives into the buffers of a band: a ray for every pixel of a body's window."""

from drake_geom_ros.geometry._proximity.kinds import BOX, ELLIPSOID, HALF_SPACE, SPHERE
from drake_geom_ros.geometry._rendering.compiled import compiled, inlined
from drake_geom_ros.geometry._rendering.kernels.rays import interval
from drake_geom_ros.geometry._rendering.kernels.windows import box_window


@inlined
def half_sizes(kind, s0, s1, s2):
    """Return half the sizes of the box around a primitive."""
    if kind == SPHERE:
        return s0, s0, s0
    if kind in (BOX, ELLIPSOID):
        return s0, s1, s2
    if kind == HALF_SPACE:
        return 0.0, 0.0, 0.0
    # A capsule's box of the cylinder's size would be too short by its caps.
    return s0, s0, s1 + s0


@compiled
def find_windows(kinds, shapes, R_CGs, p_CGs, view, width, height, windows, nearest):
    """Fill the windows (n, 4) of all bodies and their least depths (n,); meshes have none here."""
    for k in range(len(kinds)):
        hx, hy, hz = half_sizes(kinds[k], shapes[k, 0], shapes[k, 1], shapes[k, 2])
        u0, u1, v0, v1, z = box_window(R_CGs[k], p_CGs[k], hx, hy, hz, view, width, height)
        if kinds[k] == HALF_SPACE:
            u0, u1, v0, v1, z = 0, width, 0, height, view[4]
        windows[k, 0], windows[k, 1], windows[k, 2], windows[k, 3] = u0, u1, v0, v1
        nearest[k] = z


@compiled
def draw_primitive(k, kind, shape, R, p, window, nearest, view, first_row, depths, owners, facets):
    """Draw body ``k``, posed (R, p) in C, into a band that begins with ``first_row``.

    Of surfaces at the same depth that of the body with the lower number is shown, in whatever
    order they are drawn.
    """
    near, far = view[4], view[5]
    s0, s1, s2 = shape[0], shape[1], shape[2]
    ox = -(R[0, 0] * p[0] + R[1, 0] * p[1] + R[2, 0] * p[2])
    oy = -(R[0, 1] * p[0] + R[1, 1] * p[1] + R[2, 1] * p[2])
    oz = -(R[0, 2] * p[0] + R[1, 2] * p[1] + R[2, 2] * p[2])
    begin = max(window[2] - first_row, 0)
    end = min(window[3] - first_row, depths.shape[0])
    for row in range(begin, end):
        y = (row + first_row + 0.5 - view[3]) / view[1]
        bx = R[1, 0] * y + R[2, 0]
        by = R[1, 1] * y + R[2, 1]
        bz = R[1, 2] * y + R[2, 2]
        for u in range(window[0], window[1]):
            if nearest > depths[row, u]:
                continue
            x = (u + 0.5 - view[2]) / view[0]
            dx, dy, dz = R[0, 0] * x + bx, R[0, 1] * x + by, R[0, 2] * x + bz
            t_in, t_out = interval(kind, s0, s1, s2, ox, oy, oz, dx, dy, dz)
            if t_in > t_out:
                continue
            z = t_in if t_in >= near else t_out
            if not near <= z <= far:
                continue
            if z < depths[row, u] or (z == depths[row, u] and k < owners[row, u]):
                depths[row, u] = z
                owners[row, u] = k
                facets[row, u] = -1
