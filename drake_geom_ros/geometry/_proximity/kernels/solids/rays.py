"""Containment of places in a solid, decided without error by the triangles that a ray crosses.

Along a ray from a place to beyond a closed surface, triangles that it leaves by count 1 and those
that it enters by -1: the sum is 1 within and 0 outside. Where a ray meets an edge another one is
sent. The solid is posed as ``places`` has it, and so is the place; no sign is guessed (``signs``).
"""

from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.solids.signs import (
    Place,
    Triangle,
    side,
    two_product,
    two_sum,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import CORNERS, Tree, first_of_leaf
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import NodeBox, box_of_node
from drake_geom_ros.geometry._proximity.kernels.trees.walks import DEEPEST, Floats, is_leaf
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    add_scaled,
    norm,
    rotate,
    sub,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import EPS, ROUNDING

# Where a place is.
OUTSIDE = 0
INSIDE = 1
UNDECIDED = 2  # on the surface, or all rays met edges

# Directions of rays, of any length: no two components have a simple ratio, where edges are not to
# be expected.
RAYS = (
    (0.3711, 0.2237, 0.9013),
    (-0.2913, 0.8641, 0.4117),
    (0.9137, -0.3371, 0.2267),
    (-0.6131, -0.5437, -0.5729),
    (0.4721, 0.7883, -0.3947),
)
# Places on a triangle, in shares of 1/32 of its corners: at no simple fractions, like rays.
PLACES = ((11.0, 13.0, 8.0), (7.0, 9.0, 16.0), (17.0, 5.0, 10.0))


class Posed(NamedTuple):
    """A solid's triangles, turned by R and moved by p: to the last bit where R only swaps axes.

    Elsewhere corners are off by ``off`` [m].
    """

    shape: Floats
    tree: Tree
    R: Floats
    p: Vector
    off: float


@compiled
def swaps_axes(R: Floats) -> bool:
    """Return whether a rotation takes axes to axes: it rounds nothing."""
    for i in range(3):
        for j in range(3):
            if R[i, j] != 0.0 and abs(R[i, j]) != 1.0:
                return False
    return True


@inlined
def place_of(posed: Posed, at: int) -> Place:
    """Return the place of the point (3,) that is at ``at`` in the parameters of a posed solid."""
    v = rotate(posed.R, vector_at(posed.shape, at))
    x, dx = two_sum(v[0], posed.p[0])
    y, dy = two_sum(v[1], posed.p[1])
    z, dz = two_sum(v[2], posed.p[2])
    return x, y, z, dx, dy, dz


@inlined
def triangle_of(posed: Posed, j: int) -> Triangle:
    """Return the places of the corners of triangle j."""
    at = posed.tree.corners + CORNERS * j
    return place_of(posed, at), place_of(posed, at + 3), place_of(posed, at + 6)


@inlined
def weighed(
    a: Place,
    b: Place,
    c: Place,
    shares: Vector,
    k: int,
) -> tuple[float, float]:
    """Return coordinate k of ``place_on``, and its rounding error."""
    x, dx = two_product(shares[0], a[k])
    y, dy = two_product(shares[1], b[k])
    z, dz = two_product(shares[2], c[k])
    x, ex = two_sum(x, y)
    x, ez = two_sum(x, z)
    rest = shares[0] * a[k + 3] + shares[1] * b[k + 3] + shares[2] * c[k + 3]
    return two_sum(x / 32.0, (ex + ez + dx + dy + dz + rest) / 32.0)


@compiled
def place_on(
    T: Triangle,
    shares: Vector,
) -> Place:
    """Return the place on a triangle that has these shares of its corners, to 100 bits."""
    a, b, c = T
    x, dx = weighed(a, b, c, shares, 0)
    y, dy = weighed(a, b, c, shares, 1)
    z, dz = weighed(a, b, c, shares, 2)
    return x, y, z, dx, dy, dz


@compiled
def misses_box(box: NodeBox, q: Vector, d: Vector, slack: float) -> bool:
    """Return whether the segment from q to q + d may be farther than ``slack`` from a box."""
    first, last = 0.0, 1.0
    for k in range(3):
        low, high = box.middle[k] - box.half[k] - slack, box.middle[k] + box.half[k] + slack
        if d[k] == 0.0:
            if q[k] < low or q[k] > high:
                return True
            continue
        s, t = (low - q[k]) / d[k], (high - q[k]) / d[k]
        first, last = max(first, min(s, t)), min(last, max(s, t))
    return first > last + ROUNDING * EPS


@compiled
def through(
    T: Triangle,
    q: Place,
    far: Place,
    off: float,
) -> tuple[bool, int]:
    """Return (is_decided, count): the segment from q to ``far`` leaves by T (1), enters (-1) or 0.

    It is not decided where the segment meets an edge, or q is on T.
    """
    a, b, c = T
    first, second = side(q, far, a, b, off), side(q, far, b, c, off)
    if first * second < 0:
        return True, 0
    third = side(q, far, c, a, off)
    if first * third < 0 or second * third < 0:
        return True, 0
    here, there = side(a, b, c, q, off), side(a, b, c, far, off)
    if here * there > 0:
        return True, 0
    if first == 0 or second == 0 or third == 0 or here == 0 or there == 0:
        return False, 0
    return True, there


@allocating
def count_through(posed: Posed, q: Place, d: Vector) -> tuple[bool, int]:
    """Return (is_decided, count) of all triangles that the segment from q to q + d crosses."""
    stack = np.empty(DEEPEST, dtype=np.int64)
    stack[0], top, count = 0, 1, 0
    shape, tree = posed.shape, posed.tree
    start = unrotate(posed.R, sub((q[0], q[1], q[2]), posed.p))
    along = unrotate(posed.R, d)
    slack = posed.off + ROUNDING * EPS * (norm((q[0], q[1], q[2])) + norm(posed.p) + norm(d))
    far: Place = (q[0] + d[0], q[1] + d[1], q[2] + d[2], 0.0, 0.0, 0.0)
    while top > 0:
        top -= 1
        k = stack[top]
        if misses_box(box_of_node(shape, tree, k), start, along, slack):
            continue
        if not is_leaf(tree, k):
            stack[top], stack[top + 1] = 2 * k + 1, 2 * k + 2
            top += 2
            continue
        leaf = k - (tree.leaves - 1)
        for j in range(first_of_leaf(tree, leaf), first_of_leaf(tree, leaf + 1)):
            is_decided, more = through(triangle_of(posed, j), q, far, posed.off)
            if not is_decided:
                return False, 0
            count += more
    return True, count


@compiled
def where_is(posed: Posed, q: Place) -> int:
    """Return whether a place is INSIDE a posed solid, OUTSIDE, or UNDECIDED."""
    root, x = box_of_node(posed.shape, posed.tree, 0), (q[0], q[1], q[2])
    seen = sub(unrotate(posed.R, sub(x, posed.p)), root.middle)
    slack = posed.off + ROUNDING * EPS * (norm(x) + norm(posed.p) + norm(root.middle))
    for k in range(3):
        if abs(seen[k]) > root.half[k] + slack:
            return OUTSIDE
    middle = add(rotate(posed.R, root.middle), posed.p)
    reach = 4.0 * (norm(root.half) + norm(sub(x, middle)))
    for ray in RAYS:
        is_decided, count = count_through(posed, q, add_scaled((0.0, 0.0, 0.0), reach, ray))
        if is_decided:
            return INSIDE if count > 0 else OUTSIDE
    return UNDECIDED


@compiled
def is_beneath_within(
    T: Triangle,
    posed: Posed,
) -> bool:
    """Return whether the space just beneath a triangle that crosses no surface is in a solid."""
    for shares in PLACES:
        where = where_is(posed, place_on(T, shares))
        if where != UNDECIDED:
            return where == INSIDE
    return False
