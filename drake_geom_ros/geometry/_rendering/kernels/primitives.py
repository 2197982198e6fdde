"""Drawing of primitives into a band, by a ray for every pixel of a body's window."""

from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HALF_SPACE,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector, signed32
from drake_geom_ros.geometry._rendering.compiled import compiled, inlined
from drake_geom_ros.geometry._rendering.kernels.rays import interval
from drake_geom_ros.geometry._rendering.kernels.records import Band, Bodies, Seen, Windows
from drake_geom_ros.geometry._rendering.kernels.windows import box_window


@inlined
def half_sizes(kind: int, s0: float, s1: float, s2: float) -> Vector:
    """Return half the sizes of the box around a primitive."""
    if kind == SPHERE:
        return s0, s0, s0
    if kind in (BOX, ELLIPSOID):
        return s0, s1, s2
    if kind == HALF_SPACE:
        return 0.0, 0.0, 0.0
    # A capsule is longer than its cylinder by the two caps.
    return s0, s0, s1 + s0


@compiled
def find_windows(
    bodies: Bodies,
    R_CGs: Floats,
    p_CGs: Floats,
    view: Floats,
    size: tuple[int, int],
    body_windows: Windows,
) -> None:
    """Fill the windows of all bodies; meshes have none here. ``size`` is width and height."""
    kinds, shapes, (width, height), (windows, nearest) = (
        bodies.kinds,
        bodies.shapes,
        size,
        body_windows,
    )
    for k in range(len(kinds)):
        hx, hy, hz = half_sizes(kinds[k], shapes[k, 0], shapes[k, 1], shapes[k, 2])
        u0, u1, v0, v1, z = box_window(R_CGs[k], p_CGs[k], hx, hy, hz, view, width, height)
        if kinds[k] == HALF_SPACE:
            u0, u1, v0, v1, z = 0, width, 0, height, view[4]
        windows[k, 0], windows[k, 1], windows[k, 2], windows[k, 3] = u0, u1, v0, v1
        nearest[k] = z


@inlined
def is_behind(nearest: float, depths: Floats) -> bool:
    """Return whether a body, no nearer than ``nearest``, is behind all pixels drawn so far."""
    seen = False
    for i in range(len(depths)):
        seen |= nearest <= depths[i]
    return not seen


@inlined
def scan(kind: int, k: int, bodies: Bodies, seen: Seen, band: Band) -> None:
    """Draw body ``k`` of a ``kind`` that is constant at compile time: one loop for each kind.

    The loop is vectorised: all pixels of a row are computed and written, unless the body is behind
    all of them.
    """
    shape, R, p, view = bodies.shapes[k], seen.R_CGs[k], seen.p_CGs[k], seen.camera
    window, nearest, k = seen.windows[k], seen.nearest[k], signed32(k)
    near, far = view[4], view[5]
    s0, s1, s2 = shape[0], shape[1], shape[2]
    ox = -(R[0, 0] * p[0] + R[1, 0] * p[1] + R[2, 0] * p[2])
    oy = -(R[0, 1] * p[0] + R[1, 1] * p[1] + R[2, 1] * p[2])
    oz = -(R[0, 2] * p[0] + R[1, 2] * p[1] + R[2, 2] * p[2])
    ax, ay, az = R[0, 0], R[0, 1], R[0, 2]
    xs = seen.slopes[window[0] : window[1]]
    begin = max(window[2] - band.first_row, 0)
    end = min(window[3] - band.first_row, len(band.depths))
    for row in range(begin, end):
        y = (row + band.first_row + 0.5 - view[3]) / view[1]
        bx = R[1, 0] * y + R[2, 0]
        by = R[1, 1] * y + R[2, 1]
        bz = R[1, 2] * y + R[2, 2]
        row_depths = band.depths[row, window[0] : window[1]]
        if is_behind(nearest, row_depths):
            continue
        row_owners = band.owners[row, window[0] : window[1]]
        row_facets = band.facets[row, window[0] : window[1]]
        for i in range(len(xs)):
            x, deep, owner = xs[i], row_depths[i], row_owners[i]
            dx, dy, dz = ax * x + bx, ay * x + by, az * x + bz
            t_in, t_out = interval(kind, s0, s1, s2, ox, oy, oz, dx, dy, dz)
            z = t_in if t_in >= near else t_out
            hit = (t_in <= t_out) & (near <= z) & (z <= far)
            first = hit & ((z < deep) | ((z == deep) & (k < owner)))
            row_depths[i] = z if first else deep
            row_owners[i] = k if first else owner
            row_facets[i] = -1 if first else row_facets[i]


@compiled
def draw_primitive(k: int, bodies: Bodies, seen: Seen, band: Band) -> None:
    """Draw body ``k`` into a band.

    Among surfaces at the same depth, that of the body with the lower number is shown, in any order
    of drawing.
    """
    kind = bodies.kinds[k]
    if kind == SPHERE:
        scan(SPHERE, k, bodies, seen, band)
    elif kind == BOX:
        scan(BOX, k, bodies, seen, band)
    elif kind == CAPSULE:
        scan(CAPSULE, k, bodies, seen, band)
    elif kind == CYLINDER:
        scan(CYLINDER, k, bodies, seen, band)
    elif kind == ELLIPSOID:
        scan(ELLIPSOID, k, bodies, seen, band)
    else:
        scan(HALF_SPACE, k, bodies, seen, band)
