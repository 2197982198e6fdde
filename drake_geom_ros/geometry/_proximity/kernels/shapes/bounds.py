"""Bounds of a shape: its box in World axes, its bounding ball and its inner ball."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import (
    ball_in_hull,
    coarse_hull_at,
    end_of_header,
    farthest_along_axes,
    farthest_vertex,
    hull_defect,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import (
    centre_at,
    is_map,
    map_tree_of,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import bounding_radius
from drake_geom_ros.geometry._proximity.kernels.vectors import dot, norm, rotate, unrotate
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    HALF_LENGTH,
    HALF_SPACE,
    SHAPE_RADIUS,
    SOLID,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part

Floats = NDArray[np.float64]


class PosedShape(NamedTuple):
    """A shape, its orientation, and the radius [m] of a ball about Go that lies in it."""

    kind: int
    shape: Floats
    R_WG: Floats
    inner_radius: float


@inlined
def has_hull(shape_type: int) -> bool:
    """Return whether the shape's parameters begin with the vertices of its hull."""
    return shape_type == CONVEX or shape_type == SOLID or is_map(shape_type)


@inlined
def support_value(shape_type: int, shape: Floats, n_G: Vector) -> float:
    """Return the support value h(n) [m] from Go, n a unit vector in G; infinite for half spaces.

    All shapes except hulls are symmetric about Go: h(-n) is equal. A solid has that of its hull.
    """
    x, y, z = abs(n_G[0]), abs(n_G[1]), abs(n_G[2])
    if shape_type == SPHERE:
        return shape[SHAPE_RADIUS]
    if shape_type == BOX:
        return x * shape[0] + y * shape[1] + z * shape[2]
    if shape_type == CAPSULE:
        return shape[SHAPE_RADIUS] + z * shape[HALF_LENGTH]
    if shape_type == CYLINDER:
        return shape[SHAPE_RADIUS] * math.sqrt(x * x + y * y) + z * shape[HALF_LENGTH]
    if shape_type == ELLIPSOID:
        return norm((x * shape[0], y * shape[1], z * shape[2]))
    if has_hull(shape_type):
        farthest = farthest_vertex(shape, n_G[0], n_G[1], n_G[2])
        return dot(n_G, farthest) + hull_defect(shape)
    return math.inf


@inlined
def _box_of_hull(shape: Floats, R_WG: Floats) -> Vector:
    """Return half extents [m] of a box around a hull, from its coarse hull and reach if any.

    A scan of thousands of vertices took half of the time of a state of two arms.
    """
    at = coarse_hull_at(shape)
    if at == 0:
        return farthest_along_axes(shape, R_WG)
    coarse, reach = part(shape, at + 1, end_of_header(shape, at + 1)), shape[at]
    x, y, z = farthest_along_axes(coarse, R_WG)
    return x + reach, y + reach, z + reach


@compiled
def box_half_extents(shape_type: int, shape: Floats, R_WG: Floats, half_extents: Floats) -> None:
    """Write the half extents (3,) [m] of a World-aligned box about Go around the shape.

    It is the smallest one, except of a hull with a coarse hull: see ``_box_of_hull``.
    """
    if shape_type == CONVEX or shape_type == SOLID:
        half_extents[0], half_extents[1], half_extents[2] = _box_of_hull(shape, R_WG)
        return
    if is_map(shape_type):
        half_extents[0], half_extents[1], half_extents[2] = farthest_along_axes(shape, R_WG)
        return
    for k in range(3):
        e_G = (R_WG[k, 0], R_WG[k, 1], R_WG[k, 2])
        half_extents[k] = support_value(shape_type, shape, e_G)


@compiled
def outer_radius(shape_type: int, shape: Floats) -> float:
    """Return the largest distance [m] of a point of the shape from Go; infinite for a plane."""
    return math.inf if shape_type == HALF_SPACE else bounding_radius(shape_type, shape)


@compiled
def inner_radius(shape_type: int, shape: Floats) -> float:
    """Return the radius of a ball about Go that lies in the shape; 0 for hulls and solids."""
    if shape_type == SPHERE or shape_type == CAPSULE:
        return shape[SHAPE_RADIUS]
    if shape_type == BOX or shape_type == ELLIPSOID:
        return min(shape[0], shape[1], shape[2])
    if shape_type == CYLINDER:
        return min(shape[SHAPE_RADIUS], shape[HALF_LENGTH])
    return 0.0


@compiled
def _put_radii(
    types: Indices, starts: Indices, pool: Floats, outer: Floats, inner: Floats
) -> None:
    """Write both radii of each shape."""
    for k in range(types.size):
        shape = part(pool, starts[k], starts[k + 1])
        outer[k] = outer_radius(types[k], shape)
        inner[k] = inner_radius(types[k], shape)


def shape_radii(types: Indices, starts: Indices, pool: Floats) -> tuple[Floats, Floats]:
    """Return outer and inner radii (n,), (n,) [m] about each Go."""
    outer, inner = np.empty(types.size), np.empty(types.size)
    _put_radii(types, starts, pool, outer, inner)
    return outer, inner


@inlined
def point_inside(shape_type: int, shape: Floats, R_WG: Floats, n_W: Vector) -> Vector:
    """Return the centre of the inner ball, from Go in World: Go, or for a hull a vertex along n.

    The origin of a hull or solid may lie outside it. The hull of a map is the box around it, so
    its inner ball is in its first cell.
    """
    if is_map(shape_type):
        return rotate(R_WG, centre_at(shape, map_tree_of(shape_type, shape), 0))
    if not has_hull(shape_type):
        return 0.0, 0.0, 0.0
    x, y, z = unrotate(R_WG, n_W)
    return rotate(R_WG, farthest_vertex(shape, x, y, z))


@compiled
def _put_balls_in_hulls(
    types: Indices, starts: Indices, pool: Floats, centres: Floats, radii: Floats
) -> None:
    """Write the centre and radius of the packed ball of each hull."""
    for k in range(types.size):
        if types[k] == CONVEX:
            centre, radii[k] = ball_in_hull(part(pool, starts[k], starts[k + 1]))
            for c in range(3):
                centres[k, c] = centre[c]


def balls_inside(
    types: Indices, starts: Indices, pool: Floats, inner: Floats
) -> tuple[Floats, Floats]:
    """Return centres (n, 3) from Go, in G, and radii (n,) [m] of balls in shapes; radius 0: none.

    ``inner`` are the inner radii of ``shape_radii``.
    """
    centres, radii = np.zeros((types.size, 3)), inner.copy()
    if (types == CONVEX).any():
        _put_balls_in_hulls(types, starts, pool, centres, radii)
    return centres, radii
