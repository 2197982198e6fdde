"""Bodies of a pair with a map, and lower bounds of the distances of their parts.

B is a map. A is a map, too, or any other shape, whose *core* is then a single leaf, in a box along
its axes, grown by a ball (``shapes.supports``). Bounds are computed in B's axes, from Bo.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import Aim, OrientedShape
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import hull_defect
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import (
    NODE,
    MapTree,
    centre_at,
    map_tree_of,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import (
    bounding_radius,
    core_radius,
)
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import NodeBox, box_between
from drake_geom_ros.geometry._proximity.kernels.trees.core_boxes import box_of_core
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    column,
    dot,
    norm,
    rotate,
    scale,
    sub,
    unit,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CONVEX,
    CYLINDER,
    HALF_SPACE,
    OCCUPIED_CELLS,
    SOLID,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.runtime.addresses import Address
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined
from drake_geom_ros.geometry._proximity.tolerances import EPS, ROUNDING


class MapBody(NamedTuple):
    """A body for tree walks: its leaves are cells, or it is a single leaf."""

    kind: int
    shape: Floats
    R_W: Floats
    leaf_kind: int
    leaf: Floats  # parameters of a leaf
    reach: float  # [m] radius of a leaf about its centre
    tree: MapTree
    box: NodeBox  # of the core, if it is no map
    half: float  # [m] growth of the box of a node on each side, ...
    radius: float  # [m] ... and of all by a ball


class MapPair(NamedTuple):
    """A body A and a map B; R is the orientation of A in B."""

    A: MapBody
    B: MapBody
    R: Floats
    address: Address  # of the kernel for a leaf of A and a leaf of B
    aim: Aim
    size: float  # [m] to which rounding is relative


@inlined
def noise_of(pair: MapPair) -> float:
    """Return a bound of the rounding of a distance [m]."""
    return ROUNDING * EPS * pair.size


@inlined
def towards(p: Vector) -> Vector:
    """Return the unit vector towards a point; +x for the origin."""
    n = unit(p)
    return n if dot(n, n) > 0.5 else (1.0, 0.0, 0.0)


@allocating
def body_of(kind: int, shape: Floats, R_W: Floats) -> MapBody:
    """Return a shape as a body of a pair."""
    tree = map_tree_of(kind, shape)
    size = tree.size
    if tree.leaves == 0:
        box, radius, half = NodeBox((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)), 0.0, 0.0
        reach = 0.0
        if kind != HALF_SPACE:
            box = box_of_core(CONVEX if kind == SOLID else kind, shape)
            radius = core_radius(kind, shape)
            reach = bounding_radius(kind, shape)
        if kind == CONVEX or kind == SOLID:
            half = hull_defect(shape)
        return MapBody(kind, shape, R_W, kind, shape, reach, tree, box, half, radius)
    box = NodeBox((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    if kind == OCCUPIED_CELLS:
        reach = math.sqrt(3.0) * size
        return MapBody(kind, shape, R_W, BOX, np.full(3, size), reach, tree, box, size, 0.0)
    return MapBody(kind, shape, R_W, SPHERE, np.full(1, size), size, tree, box, 0.0, size)


@allocating
def map_pair(
    address: Address, A: OrientedShape, B: OrientedShape, aim: Aim, away: float
) -> MapPair:
    """Return a pair whose origins are at most ``away`` [m] apart."""
    body_A, body_B = body_of(A.kind, A.shape, A.R_W), body_of(B.kind, B.shape, B.R_W)
    R = np.empty((3, 3))
    for k in range(3):
        R[0, k], R[1, k], R[2, k] = unrotate(B.R_W, column(A.R_W, k))
    size = bounding_radius(B.kind, B.shape) + away
    if A.kind != HALF_SPACE:
        size += bounding_radius(A.kind, A.shape)
    return MapPair(body_A, body_B, R, address, aim, size)


@allocating
def moved_away(pair: MapPair, away: float) -> MapPair:
    """Return a copy of a pair with coincident origins whose origins are ``away`` [m] apart."""
    return MapPair(pair.A, pair.B, pair.R, pair.address, pair.aim, pair.size + away)


@inlined
def box_of_node(body: MapBody, k: int) -> NodeBox:
    """Return the box of node k, or that of the core, in the body's frame."""
    if body.tree.leaves == 0:
        box = body.box
    else:
        at = body.tree.nodes + NODE * k
        box = box_between(vector_at(body.shape, at), vector_at(body.shape, at + 3))
    h = body.half
    return NodeBox(box.middle, (box.half[0] + h, box.half[1] + h, box.half[2] + h))


@inlined
def box_of_cell(body: MapBody, i: int) -> NodeBox:
    """Return the box of cell i, or that of the core, in the body's frame."""
    h = body.half
    if body.tree.leaves == 0:
        box = body.box
        return NodeBox(box.middle, (box.half[0] + h, box.half[1] + h, box.half[2] + h))
    return NodeBox(centre_at(body.shape, body.tree, i), (h, h, h))


@inlined
def centre_of(body: MapBody, i: int) -> Vector:
    """Return the origin of leaf i in the body's frame; 0 for a body that is no map."""
    return (0.0, 0.0, 0.0) if body.tree.leaves == 0 else centre_at(body.shape, body.tree, i)


@inlined
def _reach_along(n: Vector, h: Vector) -> float:
    """Return the support value of a box of half size h along n, from its centre."""
    return abs(n[0]) * h[0] + abs(n[1]) * h[1] + abs(n[2]) * h[2]


@inlined
def _above_plane(R: Floats, p: Vector, box: NodeBox) -> float:
    """Return the height of a box in B above the half space A, posed by p and R."""
    n = column(R, 2)
    return dot(n, sub(box.middle, p)) - _reach_along(n, box.half)


@inlined
def _beyond_faces(d: Vector, R: Floats, h: Vector, k: Vector) -> Vector:
    """Return the gaps of two boxes along the face normals of one, the other turned by R.

    The first has half size k, the second h; d is from the first's centre. Negative: overlap.
    """
    return (
        abs(d[0]) - k[0] - (abs(R[0, 0]) * h[0] + abs(R[0, 1]) * h[1] + abs(R[0, 2]) * h[2]),
        abs(d[1]) - k[1] - (abs(R[1, 0]) * h[0] + abs(R[1, 1]) * h[1] + abs(R[1, 2]) * h[2]),
        abs(d[2]) - k[2] - (abs(R[2, 0]) * h[0] + abs(R[2, 1]) * h[1] + abs(R[2, 2]) * h[2]),
    )


@inlined
def _length_beyond(gaps: Vector) -> float:
    """Return the separation of boxes from the gaps along three faces; the largest if negative."""
    most = max(gaps[0], gaps[1], gaps[2])
    if most <= 0.0:
        return most
    return norm((max(gaps[0], 0.0), max(gaps[1], 0.0), max(gaps[2], 0.0)))


@inlined
def _way_from(is_round: bool, h: Vector, q: Vector) -> Vector:
    """Return the vector to q from the nearest point of a box of half size h, or cylinder.

    It is computed by components outwards along normals, so that rounding does not turn it, even if
    it is short. The nearest point is then the support point of the box or cylinder along it.
    """
    z = math.copysign(max(abs(q[2]) - h[2], 0.0), q[2])
    if is_round:
        rho = norm((q[0], q[1], 0.0))
        barrel = max(rho - h[0], 0.0)
        s = barrel / rho if barrel > 0.0 else 0.0
        return (s * q[0], s * q[1], z)
    return (
        math.copysign(max(abs(q[0]) - h[0], 0.0), q[0]),
        math.copysign(max(abs(q[1]) - h[1], 0.0), q[1]),
        z,
    )


class Between(NamedTuple):
    """Relative pose of a pair for its bounds: Ao is at p in B, A is turned by R."""

    kind_A: int
    R: Floats
    p: Vector
    radius: float  # [m] by which both are grown


@allocating
def between(pair: MapPair, p: Vector) -> Between:
    """Return the relative pose of a pair whose Bo is at p from Ao in World axes."""
    p_BA = scale(-1.0, unrotate(pair.B.R_W, p))
    return Between(pair.A.kind, pair.R, p_BA, pair.A.radius + pair.B.radius)


@inlined
def least_apart(at: Between, box_A: NodeBox, box_B: NodeBox, limit: float) -> float:
    """Return a lower bound [m] of the signed distance of the contents of a box of A and one of B.

    The content of a box is no nearer, and no deeper, than the box, and a gap along any direction,
    even a negative one, never exceeds the signed distance. So several directions are tried: face
    normals first, and last the direction from A's box, or cylinder, to the centre of B's box,
    which is nearly exact for a small box. A few roundings of the pair's size are not subtracted,
    less than ``noise_of``. Beyond the limit [m] the bound may be less sharp.
    """
    R, p, k = at.R, at.p, box_B.half
    if at.kind_A == SPHERE:  # its orientation does not matter
        d = sub(p, box_B.middle)
        gaps = (abs(d[0]) - k[0], abs(d[1]) - k[1], abs(d[2]) - k[2])
        return _length_beyond(gaps) - at.radius
    if at.kind_A == HALF_SPACE:
        return _above_plane(R, p, box_B) - at.radius
    d, h = sub(add(rotate(R, box_A.middle), p), box_B.middle), box_A.half
    in_B = _length_beyond(_beyond_faces(d, R, h, k)) - at.radius
    if in_B > limit:
        return in_B
    d_A = unrotate(R, d)
    in_A = (
        abs(d_A[0]) - h[0] - (abs(R[0, 0]) * k[0] + abs(R[1, 0]) * k[1] + abs(R[2, 0]) * k[2]),
        abs(d_A[1]) - h[1] - (abs(R[0, 1]) * k[0] + abs(R[1, 1]) * k[1] + abs(R[2, 1]) * k[2]),
        abs(d_A[2]) - h[2] - (abs(R[0, 2]) * k[0] + abs(R[1, 2]) * k[1] + abs(R[2, 2]) * k[2]),
    )
    faces = max(in_B, _length_beyond(in_A) - at.radius)
    if faces > limit:
        return faces
    v = _way_from(at.kind_A == CYLINDER, h, d_A)
    length = norm(v)
    if length == 0.0:
        return faces
    n = rotate(R, scale(1.0 / length, v))
    return max(faces, length - _reach_along(n, k) - at.radius)
