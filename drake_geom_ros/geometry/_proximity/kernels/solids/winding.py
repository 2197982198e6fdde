"""Containment of points in a solid: the generalized winding number.

The sum of the solid angles of all triangles over 4 pi is 1 inside a closed surface and 0 outside
(Van Oosterom & Strackee 1983; Jacobson, Kavan, Sorkine-Hornung, ACM Transactions on Graphics 32
(4), 2013). Triangles far away are seen as one dipole a node (Barill, Dickson, Schmidt, Levin,
Jacobson, ACM Transactions on Graphics 37 (4), 2018), and how far that may be off is added up
beside the sum: where the sum is no farther from 1/2 than that, it is computed again with fewer
dipoles, at last without.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    AREA,
    AREA_VECTOR,
    CENTRE,
    CORNERS,
    MOMENT,
    RADIUS,
    Tree,
    first_of_leaf,
    rounding_of_angle,
    solid_angle,
    tree_of,
)
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import NODE_WIDTH, box_of_node, outside
from drake_geom_ros.geometry._proximity.kernels.trees.walks import DEEPEST, is_leaf
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add_scaled,
    dot,
    norm,
    sub,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Booleans, Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined

# A node is a dipole when it is this many of its radii away.
FIRST_RATIO = 6.0
NEXT_RATIO = 4.0  # times the one before
LAST_RATIO = 100.0  # beyond it none is


# Places on a triangle, as shares of its second and third corner: no simple fractions, so that no
# edges of others are to be expected there.
PLACES = ((0.3141, 0.2718), (0.6059, 0.2847))
ASTRAY = 0.75  # off 1/2: half-way between what touches and a whole body more


@inlined
def next_ratio(ratio: float) -> float:
    """Return the next ratio, for a more exact sum: how many radii away a dipole has to be."""
    return math.inf if ratio > LAST_RATIO else NEXT_RATIO * ratio


@compiled
def dipole(shape: Floats, at: int, q: Vector) -> tuple[float, float, float]:
    """Return (half solid angle, error, radii away) of a node seen from q as a dipole [sr].

    Taylor's theorem about the centre: the derivative of the field r / |r|^3 is at most 2 / |r|^3,
    the second one at most 6 / s^4 at distances s and more. Flat patches have a moment of zero.
    """
    r = sub(vector_at(shape, at + CENTRE), q)
    distance, radius = norm(r), shape[at + RADIUS]
    if distance <= radius:
        return 0.0, math.inf, 0.0
    cube = distance * distance * distance
    nearest = distance - radius
    half = 0.5 * dot(vector_at(shape, at + AREA_VECTOR), r) / cube
    spread = shape[at + AREA] * (radius / nearest) * (radius / nearest)
    error = shape[at + MOMENT] / cube + 1.5 * spread / (nearest * nearest)
    return half, error, distance / radius


@allocating
def winding(
    shape: Floats, tree: Tree, q: Vector, ratio: float, without: int
) -> tuple[float, float]:
    """Return (winding number, error) at q; nodes nearer than ``ratio`` radii are opened.

    Triangle number ``without`` is left out, whose nodes, all around q, are opened. Then the
    error holds the rounding of those near q too. -1: none is left out.
    """
    stack = np.empty(DEEPEST, dtype=np.int64)
    stack[0], top = 0, 1
    total, error = 0.0, 0.0
    while top > 0:
        top -= 1
        k = stack[top]
        half, off, radii = dipole(shape, tree.nodes + NODE_WIDTH * k, q)
        if radii > ratio:
            total += half
            error += off
        elif is_leaf(tree, k):
            leaf = k - (tree.leaves - 1)
            for j in range(first_of_leaf(tree, leaf), first_of_leaf(tree, leaf + 1)):
                if j == without:
                    continue
                at = tree.corners + CORNERS * j
                a, b = sub(vector_at(shape, at), q), sub(vector_at(shape, at + 3), q)
                c = sub(vector_at(shape, at + 6), q)
                total += solid_angle(a, b, c)
                if without >= 0:
                    error += rounding_of_angle(a, b, c)
        else:
            stack[top], stack[top + 1] = 2 * k + 1, 2 * k + 2
            top += 2
    return total / (2.0 * math.pi), error / (2.0 * math.pi)


@compiled
def is_inside(shape: Floats, tree: Tree, q: Vector) -> bool:
    """Return whether q, in the solid's frame, lies inside; on the surface either may be returned.

    The number is 0 or 1, off by the dipoles' error at most, so a sum farther from 1/2 than that is
    decided rightly, and without dipoles only rounding is left: for a triangle it is EPS times the
    square of its length over that of its distance, or of its least width where that is more
    (``rounding_of_angle``). A point may be outside a box by no more than that, times the length.
    """
    box = box_of_node(shape, tree, 0)
    for c in range(3):
        if outside(q[c] - box.middle[c], box.half[c]) > 0.0:
            return False
    ratio = FIRST_RATIO
    while True:
        number, error = winding(shape, tree, q, ratio, -1)
        if abs(number - 0.5) > error or ratio == math.inf:
            return number > 0.5
        ratio = next_ratio(ratio)


@compiled
def is_astray(shape: Floats, tree: Tree, q: Vector, j: int) -> bool:
    """Return whether another body is beneath triangle j, or above it, at its point q.

    Where not, the winding number of all other triangles is 1/2: 1 beneath and 0 above, less or
    more the half that j contributes to either side. Where so, it is 3/2 and more, or -1/2 and
    less. What only touches the triangle at q adds or subtracts less than 1/2, and is not reported.
    """
    ratio = FIRST_RATIO
    while True:
        number, error = winding(shape, tree, q, ratio, j)
        beyond = abs(number - 0.5) - ASTRAY
        if abs(beyond) > error or ratio == math.inf:
            return beyond > error  # among needles rounding may hide it
        ratio = next_ratio(ratio)


@compiled
def find_astray(shape: Floats, triangles: Indices, astray: Booleans) -> None:
    """Write which of the triangles (k,) of a solid, by number, have a point that is astray."""
    tree = tree_of(SOLID, shape)
    for k in range(triangles.size):
        at = tree.corners + CORNERS * triangles[k]
        a, b = vector_at(shape, at), vector_at(shape, at + 3)
        c = vector_at(shape, at + 6)
        ab, ac = sub(b, a), sub(c, a)
        astray[k] = False
        for u, v in PLACES:
            q = add_scaled(add_scaled(a, u, ab), v, ac)
            astray[k] = astray[k] or is_astray(shape, tree, q, triangles[k])
