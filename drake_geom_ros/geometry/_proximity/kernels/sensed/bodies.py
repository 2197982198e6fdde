"""A pair with a map: what the walks know of A and of B, and bounds of how far parts are apart.

B is a map, and A is one too or any other shape: of that its *core* is a leaf of its own, in a box
of its axes, grown by a ball (``shapes.supports``). Bounds are computed in B's axes, from Bo.
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
    """A body as walks take it: its leaves are cells, or it is one leaf itself."""

    kind: int
    shape: Floats
    R_W: Floats
    leaf_kind: int
    leaf: Floats  # parameters of a leaf
    reach: float  # [m] of a leaf from its centre
    tree: MapTree
    box: NodeBox  # of the core, if it is no map
    half: float  # [m] that the box of a node is grown by on each side, ...
    radius: float  # [m] ... and all around


class MapPair(NamedTuple):
    """A, and a map B; R is the orientation of A in B."""

    A: MapBody
    B: MapBody
    R: Floats
    address: Address  # of the kernel for a leaf of A and a leaf of B
    aim: Aim
    size: float  # [m] to which rounding is relative


@inlined
def noise_of(pair: MapPair) -> float:
    """Return what rounding may make of a distance [m]."""
    return ROUNDING * EPS * pair.size


@inlined
def towards(p: Vector) -> Vector:
    """Return the unit vector towards a point; that of x where it is no way off."""
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
    """Return a pair whose origins are as far as ``away`` [m] apart, at most."""
    mine, its = body_of(A.kind, A.shape, A.R_W), body_of(B.kind, B.shape, B.R_W)
    R = np.empty((3, 3))
    for k in range(3):
        R[0, k], R[1, k], R[2, k] = unrotate(B.R_W, column(A.R_W, k))
    size = bounding_radius(B.kind, B.shape) + away
    if A.kind != HALF_SPACE:
        size += bounding_radius(A.kind, A.shape)
    return MapPair(mine, its, R, address, aim, size)


@allocating
def moved_away(pair: MapPair, away: float) -> MapPair:
    """Return a pair of origins at one place as one whose origins are so far [m] apart."""
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
    """Return the origin of leaf i, in the body's frame; a body that is no map is at its own."""
    return (0.0, 0.0, 0.0) if body.tree.leaves == 0 else centre_at(body.shape, body.tree, i)


@inlined
def _reach_along(n: Vector, h: Vector) -> float:
    """Return how far a box of half size h reaches along n from its middle."""
    return abs(n[0]) * h[0] + abs(n[1]) * h[1] + abs(n[2]) * h[2]


@inlined
def _above_plane(R: Floats, p: Vector, box: NodeBox) -> float:
    """Return how far a box in B is above the half space A that stands at p, turned by R."""
    n = column(R, 2)
    return dot(n, sub(box.middle, p)) - _reach_along(n, box.half)


@inlined
def _beyond_faces(d: Vector, R: Floats, h: Vector, k: Vector) -> Vector:
    """Return the gaps along the faces of a box of half size k, of one of half size h turned by R.

    Negative where they overlap; d is the middle of the second, from that of the first.
    """
    return (
        abs(d[0]) - k[0] - (abs(R[0, 0]) * h[0] + abs(R[0, 1]) * h[1] + abs(R[0, 2]) * h[2]),
        abs(d[1]) - k[1] - (abs(R[1, 0]) * h[0] + abs(R[1, 1]) * h[1] + abs(R[1, 2]) * h[2]),
        abs(d[2]) - k[2] - (abs(R[2, 0]) * h[0] + abs(R[2, 1]) * h[1] + abs(R[2, 2]) * h[2]),
    )


@inlined
def _length_beyond(gaps: Vector) -> float:
    """Return how far boxes are apart by the gaps along three faces; negative: the largest."""
    most = max(gaps[0], gaps[1], gaps[2])
    if most <= 0.0:
        return most
    return norm((max(gaps[0], 0.0), max(gaps[1], 0.0), max(gaps[2], 0.0)))


@inlined
def _way_from(is_round: bool, h: Vector, q: Vector) -> Vector:
    """Return the way to q from what is nearest in a box of half size h, or its cylinder along z.

    Part by part outwards along normals, so that no rounding turns it, however short it is. What is
    nearest then is also what is farthest along the way, of the box or cylinder.
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
    """What bounds of a pair need, few words to hand over: Ao is at p in B, A is turned by R."""

    kind_A: int
    R: Floats
    p: Vector
    radius: float  # [m] that both are grown by


@allocating
def between(pair: MapPair, p: Vector) -> Between:
    """Return that of a pair whose Bo is at p from Ao in World axes."""
    p_BA = scale(-1.0, unrotate(pair.B.R_W, p))
    return Between(pair.A.kind, pair.R, p_BA, pair.A.radius + pair.B.radius)


@inlined
def least_apart(at: Between, box_A: NodeBox, box_B: NodeBox, limit: float) -> float:
    """Return a lower bound [m] of the signed distance of what is in two boxes, of A and of B.

    What lies in a body is no nearer, and no deeper, than that body, and a gap along any direction,
    a negative one too, is never more than the signed distance. So directions are tried: normals of
    faces first, the way from A's box, or cylinder, to the middle of the other last, which of a
    small box misses little. A few roundings of the pair's size may be missing, less than
    ``noise_of``. Of what is beyond the limit [m] less is told.
    """
    R, p, k = at.R, at.p, box_B.half
    if at.kind_A == SPHERE:  # whichever way it is turned
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
