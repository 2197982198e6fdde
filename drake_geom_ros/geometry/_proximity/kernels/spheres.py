"""Sphere against everything: the signed distance of its centre, less its radius.

The nearest point and the choices where it is not unique are those of ``points``; for two
concentric spheres the normal is the x axis of B.
"""

from drake_geom_ros.geometry._proximity.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.calling import write
from drake_geom_ros.geometry._proximity.kernels.ellipsoid_point import ellipsoid_point
from drake_geom_ros.geometry._proximity.kernels.points import (
    box_point,
    capsule_point,
    cylinder_point,
    half_space_point,
    sphere_point,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import add, norm, rotate, scale, unrotate
from drake_geom_ros.geometry._proximity.kinds import CLOSED_FORM
from drake_geom_ros.geometry._proximity.tolerances import CLOSED_FORM_ROUNDING, TIE


@inlined
def _centre(R_WB, p_AB_W):
    """Return p_BA in B."""
    return unrotate(R_WB, (-p_AB_W[0], -p_AB_W[1], -p_AB_W[2]))


@inlined
def _write(out, radius, R_WB, p_AB_W, extent, result):
    """Fill the row from the point query of A's centre in B's frame."""
    distance, grad, p_BCb, unique = result
    nhat_BA_W = rotate(R_WB, grad)
    p_ACb_W = add((p_AB_W[0], p_AB_W[1], p_AB_W[2]), rotate(R_WB, p_BCb))
    bound = CLOSED_FORM_ROUNDING * (extent + radius)
    p_ACa_W = scale(-radius, nhat_BA_W)
    write(out, distance - radius, nhat_BA_W, p_ACa_W, p_ACb_W, bound, unique, CLOSED_FORM)


@compiled
def sphere_sphere(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB_W, tolerance, cutoff, out):
    """Signed distance of two spheres."""
    q = _centre(R_WB, p_AB_W)
    extent = shape_B[0] + norm(q)
    result = sphere_point(shape_B[0], q, TIE * extent)
    _write(out, shape_A[0], R_WB, p_AB_W, extent, result)


@compiled
def sphere_box(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB_W, tolerance, cutoff, out):
    """Signed distance of a sphere and a box."""
    q, h = _centre(R_WB, p_AB_W), (shape_B[0], shape_B[1], shape_B[2])
    extent = norm(h) + norm(q)
    _write(out, shape_A[0], R_WB, p_AB_W, extent, box_point(h, q, TIE * extent))


@compiled
def sphere_capsule(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB_W, tolerance, cutoff, out):
    """Signed distance of a sphere and a capsule."""
    q = _centre(R_WB, p_AB_W)
    extent = shape_B[0] + shape_B[1] + norm(q)
    result = capsule_point(shape_B[0], shape_B[1], q, TIE * extent)
    _write(out, shape_A[0], R_WB, p_AB_W, extent, result)


@compiled
def sphere_cylinder(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB_W, tolerance, cutoff, out):
    """Signed distance of a sphere and a cylinder."""
    q = _centre(R_WB, p_AB_W)
    extent = shape_B[0] + shape_B[1] + norm(q)
    result = cylinder_point(shape_B[0], shape_B[1], q, TIE * extent)
    _write(out, shape_A[0], R_WB, p_AB_W, extent, result)


@compiled
def sphere_ellipsoid(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB_W, tolerance, cutoff, out):
    """Signed distance of a sphere and an ellipsoid."""
    q, e = _centre(R_WB, p_AB_W), (shape_B[0], shape_B[1], shape_B[2])
    extent = max(e) + norm(q)
    _write(out, shape_A[0], R_WB, p_AB_W, extent, ellipsoid_point(e, q, TIE * extent))


@compiled
def sphere_half_space(
    kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p_AB_W, tolerance, cutoff, out
):
    """Signed distance of a sphere and a half space."""
    q = _centre(R_WB, p_AB_W)
    _write(out, shape_A[0], R_WB, p_AB_W, norm(q), half_space_point(q))
