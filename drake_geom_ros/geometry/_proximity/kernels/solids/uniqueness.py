"""Proofs that the nearest points of a solid are the only ones, so that its distance has a slope.

The distance of two surfaces is the least of those of their leaves, triangles or a core. Of those
that attain it each is of two convex bodies, and has a derivative where their features leave no
room (``features``); so has the least of finitely many, where all attain it with the same points.
Bodies are given as in ``distance``.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import BEYOND_CUTOFF, OVERLAP
from drake_geom_ros.geometry._proximity.kernels.shapes.features import (
    POINT,
    Feature,
    feature_of,
    hold_one_point,
)
from drake_geom_ros.geometry._proximity.kernels.solids.leaves import separation_of_leaves
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    CORNERS,
    NO_TREE,
    Solid,
    SolidPair,
    Tree,
    TreeBody,
    first_of_leaf,
    moved,
    noise_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.winding import is_inside
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import NO_BOX
from drake_geom_ros.geometry._proximity.kernels.trees.walks import next_leaves, walk
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    cross,
    dot,
    norm,
    perpendicular,
    scale,
    sub,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID, SPHERE
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import (
    DISTINCT_NORMALS,
    SAME_WITNESS,
)


@compiled
def feature_of_triangle(
    shape: Floats, tree: Tree, j: int, n: Vector, u: Vector, v: Vector
) -> Feature:
    """Return the corner, edge or face of triangle j that is extreme along the unit n."""
    at, here = tree.corners + CORNERS * j, 0
    for k in range(1, 3):
        if dot(sub(vector_at(shape, at + 3 * k), vector_at(shape, at + 3 * here)), n) > 0.0:
            here = k
    freedom, du, dv = POINT, 0.0, 0.0
    for k in range(1, 3):
        other = at + 3 * ((here + k) % 3)
        edge = sub(vector_at(shape, other), vector_at(shape, at + 3 * here))
        length = norm(edge)
        if abs(dot(edge, n)) <= DISTINCT_NORMALS * length:
            freedom += 1
            du, dv = dot(edge, u) / length, dot(edge, v) / length
    return Feature(freedom, du, dv, 0.0, 0.0, 0.0)


@compiled
def hold_leaves_one_point(A: TreeBody, i: int, B: Solid, j: int, n: Vector) -> bool:
    """Return whether two leaves, apart along n from A to B, have one pair of nearest points."""
    v = perpendicular(n)
    u = cross(v, n)
    if A.kind == SOLID:
        m, x, y = unrotate(A.R, n), unrotate(A.R, u), unrotate(A.R, v)
        feature_A = feature_of_triangle(A.shape, A.tree, i, m, x, y)
    else:
        feature_A = feature_of(A.kind, A.shape, A.R, n, u, v)
    return hold_one_point(feature_A, feature_of_triangle(B.shape, B.tree, j, scale(-1.0, n), u, v))


@allocating
def is_nearest_alone(pair: SolidPair, n: Vector, limit: float) -> tuple[bool, Vector]:
    """Return (alone, b): whether no other points are as near as the nearest, that of B being b.

    They are of A's core and of B's surface. It examines all leaves that are not certified to be
    farther apart than ``limit`` [m], which is no less than the distance. False where rounding
    leaves it open.
    """
    A, B, p, size = pair.A, pair.B, pair.p, pair.size
    pair = SolidPair(A, B, p, size, 0.0, pair.radius)  # as sharp as can be
    path, top = walk(A, B, p), 1
    count, b, slack = 0, p, SAME_WITNESS * size
    while True:
        top, i, j, _ = next_leaves(A, B, p, path, top, limit)
        if i < 0:
            return count > 0, b
        for k in range(first_of_leaf(A.tree, i), first_of_leaf(A.tree, i + 1)):
            for m in range(first_of_leaf(B.tree, j), first_of_leaf(B.tree, j + 1)):
                separation = separation_of_leaves(pair, k, m, n, limit)
                if separation.end == BEYOND_CUTOFF:
                    continue
                if separation.end == OVERLAP or not hold_leaves_one_point(
                    A, k, B, m, separation.n
                ):
                    return False, b
                if count == 0:
                    b, n = separation.b, separation.n
                count += 1
                apart = norm(sub(separation.b, b)) > slack
                if apart or norm(sub(separation.n, n)) > SAME_WITNESS:
                    return False, b


@allocating
def is_separating_move_unique(
    pair: SolidPair, q: Vector, m: Vector, depth: float, error: float
) -> bool:
    """Return whether the move by ``depth`` along the unit m alone separates A from B.

    ``depth`` exceeds the least one by ``error`` at most; A, its core grown by ``radius``, then
    touches B with the point that is at q before. It is proven by the ball of A that touches q from
    within, which has to be out of B, too. Where ``depth`` is less than its radius that takes the
    point of B that touches out of the ball, which no other move of this length does. Else its
    middle x is in B, and a move leads through a point of B's surface that is nearer to x than the
    length of the move less the radius: where only one point is that near, none leads elsewhere.

    Nothing else than q may touch after the move. False where this proves nothing: edges that
    cross, and faces of A that B's corners touch, have no such ball.
    """
    B, size, radius = pair.B, pair.size, pair.radius
    noise, between = noise_of(pair), abs(depth - radius)
    # A move that is longer by the error may end as far beside the end of the shortest.
    aside = 2.0 * math.sqrt(depth * error * max(depth, radius) / max(between, noise))
    if depth >= radius:
        x = add_scaled(q, radius, m)
        point = TreeBody(SPHERE, np.zeros(1), B.identity, NO_TREE, NO_BOX)
        alone, _ = is_nearest_alone(SolidPair(point, B, x, size, 0.0, 0.0), m, between + noise)
        if not alone or not is_inside(B.shape, B.tree, x):
            return False
    aside += DISTINCT_NORMALS * size
    there = moved(pair, scale(depth + aside, m))
    alone, b = is_nearest_alone(there, scale(-1.0, m), radius + 3.0 * aside)
    at_q = norm(sub(b, add_scaled(q, depth, m))) <= SAME_WITNESS * size + aside
    return alone and at_q
