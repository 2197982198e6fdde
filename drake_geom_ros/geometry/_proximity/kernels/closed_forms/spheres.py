"""Signed distance of a sphere to any primitive: that of its centre, minus its radius.

The nearest point, and the choice where it is not unique, are those of ``points``; for two
concentric spheres the normal is the x axis of B.
"""

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import Aim, OrientedShape, write
from drake_geom_ros.geometry._proximity.kernels.closed_forms.ellipsoid_point import (
    NearestOnSurface,
)
from drake_geom_ros.geometry._proximity.kernels.closed_forms.points import (
    box_point,
    near_capsule,
    near_cylinder,
    near_ellipsoid,
    near_half_space,
    near_sphere,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    norm,
    rotate,
    scale,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import CLOSED_FORM, SHAPE_RADIUS
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import CLOSED_FORM_ROUNDING, TIE


@inlined
def _centre(R_WB: Floats, p_AB_W: Floats) -> Vector:
    """Return p_BA in B."""
    return unrotate(R_WB, (-p_AB_W[0], -p_AB_W[1], -p_AB_W[2]))


@inlined
def _write(
    out: Floats,
    radius: float,
    R_WB: Floats,
    p_AB_W: Floats,
    size: float,
    nearest: NearestOnSurface,
) -> None:
    """Write the row from the nearest point to A's centre in B's frame."""
    distance, nhat_BA_W = nearest.distance - radius, rotate(R_WB, nearest.grad)
    p_ACb_W = add(vector_at(p_AB_W, 0), rotate(R_WB, nearest.p_GN))
    bound = CLOSED_FORM_ROUNDING * (size + radius)
    p_ACa_W = scale(-radius, nhat_BA_W)
    write(out, distance, nhat_BA_W, p_ACa_W, p_ACb_W, bound, nearest.unique, CLOSED_FORM)


@compiled
def sphere_sphere(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of two spheres."""
    size, nearest = near_sphere(B.shape, _centre(B.R_W, p_AB_W))
    _write(out, A.shape[SHAPE_RADIUS], B.R_W, p_AB_W, size, nearest)


@compiled
def sphere_box(A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats) -> None:
    """Write the signed distance of a sphere and a box."""
    # Not by ``points.near_box``: an intermediate function, even inlined, costs 50 % more.
    q, h = _centre(B.R_W, p_AB_W), vector_at(B.shape, 0)
    size = norm(h) + norm(q)
    _write(out, A.shape[SHAPE_RADIUS], B.R_W, p_AB_W, size, box_point(h, q, TIE * size))


@compiled
def sphere_capsule(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of a sphere and a capsule."""
    size, nearest = near_capsule(B.shape, _centre(B.R_W, p_AB_W))
    _write(out, A.shape[SHAPE_RADIUS], B.R_W, p_AB_W, size, nearest)


@compiled
def sphere_cylinder(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of a sphere and a cylinder."""
    size, nearest = near_cylinder(B.shape, _centre(B.R_W, p_AB_W))
    _write(out, A.shape[SHAPE_RADIUS], B.R_W, p_AB_W, size, nearest)


@compiled
def sphere_ellipsoid(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of a sphere and an ellipsoid."""
    size, nearest = near_ellipsoid(B.shape, _centre(B.R_W, p_AB_W))
    _write(out, A.shape[SHAPE_RADIUS], B.R_W, p_AB_W, size, nearest)


@compiled
def sphere_half_space(
    A: OrientedShape, B: OrientedShape, p_AB_W: Floats, aim: Aim, out: Floats
) -> None:
    """Write the signed distance of a sphere and a half space."""
    size, nearest = near_half_space(B.shape, _centre(B.R_W, p_AB_W))
    _write(out, A.shape[SHAPE_RADIUS], B.R_W, p_AB_W, size, nearest)
