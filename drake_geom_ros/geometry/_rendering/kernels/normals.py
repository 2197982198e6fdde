"""Unit normals of the pixels of a row, in C and towards the camera."""

import math

from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CYLINDER, ELLIPSOID, SPHERE
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Integers32, Vector
from drake_geom_ros.geometry._rendering.compiled import compiled, inlined
from drake_geom_ros.geometry._rendering.kernels.rays import normal
from drake_geom_ros.geometry._rendering.kernels.records import Normals


@inlined
def facet_normal(corners: Integers32, p_CVs: Floats) -> Vector:
    """Return a triangle's normal in C, of any length."""
    a, b, c = corners[0], corners[1], corners[2]
    ex, ey, ez = p_CVs[b, 0] - p_CVs[a, 0], p_CVs[b, 1] - p_CVs[a, 1], p_CVs[b, 2] - p_CVs[a, 2]
    gx, gy, gz = p_CVs[c, 0] - p_CVs[a, 0], p_CVs[c, 1] - p_CVs[a, 1], p_CVs[c, 2] - p_CVs[a, 2]
    return ey * gz - ez * gy, ez * gx - ex * gz, ex * gy - ey * gx


@inlined
def towards_camera(nx: float, ny: float, nz: float, x: float, y: float) -> Vector:
    """Return the unit normal that points against the ray (x, y, 1)."""
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    length = -length if nx * x + ny * y + nz > 0.0 else length
    flat = length == 0.0
    return (
        0.0 if flat else nx / length,
        0.0 if flat else ny / length,
        -1.0 if flat else nz / length,
    )


@compiled
def flat_normals(
    nx: float, ny: float, nz: float, y: float, slopes: Floats, normals: Normals
) -> None:
    """Fill the normals, (n,) each, of pixels that show one side of a plane."""
    xs, ys, zs = normals
    nx, ny, nz = towards_camera(nx, ny, nz, slopes[0], y)
    for i in range(len(slopes)):
        xs[i], ys[i], zs[i] = nx, ny, nz


@inlined
def round_normals(
    kind: int,
    shape: Floats,
    R: Floats,
    p: Floats,
    y: float,
    slopes: Floats,
    depths: Floats,
    normals: Normals,
) -> None:
    """Fill the normals, (n,) each, of pixels that show a ``kind`` that the compiler knows."""
    xs, ys, zs = normals
    s0, s1, s2 = shape[0], shape[1], shape[2]
    ax, ay, az = R[0, 0], R[0, 1], R[0, 2]
    bx, by, bz = R[1, 0], R[1, 1], R[1, 2]
    cx, cy, cz = R[2, 0], R[2, 1], R[2, 2]
    px, py, pz = p[0], p[1], p[2]
    # Copied to read one array fewer: LLVM checks four arrays for overlap, but not five, and then
    # does not vectorise the loop.
    for i in range(len(slopes)):
        zs[i] = depths[i]
    for i in range(len(slopes)):
        x, z = slopes[i], zs[i]
        dx, dy, dz = x * z - px, y * z - py, z - pz
        gx = ax * dx + bx * dy + cx * dz
        gy = ay * dx + by * dy + cy * dz
        gz = az * dx + bz * dy + cz * dz
        mx, my, mz = normal(kind, s0, s1, s2, gx, gy, gz)
        nx = ax * mx + ay * my + az * mz
        ny = bx * mx + by * my + bz * mz
        nz = cx * mx + cy * my + cz * mz
        xs[i], ys[i], zs[i] = towards_camera(nx, ny, nz, x, y)


@compiled
def primitive_normals(
    kind: int,
    shape: Floats,
    R: Floats,
    p: Floats,
    y: float,
    slopes: Floats,
    depths: Floats,
    normals: Normals,
) -> None:
    """Fill the normals, (n,) each, of pixels that show a primitive."""
    if kind == SPHERE:
        round_normals(SPHERE, shape, R, p, y, slopes, depths, normals)
    elif kind == BOX:
        round_normals(BOX, shape, R, p, y, slopes, depths, normals)
    elif kind == CAPSULE:
        round_normals(CAPSULE, shape, R, p, y, slopes, depths, normals)
    elif kind == CYLINDER:
        round_normals(CYLINDER, shape, R, p, y, slopes, depths, normals)
    elif kind == ELLIPSOID:
        round_normals(ELLIPSOID, shape, R, p, y, slopes, depths, normals)
    else:
        flat_normals(R[0, 2], R[1, 2], R[2, 2], y, slopes, normals)


@compiled
def facet_normals(
    facets: Integers32,
    triangles: Integers32,
    p_CVs: Floats,
    y: float,
    slopes: Floats,
    normals: Normals,
) -> None:
    """Fill the normals, (n,) each, of pixels that show triangles ``facets`` (n,) of a mesh."""
    xs, ys, zs = normals
    last = -1
    nx, ny, nz = 0.0, 0.0, 0.0
    for i in range(len(slopes)):
        if facets[i] != last:
            last = facets[i]
            nx, ny, nz = facet_normal(triangles[last], p_CVs)
            nx, ny, nz = towards_camera(nx, ny, nz, slopes[i], y)
        xs[i], ys[i], zs[i] = nx, ny, nz
